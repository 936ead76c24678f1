//! Numbers and signs.

/// Exact signs of plane geometry: the one door through which topology is decided.
pub mod predicates;
