//! Regions -> tiles with closed loops: everything about a face that needs no other face.

pub(super) mod grid;
pub(super) mod cuts;
pub(super) mod windings;
pub(super) mod arrangement;
pub(super) mod traced;
pub(super) mod extent;
pub(super) mod draft;
pub(super) mod arcs;
pub(super) mod meeting;
pub(super) mod critical;
mod joints;
mod borders;
mod crossings;
pub(super) mod face;
