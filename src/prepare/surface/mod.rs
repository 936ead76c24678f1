//! Surfaces and curves -> rational Bézier pieces, and bounds on their derivatives.

/// Converts NURBS to Bézier pieces.
pub mod decompose;
pub(super) mod tables;
pub(super) mod arc_bounds;
mod cuts;
mod samples;
mod bounds;
