//! Why an offset, or what stands for a curve or surface without exact form, cannot be had.

use std::fmt;

/// Why an offset, or what stands for a curve or surface without exact form, cannot be had.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FitTrouble {
    /// The reference direction of an offset curve runs along its basis.
    AlongBasis,
    /// The offset leaves nothing, or a point.
    Vanishes {
        /// The offset's distance, millimetres.
        distance_mm: f64,
        /// What is left.
        leaves: &'static str,
    },
    /// The basis of an offset curve has a corner.
    Corner {
        /// Where, in its parameter.
        parameter: f64,
    },
    /// An offset curve has no direction at some parameter.
    NoDirection,
    /// The surface to offset has no normal at some point.
    NoNormal,
    /// The approximation stays beyond the tolerance.
    Inexact {
        /// What is approximated.
        what: &'static str,
        /// By how much it is off, millimetres.
        error_mm: f64,
    },
    /// The approximation takes too many control points.
    TooManyPoints {
        /// How many it may have.
        limit: usize,
    },
}

impl fmt::Display for FitTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::AlongBasis => write!(f, "the reference direction of the offset runs along its basis"),
            Self::Vanishes { distance_mm, leaves } => write!(f, "an offset by {distance_mm} mm leaves {leaves}"),
            Self::Corner { parameter } => {
                write!(f, "the basis of the offset has a corner at its parameter {parameter}")
            }
            Self::NoDirection => write!(f, "the offset curve has no direction somewhere"),
            Self::NoNormal => write!(f, "the surface to offset has no normal somewhere"),
            Self::Inexact { what, error_mm } => write!(f, "{what} is still {error_mm:.2e} mm off after refinement"),
            Self::TooManyPoints { limit } => {
                write!(f, "an offset surface of more than {limit} control points; allow a larger tolerance")
            }
        }
    }
}
