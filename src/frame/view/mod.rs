//! Cameras and tolerances -> the tolerance that holds at each place of a part.

pub(super) mod asked;
pub(super) mod camera;
pub(super) mod path;
pub(super) mod sight;
pub(super) mod tolerance;
