//! A tolerance, or cameras on a scene -> the tolerance that applies in each box of a part.

pub(super) mod asked;
pub(super) mod camera;
pub(super) mod path;
pub(super) mod sight;
pub(super) mod tolerance;
