//! Pointer movements to cameras: orbit, pan and zoom about a point that keeps its place in the picture.

use super::camera::{Camera, Projection};
use super::view_point::ViewPoint;
use glam::{DQuat, DVec3};
use std::f64::consts::FRAC_PI_2;

impl Camera {
    /// The camera's direction as a [`ViewPoint`] of distance 1, to fit other cameras from the same side.
    #[must_use]
    pub fn view_point(&self) -> ViewPoint {
        let [right, _, back] = self.axes();
        ViewPoint {
            yaw: right.y.atan2(right.x).to_degrees(),
            pitch: back.z.clamp(-1.0, 1.0).asin().to_degrees(),
            distance: 1.0,
        }
    }

    /// Orbits about `pivot` by angles in radians, first about the vertical, then about the picture's horizontal axis.
    ///
    /// Positive `round` turns the scene counter-clockwise seen from above; positive `upwards` shows more of its
    /// underside. The tilt stops at straight up and straight down. A level horizon stays level.
    #[must_use]
    pub fn orbit(&self, pivot: DVec3, round: f64, upwards: f64) -> Self {
        let [right, up, back] = self.axes();
        // Only cameras that are upside down (never level ones) have the poles the other way round: no clamp there.
        let pitch = back.z.clamp(-1.0, 1.0).asin();
        let tilt = if up.z < 0.0 { upwards } else { (pitch - upwards).clamp(-FRAC_PI_2, FRAC_PI_2) - pitch };
        let turn = DQuat::from_rotation_z(-round) * DQuat::from_axis_angle(right, -tilt);
        let about = |point: DVec3| pivot + turn * (point - pivot);
        Self { eye: about(self.eye), forward: turn * self.forward, up: turn * up, ..*self }
    }

    /// Pans the camera so that the point at the depth of `pivot` under pixel `from` moves to pixel `to`.
    /// Pixels count from the upper left corner of a picture of `size` pixels.
    #[must_use]
    pub fn pan(&self, pivot: DVec3, from: [f64; 2], to: [f64; 2], size: [f64; 2]) -> Self {
        let shift = self.at_depth_of(pivot, from, size) - self.at_depth_of(pivot, to, size);
        Self { eye: self.eye + shift, ..*self }
    }

    /// Zooms about `point`, which keeps its place in the picture. Multiplies the distances of eye and target to `point`
    /// by `factor` (above 0), and the height of an orthographic view.
    #[must_use]
    pub fn zoom(&self, point: DVec3, factor: f64) -> Self {
        let projection = match self.projection {
            Projection::Orthographic { height } => Projection::Orthographic { height: factor * height },
            perspective @ Projection::Perspective { .. } => perspective,
        };
        Self { eye: point + factor * (self.eye - point), forward: factor * self.forward, projection, ..*self }
    }

    /// Unprojects a pixel position to the depth of `pivot`, or of the target if a perspective camera has `pivot` level
    /// with the eye or behind it. `at` counts from the upper left corner of a picture of `size` pixels.
    #[must_use]
    pub fn at_depth_of(&self, pivot: DVec3, at: [f64; 2], size: [f64; 2]) -> DVec3 {
        let [.., back] = self.axes();
        let depth = |point: DVec3| (self.eye - point).dot(back);
        let is_seen = depth(pivot) > 0.0 || self.is_orthographic();
        let wanted = if is_seen { depth(pivot) } else { depth(self.target()) };
        let (start, direction) = self.line_of_sight(at, size);
        start + direction * (wanted / -direction.dot(back))
    }

    /// Projects a point to pixels from the upper left corner. `None` for points behind a perspective camera.
    #[must_use]
    pub fn pixel_of(&self, point: DVec3, [width, height]: [f64; 2]) -> Option<[f64; 2]> {
        let [right, up, back] = self.axes();
        let depth = (self.eye - point).dot(back);
        let scale = height / self.height_at(depth);
        let offset = |axis: DVec3| scale * (point - self.eye).dot(axis);
        (scale > 0.0).then(|| [0.5 * width + offset(right), 0.5 * height - offset(up)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [f64; 2] = [800.0, 600.0];

    fn camera(yaw: f64, pitch: f64) -> Camera {
        let corners = (0..8).map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)) * 100.0);
        ViewPoint { yaw, pitch, distance: 1.0 }.fit(corners, SIZE[0] / SIZE[1])
    }

    fn pixel(camera: &Camera, point: DVec3) -> [f64; 2] {
        camera.pixel_of(point, SIZE).unwrap_or_else(|| panic!("{point} is behind {camera:?}"))
    }

