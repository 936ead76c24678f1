//! What stands around the model: a floor and a block, as triangles, and the light.

use glam::DVec3;
use trimtess::view::{Camera, ViewPoint};

/// Position relative to the camera's eye, normal, linear colour.
pub(crate) type Corner = [[f32; 3]; 3];

/// A floor under the model and a block before it.
pub(crate) struct Stage {
    pub(crate) middle: DVec3,
    /// How far the model goes from its middle.
    pub(crate) reach: f64,
    block: [DVec3; 2],
}

impl Stage {
    /// Around a box, for a camera that looks at it.
    pub(crate) fn of([low, high]: [DVec3; 2], camera: &Camera) -> Self {
        let (middle, reach) = (0.5 * (low + high).with_z(2.0 * low.z), 0.5 * (high - low).length());
        let aside = (camera.eye - middle).with_z(0.0).normalize().rotate_z(0.35);
        let (foot, half) = (middle + 0.9 * reach * aside, 0.12 * reach);
        let block = [foot - DVec3::new(half, half, 0.0), foot + DVec3::new(half, half, 4.2 * half)];
        Self { middle, reach, block }
    }

    /// A light over the shoulder that sees all that casts shadows.
    pub(crate) fn light(&self, [low, high]: [DVec3; 2]) -> Camera {
        let boxes = [[low, high], self.block];
        let corner = |[a, b]: [DVec3; 2], k: u32| {
            DVec3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { a[axis] } else { b[axis] }))
        };
        let corners = boxes.into_iter().flat_map(|of| (0..8).map(move |k| corner(of, k)));
        ViewPoint { yaw: -40.0, pitch: 50.0, distance: 1.0 }.fit_orthographic(corners, 1.0)
    }

    /// Half the side of the floor.
    pub(crate) fn floor(&self) -> f64 {
        5.0 * self.reach
    }

    /// Box around floor and block.
    pub(crate) fn bounds(&self) -> [DVec3; 2] {
        let wide = DVec3::new(self.floor(), self.floor(), 0.0);
        [self.middle - wide, (self.middle + wide).max(self.block[1])]
    }

    /// The triangles.
    pub(crate) fn corners(&self, eye: DVec3) -> Vec<Corner> {
        let quad = |middle: DVec3, right: DVec3, up: DVec3, colour: [f32; 3]| {
            let normal = right.cross(up).normalize().as_vec3().to_array();
            let ends = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            ends.map(|(x, y)| [(middle + x * right + y * up - eye).as_vec3().to_array(), normal, colour])
        };
        let mut all = quad(self.middle, DVec3::X * self.floor(), DVec3::Y * self.floor(), [0.4; 3]).to_vec();
        let (middle, half) = (0.5 * (self.block[0] + self.block[1]), 0.5 * (self.block[1] - self.block[0]));
        for axis in 0..3 {
            let side = |k: usize| DVec3::AXES[(axis + k) % 3] * half[(axis + k) % 3];
            for way in [1.0, -1.0] {
                all.extend(quad(middle + way * side(0), side(1), way * side(2), [0.70, 0.20, 0.03]));
            }
        }
        all
    }
}
