//! Per frame, one tile, one thread, no locks: from rates to triangles.

/// Lattice lines and parameters to points and normals.
pub mod evaluate;
