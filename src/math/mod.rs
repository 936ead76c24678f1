//! Bernstein algebra, derivative bounds, exact predicates. Knows no surfaces.

pub(crate) mod bits;
pub(crate) use bits::BitMix;
// For keys that a file chooses, such as places: nobody knows which of them collide.
pub(crate) use foldhash::fast::RandomState as Seeded;

pub(crate) mod boxes;
pub(crate) mod sphere_tree;
pub(crate) mod keyed;
pub(crate) mod graph;
pub(crate) mod solve;
pub(crate) mod lanes;

/// Evaluation and subdivision in the Bernstein basis.
pub mod bernstein;

/// Exact orientation predicates.
pub mod predicates;

mod fitted_bounds;
/// Upper bounds on the derivatives of polynomial and rational Bézier nets.
pub mod bounds;
