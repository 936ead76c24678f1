//! What splines and surfaces are refused for, with the numbers that show why.

use std::error::Error;
use std::fmt;

/// Highest degree. CAD kernels write up to 25; cost grows with the square, binomials stay exact in f64 well beyond.
pub const MAX_DEGREE: usize = 60;

/// Why knots, control points and weights do not make a spline.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SplineError {
    /// The degree is 0 or above [`MAX_DEGREE`].
    Degree {
        /// As given.
        degree: usize,
    },
    /// Numbers of knots, control points and degree do not fit: `knots = points + degree + 1`, `points > degree`.
    Count {
        /// Polynomial degree.
        degree: usize,
        /// Number of knots.
        knots: usize,
        /// Number of control points (in this direction).
        points: usize,
    },
    /// There are weights, but not one per control point.
    Weights {
        /// Number of weights.
        weights: usize,
        /// Number of control points.
        points: usize,
    },
    /// A control point has a coordinate that is infinite or not a number.
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
    /// A knot is infinite or not a number.
    Knot {
        /// Which.
        index: usize,
        /// As given.
        knot: f64,
    },
    /// A knot is less than the one before it.
    Decreasing {
        /// Which.
        index: usize,
        /// The knot before it.
        before: f64,
        /// As given.
        knot: f64,
    },
    /// A knot inside the domain is repeated more than `degree` times (at its ends `degree + 1`): the curve would break.
    Multiplicity {
        /// The knot.
        knot: f64,
        /// How often it stands.
        multiplicity: usize,
        /// How often it may stand.
        most: usize,
    },
    /// First and last parameter are equal.
    Empty {
        /// Both.
        at: f64,
    },
    /// The domain is so short for its distance from zero that too few parameters lie in it.
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
                write!(f, "knot {knot} stands {multiplicity} times, at most {most} are allowed")
            }
            Self::Empty { at } => write!(f, "the domain is the single parameter {at}"),
            Self::Coarse { domain: (a, b) } => {
                write!(f, "the domain from {a} to {b} is too short for numbers of that size to part it")
            }
        }
    }
}

impl Error for SplineError {}

/// Why a surface is not one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A spline surface is not one in this direction (weights and points are reported with u).
    Spline {
        /// `'u'` or `'v'`.
        direction: char,
        /// Why.
        error: SplineError,
    },
    /// The swept curve is not one.
    Curve(SplineError),
    /// A radius, an angle or a length is out of its range.
    Measure {
        /// Which, with its range.
        what: &'static str,
        /// As given.
        value: f64,
    },
    /// The frame's axes are not orthonormal and right-handed.
    Frame {
        /// Largest entry of `axesᵀ·axes - 1`, or of `x × y - z`.
        error: f64,
    },
}

impl fmt::Display for SurfaceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Spline { direction, error } => write!(f, "in {direction}: {error}"),
            Self::Curve(error) => write!(f, "swept curve: {error}"),
            Self::Measure { what, value } => write!(f, "{what}, but is {value}"),
            Self::Frame { error } => write!(f, "the frame is not orthonormal and right-handed, by {error:.1e}"),
        }
    }
}

impl Error for SurfaceError {}
