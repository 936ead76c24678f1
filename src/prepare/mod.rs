//! Paid once per model: Bézier patches, shared edges, bounds.

/// NURBS to rational Bézier pieces.
pub mod decompose;

/// Tables of derivative bounds and normal turning per sub-box.
pub mod bounds;
