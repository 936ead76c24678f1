//! Face drafts -> parts: shared edges numbered, faces oriented consistently and closed against each other.

pub(super) mod chains;
pub(super) mod shells;
mod against;
mod rays;
mod orient;
mod fill;
pub(super) mod content;
pub(super) mod kept;
pub(super) mod prepared;
mod sample_images;
pub(super) mod memory;
mod closing;
mod topology;
pub(super) mod part;