    fn near(a: [f64; 2], b: [f64; 2]) -> bool {
        (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-6
    }

    #[test]
    fn projection_and_line_of_sight_are_inverse() {
        let perspective = camera(30.0, 20.0);
        for camera in [perspective, perspective.orthographic()] {
            for at in [[0.0, 0.0], [400.0, 300.0], [799.0, 13.0]] {
                let (start, direction) = camera.line_of_sight(at, SIZE);
                assert!(near(pixel(&camera, start + 77.0 * direction), at), "{at:?}");
                assert!(near(pixel(&camera, camera.at_depth_of(DVec3::splat(50.0), at, SIZE)), at));
            }
            let centre = camera.ray((399, 299), (800, 600)).1 + camera.ray((400, 300), (800, 600)).1;
            assert!((centre.normalize() + camera.axes()[2]).length() < 1e-12);
        }
        let behind = perspective.eye + perspective.axes()[2];
        assert_eq!(perspective.pixel_of(behind, SIZE), None);
        assert!(near(pixel(&perspective.orthographic(), behind), [400.0, 300.0]));
    }

    #[test]
    fn orthographic_camera_keeps_size_at_target_depth() {
        let perspective = camera(30.0, 20.0);
        let parallel = perspective.orthographic();
        let [right, up, _] = perspective.axes();
        let point = perspective.target() + 17.0 * right - 4.0 * up;
        assert!(near(pixel(&parallel, point), pixel(&perspective, point)));
        let back = parallel.perspective();
        assert!(back.eye.distance(perspective.eye) < 1e-9 && back.projection == perspective.projection);
        assert_eq!((back.perspective(), parallel.orthographic()), (back, parallel));
    }

    #[test]
    fn view_point_inverts_fit() {
        for (yaw, pitch) in [(0.0, 0.0), (45.0, 35.0), (-90.0, 0.0), (170.0, -60.0), (30.0, 90.0), (-20.0, -90.0)] {
            let back = camera(yaw, pitch).view_point();
            assert!((back.yaw - yaw).abs() < 1e-9 && (back.pitch - pitch).abs() < 1e-5, "{back:?}");
        }
    }

    #[test]
    fn orbiting_keeps_the_pivot_and_the_horizon() {
        let start = camera(30.0, 20.0);
        let pivot = DVec3::new(90.0, 10.0, 70.0);
        let mut camera = start;
        for k in 0..200 {
            camera = camera.orbit(pivot, 0.1, if k < 60 { 0.07 } else { -0.05 });
            assert!((camera.eye.distance(pivot) - start.eye.distance(pivot)).abs() < 1e-6);
            assert!(camera.axes()[0].z.abs() < 1e-9, "the horizon is level");
            assert!(camera.axes()[1].z > -1e-9, "the camera is upright");
        }
        let around = start.orbit(pivot, std::f64::consts::TAU, 0.0);
        assert!(around.eye.distance(start.eye) < 1e-9);
        assert!((start.orbit(pivot, 0.0, -9.0).view_point().pitch - 90.0).abs() < 1e-5, "the tilt stops at 90°");
        // The scene follows the pointer: to the right and down.
        let seen = pixel(&start, DVec3::new(50.0, 0.0, 50.0));
        let centre = DVec3::splat(50.0);
        assert!(pixel(&start.orbit(centre, 0.1, 0.0), DVec3::new(50.0, 0.0, 50.0))[0] > seen[0]);
        assert!(pixel(&start.orbit(centre, 0.0, -0.1), DVec3::new(50.0, 0.0, 50.0))[1] > seen[1]);
    }

    #[test]
    fn panning_moves_the_point_with_the_pointer() {
        let camera = camera(-20.0, 40.0);
        let point = DVec3::new(100.0, 0.0, 100.0);
        let from = pixel(&camera, point);
        let to = [from[0] + 123.0, from[1] - 45.0];
        let slid = camera.pan(point, from, to, SIZE);
        assert!(near(pixel(&slid, point), to));
        assert!((slid.axes()[2] - camera.axes()[2]).length() < 1e-12);
        let behind = camera.pan(camera.eye + camera.axes()[2], from, to, SIZE);
        assert!(near(pixel(&behind, camera.target()), [400.0 + 123.0, 300.0 - 45.0]));
        let parallel = camera.orthographic();
        let slid = parallel.pan(DVec3::ZERO, from, to, SIZE);
        let moved = pixel(&parallel, point);
        assert!(near(pixel(&slid, point), [moved[0] + 123.0, moved[1] - 45.0]));
    }

    #[test]
    fn zooming_keeps_the_point_in_place() {
        let camera = camera(60.0, -10.0);
        let point = DVec3::new(100.0, 100.0, 0.0);
        let closer = camera.zoom(point, 0.25);
        assert!(near(pixel(&closer, point), pixel(&camera, point)));
        assert!((closer.eye.distance(point) - 0.25 * camera.eye.distance(point)).abs() < 1e-9);
        assert!((closer.axes()[2] - camera.axes()[2]).length() < 1e-12);
        let parallel = camera.orthographic();
        let closer = parallel.zoom(point, 0.25);
        assert!(near(pixel(&closer, point), pixel(&parallel, point)));
        let across = |camera: &Camera| pixel(camera, point + camera.axes()[0])[0] - pixel(camera, point)[0];
        assert!((across(&closer) - 4.0 * across(&parallel)).abs() < 1e-6);
    }
}
