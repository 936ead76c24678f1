//! Cameras with their screen-space error.

use glam::DVec3;

/// Projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case", deny_unknown_fields))]
pub enum Projection {
    /// Perspective projection from the eye.
    Perspective {
        /// Full vertical field of view, radians, above 0 and below π.
        fov_y: f64,
        /// Depth of the near plane, millimetres, 0 or more.
        near: f64,
    },
    /// Parallel projection. The position of the eye along `forward` does not matter: points behind it are shown too.
    Orthographic {
        /// Height of the visible part of the world, millimetres, above 0.
        height: f64,
    },
}

/// A camera and the screen-space error that its image may have.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct View {
    /// Position of the camera in world space, millimetres.
    pub eye: DVec3,
    /// Viewing direction, of any length above 0.
    pub forward: DVec3,
    /// Up direction in the image, of any length above 0; not parallel to `forward`.
    pub up: DVec3,
    /// Projection.
    pub projection: Projection,
    /// Width and height of the image in pixels, above 0.
    pub size: (u32, u32),
    /// Maximum distance in the image between triangles and exact surface, pixels, above 0.
    pub deviation_px: f64,
    /// Maximum length in the image of a cell's side or an edge's segment, pixels; `None` = no limit.
    pub size_px: Option<f64>,
    /// Maximum turn of the normal across a cell and of the tangent along a segment, radians.
    pub angle: f64,
}
