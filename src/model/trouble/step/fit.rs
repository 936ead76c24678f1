//! Why an offset or an approximation fails.

use std::fmt;

/// Why an offset, or the approximation of a curve or surface without exact form, fails.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FitTrouble {
    /// The reference direction of an offset curve is parallel to its basis.
    AlongBasis,
    /// The offset leaves nothing, or a point.
    Vanishes {
        /// The offset's distance, millimetres.
        distance_mm: f64,
        /// What remains.
        leaves: &'static str,
    },
    /// The basis of an offset curve has a corner.
    Corner {
        /// Parameter of the corner.
        parameter: f64,
    },
    /// An offset curve has no direction at some parameter.
    NoDirection,
    /// The surface to offset has no normal at some point.
    NoNormal,
    /// The approximation misses the tolerance after refinement.
    Inexact {
        /// The approximation.
        what: &'static str,
        /// Its error, millimetres.
        error_mm: f64,
    },
    /// The approximation needs too many control points.
    TooManyPoints {
        /// Maximum number of control points.
        limit: usize,
    },
}

impl fmt::Display for FitTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::AlongBasis => write!(f, "the reference direction of the offset is parallel to its basis"),
            Self::Vanishes { distance_mm, leaves } => write!(f, "an offset by {distance_mm} mm leaves {leaves}"),
            Self::Corner { parameter } => {
                write!(f, "the basis of the offset has a corner at its parameter {parameter}")
            }
            Self::NoDirection => write!(f, "the offset curve has no direction somewhere"),
            Self::NoNormal => write!(f, "the surface to offset has no normal somewhere"),
            Self::Inexact { what, error_mm } => write!(f, "{what} is still {error_mm:.2e} mm off after refinement"),
            Self::TooManyPoints { limit } => {
                write!(f, "the offset surface needs more than {limit} control points; allow a larger tolerance")
            }
        }
    }
}
