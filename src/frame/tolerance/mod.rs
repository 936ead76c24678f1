//! A tolerance, or views of a scene -> the tolerance that applies in each box of a part.

pub(super) mod object_tolerance;

pub(super) mod part_camera;

pub(super) mod box_tolerance;
