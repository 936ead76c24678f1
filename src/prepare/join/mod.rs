//! Face drafts -> parts: shared edges numbered, faces oriented consistently and closed against each other.

pub(super) mod chains;
pub(super) mod shells;
pub(super) mod against;
pub(super) mod outline;
pub(super) mod rays;
pub(super) mod orient;
pub(super) mod fill;
pub(super) mod images;
pub(super) mod content;
pub(super) mod kept;
pub(super) mod prepared;
pub(super) mod memory;
pub(super) mod closing;
pub(super) mod sample_images;
pub(super) mod topology;
pub(super) mod limits;
pub(super) mod part;
