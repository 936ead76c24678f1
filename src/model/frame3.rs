//! Orthonormal placements of analytic geometry.

use glam::{DVec2, DVec3};

/// A right-handed orthonormal frame: `z = x × y`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame3 {
    /// Origin, in the part's length unit (millimetres).
    pub origin: DVec3,
    /// First axis, unit length.
    pub x: DVec3,
    /// Second axis, unit length.
    pub y: DVec3,
    /// Third axis (the axis of revolution, the normal of a plane), unit length.
    pub z: DVec3,
}

impl Frame3 {
    /// The world frame.
    pub const WORLD: Self = Self { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };

    /// Makes the frame with its third axis along `axis` and its first axis as near to `reference` as possible.
    ///
    /// `None` if `axis` has no direction. A `reference` parallel to `axis` is replaced by any perpendicular.
    #[must_use]
    pub fn from_axis(origin: DVec3, axis: DVec3, reference: DVec3) -> Option<Self> {
        let z = axis.try_normalize()?;
        let across = reference - z * reference.dot(z);
        let x = if across.length() > 1e-9 * reference.length() {
            across.try_normalize()?
        } else {
            z.any_orthonormal_vector()
        };
        Some(Self { origin, x, y: z.cross(x), z })
    }

    /// Converts local coordinates to a point in space.
    #[must_use]
    pub fn place(&self, local: DVec3) -> DVec3 {
        self.origin + self.x * local.x + self.y * local.y + self.z * local.z
    }

    /// Converts a point in space to local coordinates.
    #[must_use]
    pub fn local(&self, point: DVec3) -> DVec3 {
        let d = point - self.origin;
        DVec3::new(d.dot(self.x), d.dot(self.y), d.dot(self.z))
    }

    /// Distance of a point in space from the axis `z`, and its height above the origin along that axis.
    #[must_use]
    pub fn meridian(&self, point: DVec3) -> DVec2 {
        let local = self.local(point);
        DVec2::new(libm::hypot(local.x, local.y), local.z)
    }

    /// The vector from the axis `z` to a point in space, perpendicular to the axis.
    #[must_use]
    pub fn radial(&self, point: DVec3) -> DVec3 {
        let out = point - self.origin;
        out - self.z * out.dot(self.z)
    }
}
