//! Bernstein algebra, derivative bounds, exact predicates. Knows no surfaces.

pub(crate) mod box_tree;
pub(crate) mod boxes;

pub(crate) mod buckets;
pub(crate) mod sets;

mod bit_mix;
pub(crate) use bit_mix::BitMix;

/// Products, elevation, subdivision and evaluation in the Bernstein basis.
pub mod bernstein;

/// Exact signs of orientation.
pub mod predicates;

/// Upper bounds of derivatives of polynomial and rational Bézier nets.
pub mod bounds;
