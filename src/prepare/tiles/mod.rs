//! Regions -> tiles with closed loops: everything about a face that needs no other face.

pub(super) mod arcs;
pub(super) mod arrangement;
mod borders;
pub(super) mod critical;
mod crossings;
pub(super) mod cuts;
pub(super) mod draft;
mod extent;
pub(super) mod face;
pub(super) mod grid;
mod joints;
pub(super) mod meeting;
pub(super) mod traced;
pub(super) mod windings;
