//! A tolerance, or cameras on a scene -> the tolerance that applies in each box of a part.

pub(super) mod box_tolerance;
pub(super) mod camera;
pub(super) mod part_camera;
pub(super) mod path;
pub(super) mod tolerance;
