//! Free trimming curves -> loops of exact arcs, and edges in space along them.

pub(super) mod spans;
mod chains;
mod intersect;
pub(super) mod free_region;
pub(super) mod free_edges;
