//! Why degrees, knots, points and weights of a file make no B-spline.

use std::fmt;

/// Why degrees, knots, points and weights of a file make no B-spline.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SplineTrouble {
    /// The degree is 0, too high, or too high for the number of control points.
    Degree {
        /// As stated.
        degree: usize,
        /// Number of control points, in this direction.
        points: usize,
    },
    /// There is not one weight for each control point.
    WeightCount {
        /// Number of weights.
        weights: usize,
        /// Number of control points.
        points: usize,
    },
    /// A weight is not positive.
    Weight {
        /// As stated.
        weight: f64,
    },
    /// A knot is less than the one before it.
    KnotsDecrease,
    /// The multiplicities of the knots do not add up.
    Multiplicities {
        /// What they should add up to.
        wanted: usize,
        /// Number of control points, in this direction.
        points: usize,
        /// The degree.
        degree: usize,
    },
    /// The first and the last knot of the domain are equal.
    EmptyDomain,
    /// The points make no whole number of Bézier pieces.
    BezierCount {
        /// Number of control points, in this direction.
        points: usize,
        /// The degree.
        degree: usize,
    },
    /// A curve is broken at a knot.
    CurveJumps {
        /// Where.
        knot: f64,
    },
    /// A surface is broken along a knot.
    SurfaceJumps {
        /// The knot's direction: 0 for u, 1 for v.
        axis: usize,
        /// Where.
        knot: f64,
    },
    /// Rows of the control net have different lengths.
    RowLengths,
}

impl fmt::Display for SplineTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Degree { degree, points } => write!(f, "degree {degree} with {points} control points"),
            Self::WeightCount { weights, points } => write!(f, "{weights} weights for {points} control points"),
            Self::Weight { weight } => write!(f, "a weight of {weight}"),
            Self::KnotsDecrease => write!(f, "knots that decrease"),
            Self::Multiplicities { wanted, points, degree } => {
                write!(f, "knot multiplicities do not add up to {wanted} ({points} points, degree {degree})")
            }
            Self::EmptyDomain => write!(f, "an empty knot range"),
            Self::BezierCount { points, degree } => {
                write!(f, "{points} points make no Bezier chain of degree {degree}")
            }
            Self::CurveJumps { knot } => write!(f, "the curve jumps at knot {knot}"),
            Self::SurfaceJumps { axis, knot } => write!(f, "the surface jumps at {} = {knot}", ['u', 'v'][axis]),
            Self::RowLengths => write!(f, "rows of different lengths in the control net"),
        }
    }
}
