//! Free trims: oriented curves in a surface's (u,v) and the rule that decides which points they keep (Kumar & Manocha
//! 1995, §2.1 and §2.2). The curves may be open or closed, and may cross.

use super::{NurbsCurve2, SplineError};
use crate::math::boxes::around;
use glam::DVec2;

/// Ends of a curve or of its pieces within this share of the curve's extent are one point.
const SAME_END: f64 = 1e-9;

/// Decides which points of a surface free trimming curves keep.
///
/// With u to the right and v up, a curve keeps its *left* side, as in B-reps. (The paper draws v to the right and u up.
/// Its domain is mirrored: the right side of a curve there is the left side here. Reverse curves that are taken from
/// its figures.)
///
/// An open curve is closed along the border of the domain, counter-clockwise from its end to its start: it becomes the
/// loop around its left side.
///
/// On a closed surface, a closed curve that crosses the seam continues at the other side of the domain. So does an open
/// curve that ends one period from its start. On an unbounded surface, the curves must bound the region that they keep.
///
#[doc = include_str!("../../docs/figures/rules.svg")]
///
#[doc = include_str!("../../docs/figures/open_curves.svg")]
///
#[doc = include_str!("../../docs/figures/mirrored.svg")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TrimRule {
    /// Keeps what lies left of all curves (the paper's rule). A counter-clockwise loop trims its outside, a clockwise
    /// loop its inside. For a curve that crosses itself, winding numbers decide what is inside.
    #[default]
    Handedness,
    /// Keeps points where the winding numbers of all curves do not sum to zero. A clockwise loop inside a
    /// counter-clockwise one is a hole; loops of the same direction are united.
    NonZero,
    /// Keeps points where the winding numbers of all curves sum to an odd number. Directions do not matter.
    EvenOdd,
}

/// One piece of a trimming curve.
#[derive(Clone, Debug, PartialEq)]
pub enum TrimPiece {
    /// A NURBS pcurve of any degree, rational or not, over its whole domain.
    Nurbs(NurbsCurve2),
    /// At least two points, joined by straight lines. Every point becomes a tessellant, whatever the tolerance (the
    /// paper's footnote 1).
    Polyline(Vec<DVec2>),
}

/// An oriented trimming curve: pieces head to tail, open or closed.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimCurve {
    /// At least one.
    pub pieces: Vec<TrimPiece>,
}

/// The free trims of a face. Without curves the whole surface is kept, whatever the rule.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FreeTrims {
    /// Which points the curves keep.
    pub rule: TrimRule,
    /// In any order.
    pub curves: Vec<TrimCurve>,
}

impl FreeTrims {
    /// Lower and upper corner of the box of all control points; `[+∞, -∞]` without any.
    #[must_use]
    pub fn bounds(&self) -> [DVec2; 2] {
        around(self.curves.iter().flat_map(|c| &c.pieces).flat_map(TrimPiece::points).copied())
    }
}

impl TrimPiece {
    /// A Bézier curve over the parameters 0 to 1; `weights` is empty for a polynomial one.
    #[must_use]
    pub fn bezier(points: Vec<DVec2>, weights: Vec<f64>) -> Self {
        Self::Nurbs(NurbsCurve2::bezier(points, weights))
    }

    /// First and last point; `None` for a piece without points.
    fn ends(&self) -> Option<[DVec2; 2]> {
        match self {
            Self::Nurbs(curve) => {
                let (a, b) = curve.domain();
                Some([curve.point(a), curve.point(b)])
            }
            Self::Polyline(points) => Some([*points.first()?, *points.last()?]),
        }
    }

    fn points(&self) -> &[DVec2] {
        match self {
            Self::Nurbs(curve) => &curve.points,
            Self::Polyline(points) => points,
        }
    }
}

impl From<TrimPiece> for TrimCurve {
    fn from(piece: TrimPiece) -> Self {
        Self { pieces: vec![piece] }
    }
}

impl TrimCurve {
    /// A NURBS curve.
    #[must_use]
    pub fn nurbs(curve: NurbsCurve2) -> Self {
        TrimPiece::Nurbs(curve).into()
    }

    /// A Bézier curve; `weights` is empty for a polynomial one.
    #[must_use]
    pub fn bezier(points: Vec<DVec2>, weights: Vec<f64>) -> Self {
        TrimPiece::bezier(points, weights).into()
    }

    /// A polyline through `points`.
    #[must_use]
    pub fn polyline(points: Vec<DVec2>) -> Self {
        TrimPiece::Polyline(points).into()
    }

