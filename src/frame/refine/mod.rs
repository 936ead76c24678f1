//! A tile's triangles -> the same where they fold, or are too narrow to follow the surface.

pub(super) mod lift;
pub(super) mod narrow;
pub(super) mod refill;
pub(super) mod unfold;
pub(super) mod web;
