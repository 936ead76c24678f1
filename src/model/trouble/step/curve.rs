//! Why a curve of a file, or a point on one, cannot be read.

use std::fmt;

/// Why a curve of a file, or a point on one, cannot be read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum CurveTrouble {
    /// Both ends of an edge lie at the same parameter of its curve.
    SameParameter,
    /// The curve's ends are in the wrong order.
    WrongOrder,
    /// A bounded curve is needed, but the curve has no ends of its own.
    Endless {
        /// The curve's type.
        keyword: String,
    },
    /// A polyline has fewer than two distinct points, or a circle has no radius.
    OnePoint,
    /// A trim is neither a point nor a parameter.
    Trim,
    /// A point's parameter lies outside the domain of its curve or surface.
    Beyond {
        /// The parameter.
        parameter: f64,
        /// First and last parameter.
        domain: (f64, f64),
    },
    /// A point or a trim is stated by its parameter on a composite curve; the reader does not keep these.
    OnComposite,
    /// A line is extruded along itself.
    AlongItself,
}

impl fmt::Display for CurveTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SameParameter => write!(f, "both ends of the edge lie at the same parameter of its curve"),
            Self::WrongOrder => write!(f, "the curve's ends are in the wrong order"),
            Self::Endless { keyword } => write!(f, "{keyword} has no ends of its own"),
            Self::OnePoint => write!(f, "the curve is a single point"),
            Self::Trim => write!(f, "a trim is neither a point nor a parameter"),
            Self::Beyond { parameter, domain: (low, high) } => {
                write!(f, "a point at parameter {parameter} is outside the domain from {low} to {high}")
            }
            Self::OnComposite => write!(f, "parameters on composite curves are not read"),
            Self::AlongItself => write!(f, "a line is extruded along itself"),
        }
    }
}