    /// The closed polyline through `corners` and back to the first.
    #[must_use]
    pub fn polygon(mut corners: Vec<DVec2>) -> Self {
        corners.extend(corners.first().copied());
        Self::polyline(corners)
    }

    /// The ellipse with half axes `a` (where it starts) and `b`, as an exact rational quadratic of four spans.
    ///
    /// Counter-clockwise if `b` lies left of `a`, else clockwise.
    #[must_use]
    pub fn ellipse(centre: DVec2, a: DVec2, b: DVec2) -> Self {
        let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
        let half = std::f64::consts::FRAC_1_SQRT_2;
        Self::nurbs(NurbsCurve2 {
            degree: 2,
            knots: vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0],
            points: corners.map(|(x, y)| centre + a * f64::from(x) + b * f64::from(y)).to_vec(),
            weights: (0..9).map(|k| if k % 2 == 0 { 1.0 } else { half }).collect(),
        })
    }

    /// The counter-clockwise circle.
    #[must_use]
    pub fn circle(centre: DVec2, radius: f64) -> Self {
        Self::ellipse(centre, DVec2::X * radius, DVec2::Y * radius)
    }

    /// Reverses the curve.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let turned = |piece: &TrimPiece| match piece {
            TrimPiece::Nurbs(curve) => TrimPiece::Nurbs(curve.reversed()),
            TrimPiece::Polyline(points) => TrimPiece::Polyline(points.iter().rev().copied().collect()),
        };
        Self { pieces: self.pieces.iter().rev().map(turned).collect() }
    }

    /// Whether it ends where it starts, within 10⁻⁹ of its extent.
    ///
    /// # Panics
    /// If the first or the last piece is a curve for which [`NurbsCurve::check`](super::NurbsCurve::check) fails.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        let start = self.pieces.first().and_then(TrimPiece::ends);
        let end = self.pieces.last().and_then(TrimPiece::ends);
        start.zip(end).is_some_and(|(start, end)| start[0].distance(end[1]) <= SAME_END * self.extent())
    }

    /// Diagonal of the box of all control points.
    fn extent(&self) -> f64 {
        let [low, high] = around(self.pieces.iter().flat_map(TrimPiece::points).copied());
        (high - low).length()
    }

    /// Checks that all pieces are valid and meet end to start.
    ///
    /// # Errors
    /// The first piece that is invalid, else the first that does not start where the previous one ends.
    pub fn check(&self) -> Result<(), TrimError> {
        if self.pieces.is_empty() {
            return Err(TrimError::NoPieces);
        }
        for (piece, stated) in self.pieces.iter().enumerate() {
            match stated {
                TrimPiece::Nurbs(curve) => curve.check().map_err(|error| TrimError::Spline { piece, error })?,
                TrimPiece::Polyline(points) if points.len() < 2 => {
                    return Err(TrimError::TooFewPoints { piece, points: points.len() });
                }
                TrimPiece::Polyline(points) => {
                    if let Some(index) = points.iter().position(|p| !p.is_finite()) {
                        return Err(TrimError::Spline { piece, error: SplineError::Point { index } });
                    }
                }
            }
        }
        let limit = SAME_END * self.extent();
        for (k, pair) in self.pieces.windows(2).enumerate() {
            let ends = [&pair[0], &pair[1]].map(TrimPiece::ends);
            if let [Some([_, end]), Some([start, _])] = ends
                && end.distance(start) > limit
            {
                return Err(TrimError::Gap { piece: k + 1, end, start, limit });
            }
        }
        Ok(())
    }
}

/// Why [`TrimCurve::check`] rejects a curve.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrimError {
    /// The curve has no pieces.
    #[error("the curve has no pieces")]
    NoPieces,
    /// A piece is not a valid NURBS curve, or a point of a polyline is not finite.
    #[error("piece {piece}: {error}")]
    Spline {
        /// Which of the curve's pieces.
        piece: usize,
        /// Why.
        error: SplineError,
    },
    /// A polyline has fewer than two points.
    #[error("piece {piece}: a polyline of {points} points; at least 2 are needed")]
    TooFewPoints {
        /// Which of the curve's pieces.
        piece: usize,
        /// Number of points.
        points: usize,
    },
    /// A piece does not start where the previous one ends.
    #[error(
        "piece {piece} starts at ({}, {}), {:.3e} from the end of the previous piece (limit {limit:.3e})",
        .start.x, .start.y, .end.distance(*.start)
    )]
    Gap {
        /// Which of the curve's pieces.
        piece: usize,
        /// Last point of the previous piece.
        end: DVec2,
        /// First point of this piece.
        start: DVec2,
        /// Largest allowed distance between them.
        limit: f64,
    },
}
