//! Random cameras, and the screen-space error of their pictures.

use crate::random::SplitMix;
use glam::{DVec2, DVec3};
use std::sync::Arc;
use trimtess::mesh::{Batch, MemorySink, SceneInstance};
use trimtess::prepare::Prepared;
use trimtess::view::{Camera, Projection, View};

impl SplitMix {
    pub(crate) fn direction(&mut self) -> DVec3 {
        DVec3::from([(); 3].map(|()| self.range(-1.0, 1.0))).normalize_or(DVec3::X)
    }

    /// A camera at a multiple of the radius from the middle, looking near the middle.
    pub(crate) fn view(&mut self, [low, high]: [DVec3; 2], away: (f64, f64)) -> View {
        let (middle, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
        let eye = middle + self.direction() * radius * self.range(away.0, away.1);
        let target = middle + self.direction() * radius * self.range(0.0, 0.5);
        let perspective = Projection::Perspective { fov_y: self.range(0.2, 1.8), near: 0.0 };
        let parallel = Projection::Orthographic { height: radius * self.range(0.2, 3.0) };
        View {
            camera: Camera {
                eye,
                forward: target - eye,
                up: self.direction(),
                projection: if self.unit() < 0.7 { perspective } else { parallel },
            },
            size: (self.range(100.0, 2000.0) as u32, self.range(100.0, 1200.0) as u32),
            deviation_px: self.range(0.3, 3.0),
            size_px: (self.unit() < 0.3).then_some(self.range(20.0, 60.0)),
            angle: 1.5,
        }
    }
}

/// Position of a point in the picture, in pixels from its middle; `None` if off-screen or nearer than `near`.
pub(crate) fn project(view: &View, near: f64, p: DVec3) -> Option<DVec2> {
    let forward = view.camera.forward.normalize();
    let right = forward.cross(view.camera.up).normalize();
    let local = p - view.camera.eye;
    let (x, y, depth) = (right.dot(local), right.cross(forward).dot(local), forward.dot(local));
    let size = DVec2::new(f64::from(view.size.0), f64::from(view.size.1));
    let per_length = match view.camera.projection {
        Projection::Perspective { fov_y, .. } if depth > near => 0.5 * size.y / (0.5 * fov_y).tan() / depth,
        Projection::Perspective { .. } => return None,
        Projection::Orthographic { height } => size.y / height,
    };
    let p = DVec2::new(x, y) * per_length;
    p.abs().cmple(0.5 * size).all().then_some(p)
}

/// The largest screen-space error of a batch's triangles, in pixels, and the number of on-screen sample points.
pub(crate) fn worst(
    prepared: &Prepared,
    view: &View,
    near: f64,
    batch: &Batch,
    instance: &SceneInstance,
) -> (f64, usize) {
    const PLACES: [[f64; 3]; 7] = [
        [0.5, 0.5, 0.0],
        [0.0, 0.5, 0.5],
        [0.5, 0.0, 0.5],
        [0.34, 0.33, 0.33],
        [0.6, 0.2, 0.2],
        [0.2, 0.6, 0.2],
        [0.2, 0.2, 0.6],
    ];
    let part = &prepared.parts[batch.part.index()];
    let tile = &part.tiles[batch.tile.0 as usize];
    let face = part.face_of(tile);
    let mesh = &batch.mesh;
    let uv = |v: u32| face.to_patches(mesh.uvs[v as usize].as_dvec2());
    let world = |p: DVec3| instance.transform.transform_point3(p);
    let (mut worst, mut seen) = (0.0_f64, 0);
    for corners in &mesh.triangles {
        let [p, q] = [corners.map(|v| mesh.positions[v as usize]), corners.map(|v| uv(v).extend(0.0))];
        for w in PLACES {
            let point = p[0] * w[0] + p[1] * w[1] + p[2] * w[2];
            let Some(drawn) = project(view, near, world(point)) else { continue };
            let mut uv = (q[0] * w[0] + q[1] * w[1] + q[2] * w[2]).truncate();
            let mut next = face.patches.point(uv.x, uv.y);
            for _ in 0..8 {
                let d = face.patches.derivatives(uv.x, uv.y);
                if d.point.distance(point) <= next.distance(point) {
                    next = d.point;
                }
                let off = point - d.point;
                let [a, b, c] = [d.du.dot(d.du), d.du.dot(d.dv), d.dv.dot(d.dv)];
                let (x, y, det) = (off.dot(d.du), off.dot(d.dv), a * c - b * b);
                if det <= 1e-14 * (a + c) * (a + c) {
                    break;
                }
                uv += DVec2::new(c * x - b * y, a * y - b * x) / det;
                uv = uv.clamp(tile.min, tile.max);
            }
            let Some(exact) = project(view, near, world(next)) else { continue };
            worst = worst.max(drawn.distance(exact));
            seen += 1;
        }
    }
    (worst, seen)
}

/// The largest deviation of any instance's tile as a multiple of the tolerance, and the number of sample points.
pub(crate) fn measured(prepared: &Arc<Prepared>, view: &View, near: f64, frame: &MemorySink) -> (f64, usize) {
    let (mut most, mut seen) = (0.0_f64, 0);
    for instance in &frame.scene.instances {
        for batch in frame.batches.iter().filter(|batch| batch.part == instance.part) {
            let (pixels, points) = worst(prepared, view, near, batch, instance);
            most = most.max(pixels / view.deviation_px);
            seen += points;
        }
    }
    (most, seen)
}
