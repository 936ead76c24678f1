//! Numbers and signs.

/// Bernstein polynomials: bases, products, restriction.
pub mod bernstein;
