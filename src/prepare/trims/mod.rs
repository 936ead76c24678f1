//! Free trimming curves -> loops of exact arcs, and edges in space along them.

pub(super) mod spans;
pub(super) mod intersect;
pub(super) mod wraps;
pub(super) mod stretches;
pub(super) mod free_region;
pub(super) mod free_faces;
pub(super) mod free_edges;
