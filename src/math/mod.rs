//! Numbers and signs.

/// Bernstein polynomials: bases, products, restriction.
pub mod bernstein;

/// Upper bounds of derivatives of polynomial and rational Bézier nets.
pub mod bounds;
