//! An instance's transform -> positions, normals and windings in the world.

use glam::{DAffine3, DMat3, DVec3};

/// Part to world, for positions, normals and windings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    transform: DAffine3,
    /// The inverse transpose up to scale (the cofactor matrix, negated if mirrored). Outward normals stay outward.
    normals: DMat3,
    mirrored: bool,
}

impl Placement {
    pub(crate) fn new(transform: &DAffine3) -> Self {
        let m = transform.matrix3;
        let mirrored = m.determinant() < 0.0;
        let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let normals = if mirrored { -cofactors } else { cofactors };
        Self { transform: *transform, normals, mirrored }
    }

    /// The position in the world. Depends only on the bits of `point`: equal points stay equal. Never -0.0.
    pub(crate) fn position(&self, point: DVec3) -> DVec3 {
        self.transform.transform_point3(point) + DVec3::ZERO
    }

    /// The unit normal in the world; +z where the part's normal is zero.
    pub(crate) fn normal(&self, normal: glam::Vec3) -> DVec3 {
        (self.normals * normal.as_dvec3()).normalize_or(DVec3::Z)
    }

    /// Orders the corners counter-clockwise seen from outside.
    pub(crate) fn winding(&self, [a, b, c]: [u32; 3]) -> [u32; 3] {
        if self.mirrored { [a, c, b] } else { [a, b, c] }
    }
}
