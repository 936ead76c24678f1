//! Why splines and surfaces are rejected, with the offending numbers.

/// Highest degree. CAD kernels write up to 25. Cost grows with the square; binomials stay exact in f64 well beyond 25.
pub const MAX_DEGREE: usize = 60;

/// Why [`NurbsCurve::check`](super::NurbsCurve::check) or a reader of files rejects a spline.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SplineError {
    /// The degree is 0 or above [`MAX_DEGREE`].
    #[error("degree {degree} is not in 1..={}", MAX_DEGREE)]
    Degree {
        /// As given.
        degree: usize,
    },
    /// Not `knots = points + degree + 1` and `points > degree`.
    #[error(
        "{knots} knots do not fit {points} control points of degree {degree}: {} knots and at least {} points are \
         needed",
        .points + .degree + 1, .degree + 1
    )]
    Count {
        /// Polynomial degree.
        degree: usize,
        /// Number of knots.
        knots: usize,
        /// Number of control points in this direction.
        points: usize,
    },
    /// A file states no more control points than the degree.
    #[error("{points} control points are too few for degree {degree}: at least {} are needed", .degree + 1)]
    Points {
        /// Polynomial degree.
        degree: usize,
        /// Number of control points in this direction.
        points: usize,
    },
    /// The number of weights is neither 0 nor that of control points.
    #[error("{weights} weights for {points} control points")]
    Weights {
        /// Number of weights.
        weights: usize,
        /// Number of control points.
        points: usize,
    },
    /// A control point has an infinite or NaN coordinate.
    #[error("control point {index} is not finite")]
    Point {
        /// Which.
        index: usize,
    },
    /// A weight is not within 1e-30 to 1e30.
    #[error("weight {index} is {weight}, not within 1e-30 to 1e30")]
    Weight {
        /// Which.
        index: usize,
        /// As given.
        weight: f64,
    },
    /// A knot is infinite or NaN.
    #[error("knot {index} is {knot}")]
    Knot {
        /// Which.
        index: usize,
        /// As given.
        knot: f64,
    },
    /// A knot is less than its predecessor.
    #[error("knot {index} is {knot}, less than {before} before it")]
    Decreasing {
        /// Which.
        index: usize,
        /// Its predecessor.
        before: f64,
        /// As given.
        knot: f64,
    },
    /// A knot has a multiplicity above `degree` inside the domain, or above `degree + 1` elsewhere: the curve would
    /// break.
    #[error("knot {knot} has multiplicity {multiplicity}; at most {most} is allowed")]
    Multiplicity {
        /// The knot.
        knot: f64,
        /// Its multiplicity.
        multiplicity: usize,
        /// The highest multiplicity allowed.
        most: usize,
    },
    /// The two sides of a break at a knot are different points. The STEP reader removes breaks whose sides coincide.
    #[error("it jumps at knot {knot}")]
    Jump {
        /// The knot.
        knot: f64,
    },
    /// The number of control points is not that of a chain of Bézier pieces, which a file states without knots.
    #[error("{points} control points are not a chain of Bézier pieces of degree {degree}")]
    Chain {
        /// Polynomial degree.
        degree: usize,
        /// Number of control points in this direction.
        points: usize,
    },
    /// The domain is empty: first and last parameter are equal.
    #[error("the domain is the single parameter {at}")]
    Empty {
        /// That parameter.
        at: f64,
    },
    /// The domain is so short for its distance from zero that f64 resolves too few parameters in it.
    #[error("the domain from {} to {} is too short for the spacing of numbers of that size", .domain.0, .domain.1)]
    Coarse {
        /// First and last parameter.
        domain: (f64, f64),
    },
}

/// Why [`Surface::check`](super::Surface::check) rejects a surface.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A NURBS surface is invalid in this direction. Errors of weights and points are reported with u.
    #[error("in {direction}: {error}")]
    Spline {
        /// `'u'` or `'v'`.
        direction: char,
        /// Why.
        error: SplineError,
    },
    /// The swept curve is invalid.
    #[error("swept curve: {0}")]
    Curve(SplineError),
    /// A radius, an angle or a length is out of its range.
    #[error("{what}, but is {value}")]
    Measure {
        /// Its name and range, as in "a sphere's radius must be positive".
        what: &'static str,
        /// As given.
        value: f64,
    },
    /// The frame's axes are not orthonormal and right-handed, or the frame is not finite.
    #[error("the frame is {}", frame_fault(*.error))]
    Frame {
        /// Largest absolute entry of `axesᵀ·axes - 1` and `x × y - z`; NaN if the origin or an axis is not finite.
        error: f64,
    },
}

fn frame_fault(error: f64) -> String {
    if error.is_nan() {
        return "not finite".to_owned();
    }
    format!("not orthonormal and right-handed (off by {error:.1e})")
}
