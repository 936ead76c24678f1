//! Regions -> tiles with closed loops: everything about a face that needs no other face.

mod grid;
mod windings;
mod arrangement;
pub(super) mod traced;
pub(super) mod extent;
pub(super) mod draft;
mod arcs;
mod meeting;
mod critical;
mod crossings;
pub(super) mod face;
