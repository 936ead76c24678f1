//! Face drafts -> parts: shared edges numbered, faces oriented consistently and closed against each other.

pub(super) mod chains;
pub(super) mod closing;
pub(super) mod fill;
pub(super) mod images;
pub(super) mod limits;
pub(super) mod memory;
pub(super) mod orient;
pub(super) mod part;
pub(super) mod prepared;
pub(super) mod sample_images;
pub(super) mod shells;
pub(super) mod topology;
