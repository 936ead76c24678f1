//! A tile's loops and lattice -> vertices: tessellants, positions, normals.

/// Points and normals of tessellants, and what lattices share with them.
pub mod evaluate;

/// Points and normals of lattices.
pub mod lattice;

pub(super) mod scratch;

pub(super) mod boundary;

pub(super) mod places;
