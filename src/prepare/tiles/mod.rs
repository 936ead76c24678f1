//! Regions -> tiles with closed loops: everything about a face that needs no other face.

pub(super) mod arcs;
pub(super) mod arrangement;
pub(super) mod critical;
pub(super) mod cuts;
pub(super) mod draft;
pub(super) mod face;
pub(super) mod grid;
mod joints;
pub(super) mod meeting;
pub(super) mod windings;
