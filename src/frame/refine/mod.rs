//! A tile's triangles -> the same with folds and excessive deviation removed where possible.

pub(super) mod lift;
pub(super) mod web;
pub(super) mod unfold;
pub(super) mod refill;
pub(super) mod narrow;
