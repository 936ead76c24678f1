//! Why a file's degrees, knots, points and weights are not a B-spline.

use std::fmt;

/// Why a file's degrees, knots, points and weights are not a B-spline.
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
    /// The number of weights is not the number of control points.
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
    /// A knot is less than its predecessor.
    KnotsDecrease,
    /// The multiplicities of the knots do not add up.
    Multiplicities {
        /// The required sum.
        wanted: usize,
        /// Number of control points, in this direction.
        points: usize,
        /// The degree.
        degree: usize,
    },
    /// The domain is empty: its first and last knot are equal.
    EmptyDomain,
    /// The points do not make a whole number of Bézier pieces.
    BezierCount {
        /// Number of control points, in this direction.
        points: usize,
        /// The degree.
        degree: usize,
    },
    /// A curve is discontinuous at a knot.
    CurveJumps {
        /// The knot.
        knot: f64,
    },
    /// A surface is discontinuous along a knot line.
    SurfaceJumps {
        /// The knot's direction: 0 for u, 1 for v.
        axis: usize,
        /// The knot.
        knot: f64,
    },
    /// Rows of the control net have different lengths.
    RowLengths,
}

impl fmt::Display for SplineTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Degree { degree, points } => write!(f, "degree {degree} does not fit {points} control points"),
            Self::WeightCount { weights, points } => write!(f, "{weights} weights for {points} control points"),
            Self::Weight { weight } => write!(f, "a weight of {weight} is not positive"),
            Self::KnotsDecrease => write!(f, "the knots decrease"),
            Self::Multiplicities { wanted, points, degree } => {
                write!(f, "knot multiplicities do not add up to {wanted} ({points} points, degree {degree})")
            }
            Self::EmptyDomain => write!(f, "the knot range is empty"),
            Self::BezierCount { points, degree } => {
                write!(f, "{points} points are not a chain of Bézier pieces of degree {degree}")
            }
            Self::CurveJumps { knot } => write!(f, "the curve jumps at knot {knot}"),
            Self::SurfaceJumps { axis, knot } => write!(f, "the surface jumps at {} = {knot}", ['u', 'v'][axis]),
            Self::RowLengths => write!(f, "the rows of the control net have different lengths"),
        }
    }
}
