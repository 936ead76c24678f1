//! Edges' curves -> their images in a surface's parameter plane.

pub(super) mod uv_curve;
pub(super) mod uv_loop;
pub(super) mod polygon;
pub(super) mod foot;
pub(super) mod lead;
pub(super) mod projector;
mod pcurve;
