//! Why a file's degrees, knots, points and weights are not a B-spline.

/// Why a file's degrees, knots, points and weights are not a B-spline.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SplineTrouble {
    /// The degree is 0, too high, or too high for the number of control points.
    #[error("degree {degree} does not fit {points} control points")]
    Degree {
        /// As stated.
        degree: usize,
        /// Number of control points, in this direction.
        points: usize,
    },
    /// The number of weights is not the number of control points.
    #[error("{weights} weights for {points} control points")]
    WeightCount {
        /// Number of weights.
        weights: usize,
        /// Number of control points.
        points: usize,
    },
    /// A weight is not positive.
    #[error("a weight of {weight} is not positive")]
    Weight {
        /// As stated.
        weight: f64,
    },
    /// A knot is less than its predecessor.
    #[error("the knots decrease")]
    KnotsDecrease,
    /// The multiplicities of the knots do not add up.
    #[error("knot multiplicities do not add up to {wanted} ({points} points, degree {degree})")]
    Multiplicities {
        /// The required sum.
        wanted: usize,
        /// Number of control points, in this direction.
        points: usize,
        /// The degree.
        degree: usize,
    },
    /// The domain is empty: its first and last knot are equal.
    #[error("the knot range is empty")]
    EmptyDomain,
    /// The points do not make a whole number of Bézier pieces.
    #[error("{points} points are not a chain of Bézier pieces of degree {degree}")]
    BezierCount {
        /// Number of control points, in this direction.
        points: usize,
        /// The degree.
        degree: usize,
    },
    /// A curve is discontinuous at a knot.
    #[error("the curve jumps at knot {knot}")]
    CurveJumps {
        /// The knot.
        knot: f64,
    },
    /// A surface is discontinuous along a knot line.
    #[error("the surface jumps at {} = {knot}", ['u', 'v'][*.axis])]
    SurfaceJumps {
        /// The knot's direction: 0 for u, 1 for v.
        axis: usize,
        /// The knot.
        knot: f64,
    },
    /// Rows of the control net have different lengths.
    #[error("the rows of the control net have different lengths")]
    RowLengths,
}
