//! Bernstein algebra, derivative bounds, exact predicates. Knows no surfaces.

/// Products, elevation, subdivision and evaluation in the Bernstein basis.
pub mod bernstein;

/// Exact signs of orientation.
pub mod predicates;

/// Upper bounds of derivatives of polynomial and rational Bézier nets.
pub mod bounds;
