//! Why an offset or an approximation fails.

/// Why an offset, or the approximation of a curve or surface without exact form, fails.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitTrouble {
    /// The reference direction of an offset curve is parallel to its basis.
    #[error("the reference direction of the offset is parallel to its basis")]
    AlongBasis,
    /// The offset leaves nothing, or a point.
    #[error("an offset by {distance_mm} mm leaves {leaves}")]
    Vanishes {
        /// The offset's distance, millimetres.
        distance_mm: f64,
        /// What remains.
        leaves: &'static str,
    },
    /// The basis of an offset curve has a corner.
    #[error("the basis of the offset has a corner at its parameter {parameter}")]
    Corner {
        /// Parameter of the corner.
        parameter: f64,
    },
    /// An offset curve has no direction at some parameter.
    #[error("the offset curve has no direction somewhere")]
    NoDirection,
    /// The surface to offset has no normal at some point.
    #[error("the surface to offset has no normal somewhere")]
    NoNormal,
    /// The approximation misses the tolerance after refinement.
    #[error("{what} is still {error_mm:.2e} mm off after refinement")]
    Inexact {
        /// The approximation.
        what: &'static str,
        /// Its error, millimetres.
        error_mm: f64,
    },
    /// The approximation needs too many control points.
    #[error("the offset surface needs more than {limit} control points; allow a larger tolerance")]
    TooManyPoints {
        /// Maximum number of control points.
        limit: usize,
    },
}
