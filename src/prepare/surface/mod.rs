//! Surfaces and curves -> rational Bézier pieces, and bounds of what these can do.

pub(super) mod arc_bounds;
pub(super) mod bounds;
/// NURBS to Bézier pieces.
pub mod decompose;
pub(super) mod tables;
