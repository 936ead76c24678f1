//! Per frame, one tile, one thread, no locks: from rates to triangles.

/// Lattice and trim loops of one tile -> triangles of its trimmed cells, proven conforming.
pub mod trim;
