//! Why a curve of a file, or a point on one, cannot be read.

/// Why a curve of a file, or a point on one, cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveTrouble {
    /// Both ends of an edge lie at the same parameter of its curve.
    #[error("both ends of the edge lie at the same parameter of its curve")]
    SameParameter,
    /// The curve's ends are in the wrong order.
    #[error("the curve's ends are in the wrong order")]
    WrongOrder,
    /// A bounded curve is needed, but the curve has no ends of its own.
    #[error("{keyword} has no ends of its own")]
    Endless {
        /// The curve's type.
        keyword: String,
    },
    /// A polyline has fewer than two distinct points, a circle has no radius, or a line is trimmed to no length.
    #[error("the curve is a single point")]
    OnePoint,
    /// A trim is neither a point nor a parameter.
    #[error("a trim is neither a point nor a parameter")]
    Trim,
    /// A point's parameter lies outside the domain of its curve or surface.
    #[error("a point at parameter {parameter} is outside the domain from {} to {}", .domain.0, .domain.1)]
    Beyond {
        /// The parameter.
        parameter: f64,
        /// First and last parameter.
        domain: (f64, f64),
    },
    /// A point or a trim is stated by its parameter on a composite curve, or on a polyline that repeats points; the reader
    /// does not keep these.
    #[error("parameters on composite curves and on polylines that repeat points are not read")]
    OnComposite,
    /// A line is extruded along itself.
    #[error("a line is extruded along itself")]
    AlongItself,
}
