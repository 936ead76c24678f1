//! Cameras, and what their pictures may show wrong.

use glam::DVec3;

/// How a camera makes its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case", deny_unknown_fields))]
pub enum Projection {
    /// Lines of sight meet in the eye.
    Perspective {
        /// The full angle between the picture's top and bottom, radians, above 0 and below π.
        fov_y: f64,
        /// Depth from which on things are shown, millimetres, 0 or more.
        near: f64,
    },
    /// Lines of sight are parallel: how far things are from the eye does not matter, nor on which side of it they are.
    Orthographic {
        /// How much of the world is between the picture's top and bottom, millimetres, above 0.
        height: f64,
    },
}

/// A camera, and what its picture may show wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct View {
    /// Where the camera is, world, millimetres.
    pub eye: DVec3,
    /// Where it looks, of any length above 0.
    pub forward: DVec3,
    /// What points up in the picture, of any length above 0; not along `forward`.
    pub up: DVec3,
    /// How it makes its picture.
    pub projection: Projection,
    /// Width and height of the picture in pixels, above 0.
    pub size: (u32, u32),
    /// Largest distance in the picture between triangles and exact surface, pixels, above 0.
    pub deviation_px: f64,
    /// Largest length in the picture of a cell's side or an edge's segment, pixels; `None` = no limit.
    pub size_px: Option<f64>,
    /// Largest turning of the normal across a cell, radians.
    pub angle: f64,
}
