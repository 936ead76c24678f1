//! A tile's loops and lattice -> vertices: tessellants, positions, normals.

/// Points and normals of lattices and tessellants.
pub mod evaluate;

mod lattice;

pub(super) mod scratch;

pub(super) mod boundary;

pub(super) mod places;
