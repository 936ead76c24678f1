//! Bernstein algebra, derivative bounds, exact predicates. Knows no surfaces.

pub(crate) mod bisection;
pub(crate) mod bits;
pub(crate) mod boxes;

pub(crate) mod tree;

pub(crate) mod box_tree;
pub(crate) mod buckets;
pub(crate) mod foot;
pub(crate) mod hilbert;
pub(crate) mod lanes;
pub(crate) mod least_squares;
pub(crate) mod links;
pub(crate) mod matching;
pub(crate) mod order;
pub(crate) mod rows;
pub(crate) mod sets;
pub(crate) mod sphere_tree;
pub(crate) mod stops;
pub(crate) mod sums;

mod bit_mix;
pub(crate) use bit_mix::BitMix;
// For keys that a file chooses, such as places: nobody knows which of them collide.
pub(crate) use foldhash::fast::RandomState as Seeded;

/// Evaluation and subdivision in the Bernstein basis.
pub mod bernstein;

/// Exact orientation predicates.
pub mod predicates;

mod fitted_bounds;
/// Upper bounds on the derivatives of polynomial and rational Bézier nets.
pub mod bounds;
