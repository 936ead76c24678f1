//! The tolerance of each part -> lattice lines of every tile, tessellants of every edge.

pub(super) mod limits;
pub(super) mod rows;
pub(super) mod output;
pub(super) mod density;
pub(super) mod directions;
pub(super) mod lattice;
pub(super) mod tile_bounds;
pub(super) mod tessellants;
pub(super) mod lists;
pub(super) mod targets;
pub(super) mod make;
pub(super) mod damage;
