//! Why splines and surfaces are rejected, with the offending numbers.

use std::error::Error;
use std::fmt;

/// Highest degree. CAD kernels write up to 25. Cost grows with the square; binomials stay exact in f64 well beyond 25.
pub const MAX_DEGREE: usize = 60;

/// Why [`NurbsCurve::check`](super::NurbsCurve::check) rejects a spline.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SplineError {
    /// The degree is 0 or above [`MAX_DEGREE`].
    Degree {
        /// As given.
        degree: usize,
    },
    /// Not `knots = points + degree + 1` and `points > degree`.
    Count {
        /// Polynomial degree.
        degree: usize,
        /// Number of knots.
        knots: usize,
        /// Number of control points in this direction.
        points: usize,
    },
    /// The number of weights is neither 0 nor that of control points.
    Weights {
        /// Number of weights.
        weights: usize,
        /// Number of control points.
        points: usize,
    },
    /// A control point has an infinite or NaN coordinate.
    Point {
        /// Which.
        index: usize,
    },
    /// A weight is not a positive finite number.
    Weight {
        /// Which.
        index: usize,
        /// As given.
        weight: f64,
    },
    /// A knot is infinite or NaN.
    Knot {
        /// Which.
        index: usize,
        /// As given.
        knot: f64,
    },
    /// A knot is less than its predecessor.
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
    Multiplicity {
        /// The knot.
        knot: f64,
        /// Its multiplicity.
        multiplicity: usize,
        /// The highest multiplicity allowed.
        most: usize,
    },
    /// The domain is empty: first and last parameter are equal.
    Empty {
        /// That parameter.
        at: f64,
    },
    /// The domain is so short for its distance from zero that f64 resolves too few parameters in it.
    Coarse {
        /// First and last parameter.
        domain: (f64, f64),
    },
}

impl fmt::Display for SplineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Degree { degree } => write!(f, "degree {degree} is not in 1..={}", MAX_DEGREE),
            Self::Count { degree, knots, points } => write!(
                f,
                "{knots} knots do not fit {points} control points of degree {degree}: {} knots and at least {} points \
                 are needed",
                points + degree + 1,
                degree + 1
            ),
            Self::Weights { weights, points } => write!(f, "{weights} weights for {points} control points"),
            Self::Point { index } => write!(f, "control point {index} is not finite"),
            Self::Weight { index, weight } => write!(f, "weight {index} is {weight}, not positive and finite"),
            Self::Knot { index, knot } => write!(f, "knot {index} is {knot}"),
            Self::Decreasing { index, before, knot } => {
                write!(f, "knot {index} is {knot}, less than {before} before it")
            }
            Self::Multiplicity { knot, multiplicity, most } => {
                write!(f, "knot {knot} has multiplicity {multiplicity}; at most {most} is allowed")
            }
            Self::Empty { at } => write!(f, "the domain is the single parameter {at}"),
            Self::Coarse { domain: (a, b) } => {
                write!(f, "the domain from {a} to {b} is too short for the spacing of numbers of that size")
            }
        }
    }
}

impl Error for SplineError {}

/// Why [`Surface::check`](super::Surface::check) rejects a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A NURBS surface is invalid in this direction. Errors of weights and points are reported with u.
    Spline {
        /// `'u'` or `'v'`.
        direction: char,
        /// Why.
        error: SplineError,
    },
    /// The swept curve is invalid.
    Curve(SplineError),
    /// A radius, an angle or a length is out of its range.
    Measure {
        /// Its name and range, as in "a sphere's radius must be positive".
        what: &'static str,
        /// As given.
        value: f64,
    },
    /// The frame's axes are not orthonormal and right-handed, or the frame is not finite.
    Frame {
        /// Largest absolute entry of `axesᵀ·axes - 1` and `x × y - z`; NaN if the origin or an axis is not finite.
        error: f64,
    },
}

impl fmt::Display for SurfaceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Spline { direction, error } => write!(f, "in {direction}: {error}"),
            Self::Curve(error) => write!(f, "swept curve: {error}"),
            Self::Measure { what, value } => write!(f, "{what}, but is {value}"),
            Self::Frame { error } if error.is_nan() => write!(f, "the frame is not finite"),
            Self::Frame { error } => write!(f, "the frame is not orthonormal and right-handed (off by {error:.1e})"),
        }
    }
}

impl Error for SurfaceError {}
