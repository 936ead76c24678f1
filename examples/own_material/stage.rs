//! What stands around the model: a floor and a cube, as triangles, and the light.

use glam::DVec3;
use trimtess::view::{Camera, ViewPoint};

/// Position relative to the camera's eye, normal, linear colour.
pub type Corner = [[f32; 3]; 3];

/// A floor under the model and a cube before it.
pub struct Stage {
    pub middle: DVec3,
    /// How far the model goes from its middle.
    pub reach: f64,
    cube: [DVec3; 2],
}

impl Stage {
    /// Around a box, for a camera that looks at it.
    pub fn of([low, high]: [DVec3; 2], camera: &Camera) -> Self {
        let (middle, reach) = (0.5 * (low + high).with_z(2.0 * low.z), 0.5 * (high - low).length());
        let aside = (camera.eye - middle).with_z(0.0).normalize().rotate_z(0.35);
        let (foot, half) = (middle + 1.0 * reach * aside, 0.13 * reach);
        let cube = [foot - DVec3::new(half, half, 0.0), foot + DVec3::new(half, half, 2.0 * half)];
        Self { middle, reach, cube }
    }

    /// A light over the shoulder that sees all that casts shadows.
    pub fn light(&self, [low, high]: [DVec3; 2]) -> Camera {
        let boxes = [[low, high], self.cube];
        let corner = |[a, b]: [DVec3; 2], k: u32| {
            DVec3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { a[axis] } else { b[axis] }))
        };
        let corners = boxes.into_iter().flat_map(|of| (0..8).map(move |k| corner(of, k)));
        ViewPoint { yaw: -40.0, pitch: 50.0, distance: 1.0 }.fit_orthographic(corners, 1.0)
    }

    /// Half the side of the floor.
    pub fn floor(&self) -> f64 {
        5.0 * self.reach
    }

    /// Box around floor and cube.
    pub fn bounds(&self) -> [DVec3; 2] {
        let wide = DVec3::new(self.floor(), self.floor(), 0.0);
        [self.middle - wide, (self.middle + wide).max(self.cube[1])]
    }

    /// The triangles.
    pub fn corners(&self, eye: DVec3) -> Vec<Corner> {
        let quad = |middle: DVec3, right: DVec3, up: DVec3, colour: [f32; 3]| {
            let normal = right.cross(up).normalize().as_vec3().to_array();
            let ends = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            ends.map(|(x, y)| [(middle + x * right + y * up - eye).as_vec3().to_array(), normal, colour])
        };
        let mut all = quad(self.middle, DVec3::X * self.floor(), DVec3::Y * self.floor(), [0.62; 3]).to_vec();
        let (middle, half) = (0.5 * (self.cube[0] + self.cube[1]), 0.5 * (self.cube[1] - self.cube[0]));
        for axis in 0..3 {
            let side = |k: usize| DVec3::AXES[(axis + k) % 3] * half[(axis + k) % 3];
            for way in [1.0, -1.0] {
                all.extend(quad(middle + way * side(0), side(1), way * side(2), [0.85, 0.24, 0.06]));
            }
        }
        all
    }
}
