//! The camera: where it is, what it looks at and how it projects; with the screen-space error of its picture, a view.

use glam::{DMat4, DVec3, dcamera};

/// Projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case", deny_unknown_fields))]
pub enum Projection {
    /// Perspective projection from the eye.
    Perspective {
        /// Full vertical field of view, radians, above 0 and below π.
        fov_y: f64,
        /// Depth of the near plane, millimetres, 0 or more. Pictures may begin farther away, never nearer.
        near: f64,
    },
    /// Parallel projection. The position of the eye along `forward` does not matter: points behind it are shown too.
    Orthographic {
        /// Height of the visible part of the world, millimetres, above 0.
        height: f64,
    },
}

/// A camera in world coordinates, millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Camera {
    /// Position of the camera.
    pub eye: DVec3,
    /// Viewing direction, of any length above 0. The length is the distance to the target, the point that viewers orbit
    /// and zoom about; pictures and plans do not depend on it.
    pub forward: DVec3,
    /// Direction that points up in the picture, of any length above 0; not parallel to `forward`.
    pub up: DVec3,
    /// Projection.
    pub projection: Projection,
}

impl Camera {
    /// Vertical field of view of fitted cameras, radians: 30°, a long lens as is usual in CAD.
    pub const FOV_Y: f64 = std::f64::consts::FRAC_PI_6;

    /// A camera at `eye` that looks at `target`; they must differ.
    #[must_use]
    pub fn looking_at(eye: DVec3, target: DVec3, up: DVec3, projection: Projection) -> Self {
        Self { eye, forward: target - eye, up, projection }
    }

    /// The point that the camera looks at.
    #[must_use]
    pub fn target(&self) -> DVec3 {
        self.eye + self.forward
    }

    /// Unit vectors to the right, up and towards the eye.
    #[must_use]
    pub fn axes(&self) -> [DVec3; 3] {
        let back = (-self.forward).normalize_or(DVec3::NEG_Y);
        let right = self.up.cross(back).try_normalize().unwrap_or_else(|| back.any_orthonormal_vector());
        [right, back.cross(right), back]
    }

    /// Whether it is orthographic.
    #[must_use]
    pub fn is_orthographic(&self) -> bool {
        matches!(self.projection, Projection::Orthographic { .. })
    }

    /// Converts to an orthographic camera. Objects at the depth of the target keep their size.
    #[must_use]
    pub fn orthographic(&self) -> Self {
        let height = self.height_at(self.forward.length());
        Self { projection: Projection::Orthographic { height }, ..*self }
    }

    /// Converts to a perspective camera of [`FOV_Y`](Self::FOV_Y) and near depth 0. Objects at the depth of the target
    /// keep their size. Perspective cameras are returned unchanged.
    #[must_use]
    pub fn perspective(&self) -> Self {
        let Projection::Orthographic { height } = self.projection else { return *self };
        let [.., back] = self.axes();
        let distance = 0.5 * height / (0.5 * Self::FOV_Y).tan();
        let projection = Projection::Perspective { fov_y: Self::FOV_Y, near: 0.0 };
        let target = self.target();
        Self::looking_at(target + distance * back, target, self.up, projection)
    }

    /// World to camera transform: x right, y up, z towards the eye.
    #[must_use]
    pub fn view_matrix(&self) -> DMat4 {
        dcamera::rh::view::look_to_mat4(self.eye, self.forward.normalize(), self.up)
    }

    /// Camera to clip space transform: y up, reversed depth with 1 at `near`.
    ///
    /// Depth 0 is at infinity in perspective (`far` is ignored) and at `far` in orthographic projection, where `near`
    /// may be negative.
    #[must_use]
    pub fn projection_matrix(&self, aspect: f64, near: f64, far: f64) -> DMat4 {
        match self.projection {
            Projection::Perspective { fov_y, .. } => {
                dcamera::rh::proj::directx::perspective_infinite_reverse(fov_y, aspect, near)
            }
            Projection::Orthographic { height } => {
                let (x, y) = (0.5 * aspect * height, 0.5 * height);
                dcamera::rh::proj::directx::orthographic(-x, x, -y, y, far, near)
            }
        }
    }

    /// Height of the view in millimetres at distance `depth` in front of the eye.
    pub(crate) fn height_at(&self, depth: f64) -> f64 {
        match self.projection {
            Projection::Perspective { fov_y, .. } => 2.0 * (0.5 * fov_y).tan() * depth,
            Projection::Orthographic { height } => height,
        }
    }

    /// The ray through the centre of pixel (`x`, `y`), counted from the upper left: its origin and unit direction.
    #[must_use]
    pub fn ray(&self, (x, y): (u32, u32), (width, height): (u32, u32)) -> (DVec3, DVec3) {
        self.line_of_sight([f64::from(x) + 0.5, f64::from(y) + 0.5], [f64::from(width), f64::from(height)])
    }

    /// The ray through a position in the picture, in pixels from the upper left corner: its origin and unit direction.
    /// The origin is the eye, or in orthographic projection a point at the depth of the eye.
    #[must_use]
    pub fn line_of_sight(&self, [x, y]: [f64; 2], [width, height]: [f64; 2]) -> (DVec3, DVec3) {
        let place = DVec3::new(x - 0.5 * width, 0.5 * height - y, 0.0) * (self.height_at(1.0) / height);
        let world = self.view_matrix().inverse();
        match self.projection {
            Projection::Perspective { .. } => (self.eye, world.transform_vector3(place - DVec3::Z).normalize()),
            Projection::Orthographic { .. } => {
                (self.eye + world.transform_vector3(place), world.transform_vector3(DVec3::NEG_Z))
            }
        }
    }
}

/// A camera and the screen-space error that its image may have.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Width and height of the image in pixels, above 0.
    pub size: (u32, u32),
    /// Maximum distance in the image between triangles and exact surface, pixels, above 0.
    pub deviation_px: f64,
    /// Maximum length in the image of a cell's diagonal or an edge's segment, pixels; `None` = no limit.
    pub size_px: Option<f64>,
    /// Maximum turn of the normal across a cell and of the tangent along a segment, radians.
    pub angle: f64,
}

impl View {
    /// Angle tolerance that suits pictures: 30 degrees, in radians. Normals are exact at vertices; this bounds the
    /// error of interpolating them.
    pub const ANGLE: f64 = 30.0_f64.to_radians();
}

/// The corners of a box from its least and its greatest one: x changes first, z last.
#[must_use]
pub fn box_corners(bounds: [DVec3; 2]) -> [DVec3; 8] {
    std::array::from_fn(|k| DVec3::from([0, 1, 2].map(|axis| bounds[k >> axis & 1][axis])))
}
