//! Paid once per model: Bézier patches, shared edges, bounds.

/// NURBS to rational Bézier pieces.
pub mod decompose;
