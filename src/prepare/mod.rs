//! Paid once per model: Bézier patches, shared edges, bounds.

mod bounds;
pub use bounds::{BoxBounds, CurveBounds, StripBounds, SurfaceBounds};

/// NURBS to Bézier pieces.
pub mod decompose;
pub use decompose::{BezierPatches, BezierSpline3};
