//! Plans for cameras: what is asked in pixels is kept in the picture, wherever the camera stands, at no more than it needs.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::{DAffine3, DQuat, DVec2, DVec3};
use std::sync::Arc;
use trimtess::frame::{Plan, Projection, View, plan_for_view};
use trimtess::mesh::{Batch, MemorySink, SceneInstance, check_scene};
use trimtess::model::{Instance, Model, ModelBuilder, shapes};
use trimtess::parallel::{Session, SessionOptions, serial};
use trimtess::prepare::{PrepareOptions, Prepared, prepare};

/// SplitMix64.
struct Draw(u64);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn range(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    fn direction(&mut self) -> DVec3 {
        DVec3::from([(); 3].map(|()| self.range(-1.0, 1.0))).normalize_or(DVec3::X)
    }

    /// A camera at a multiple of the radius from the middle, looking about there.
    fn view(&mut self, [low, high]: [DVec3; 2], away: (f64, f64)) -> View {
        let (middle, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
        let eye = middle + self.direction() * radius * self.range(away.0, away.1);
        let target = middle + self.direction() * radius * self.range(0.0, 0.5);
        let perspective = Projection::Perspective { fov_y: self.range(0.2, 1.8), near: 0.0 };
        let parallel = Projection::Orthographic { height: radius * self.range(0.2, 3.0) };
        View {
            eye,
            forward: target - eye,
            up: self.direction(),
            projection: if self.unit() < 0.7 { perspective } else { parallel },
            size: (self.range(100.0, 2000.0) as u32, self.range(100.0, 1200.0) as u32),
            deviation_px: self.range(0.3, 3.0),
            size_px: (self.unit() < 0.3).then_some(self.range(20.0, 60.0)),
            angle: 1.5,
        }
    }
}

fn prepared(model: Model) -> Arc<Prepared> {
    Arc::new(prepare(model, &PrepareOptions::DEFAULT).expect("within the limits"))
}

fn shape(name: &str) -> Arc<Prepared> {
    prepared(shapes::by_name(name).unwrap())
}

/// A part twice, once turned and three times as large.
fn two_sizes(name: &str) -> Arc<Prepared> {
    let mut model = ModelBuilder::new("two");
    let part = model.part(shapes::by_name(name).unwrap().parts.swap_remove(0));
    model.place(part, DAffine3::IDENTITY);
    let turn = DQuat::from_rotation_y(1.0);
    let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(3.0), turn, DVec3::new(60.0, 10.0, -20.0));
    model.instance(Instance { part, transform, colour: None, name: String::new() });
    prepared(model.finish().unwrap())
}

fn mesh(prepared: &Arc<Prepared>, plan: &Plan) -> MemorySink {
    let mut sink = MemorySink::default();
    let report = serial(prepared, plan, false, &mut sink).unwrap();
    assert!(report.degraded.is_empty(), "{:?}", report.degraded);
    sink
}

/// Where a point is in the picture, in pixels from its middle; `None` beside the picture, and nearer than `near`.
fn project(view: &View, near: f64, p: DVec3) -> Option<DVec2> {
    let forward = view.forward.normalize();
    let right = forward.cross(view.up).normalize();
    let local = p - view.eye;
    let (x, y, depth) = (right.dot(local), right.cross(forward).dot(local), forward.dot(local));
    let size = DVec2::new(f64::from(view.size.0), f64::from(view.size.1));
    let per_length = match view.projection {
        Projection::Perspective { fov_y, .. } if depth > near => 0.5 * size.y / (0.5 * fov_y).tan() / depth,
        Projection::Perspective { .. } => return None,
        Projection::Orthographic { height } => size.y / height,
    };
    let p = DVec2::new(x, y) * per_length;
    p.abs().cmple(0.5 * size).all().then_some(p)
}

/// The most pixels by which points of a batch's triangles miss the surface, where they are in the picture; and how many are.
fn worst(prepared: &Prepared, view: &View, near: f64, batch: &Batch, instance: &SceneInstance) -> (f64, usize) {
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
    let face = &part.faces[part.face_of(tile)];
    let mesh = &batch.mesh;
    let uv = |v: u32| {
        let natural = mesh.uvs[v as usize].as_dvec2();
        DVec2::new(face.maps[0].to_nurbs(natural.x), face.maps[1].to_nurbs(natural.y))
    };
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

/// The most deviation of any instance's tile as a share of what is asked, and how many points were measured.
fn measured(prepared: &Arc<Prepared>, view: &View, near: f64, frame: &MemorySink) -> (f64, usize) {
    let (mut most, mut seen) = (0.0_f64, 0);
    for instance in &prepared.scene.instances {
        for batch in frame.batches.iter().filter(|batch| batch.part.0 == instance.part) {
            let (pixels, points) = worst(prepared, view, near, batch, instance);
            most = most.max(pixels / view.deviation_px);
            seen += points;
        }
    }
    (most, seen)
}

#[test]
fn every_tile_keeps_the_pixels_asked_for_and_no_border_opens() {
    let mut draw = Draw(1);
    for name in ["torus", "sphere", "cylinder", "wave", "flower", "teapot"] {
        let prepared = shape(name);
        let (mut most, mut all) = (0.0_f64, 0);
        for _ in 0..8 {
            let view = draw.view(prepared.bounds.unwrap(), (0.9, 4.0));
            let plan = plan_for_view(&prepared, &view);
            assert_eq!(plan.shortfall, None, "{name} {view:?}");
            let frame = mesh(&prepared, &plan);
            let (share, seen) = measured(&prepared, &view, 0.05 * prepared.scene.parts[0].radius, &frame);
            assert!(share <= 1.0, "{name}: {share} times what is asked by {view:?}");
            let facts = check_scene(&frame).total;
            assert_eq!(facts.is_closed(), !["wave", "flower", "teapot"].contains(&name), "{name} {view:?}");
            (most, all) = (most.max(share), all + seen);
        }
        assert!(most > 0.3 && all > 10_000, "{name}: {most} of what is asked at {all} points");
    }
}

#[test]
fn the_instance_that_shows_most_decides() {
    let mut draw = Draw(2);
    let prepared = two_sizes("torus");
    for _ in 0..12 {
        let view = draw.view(prepared.bounds.unwrap(), (0.5, 3.0));
        let frame = mesh(&prepared, &plan_for_view(&prepared, &view));
        let (share, _) = measured(&prepared, &view, 0.15 * prepared.scene.parts[0].radius, &frame);
        assert!(share <= 1.0, "{share} times what is asked by {view:?}");
    }
}

#[test]
fn what_is_far_is_coarse_beside_what_is_near() {
    let prepared = shape("teapot");
    let [low, high] = prepared.bounds.unwrap();
    let height = 0.5 * (low.z + high.z);
    let view = View {
        eye: DVec3::new(high.x + 20.0, 0.0, height),
        forward: -DVec3::X,
        up: DVec3::Z,
        projection: Projection::Perspective { fov_y: 1.0, near: 1.0 },
        size: (1000, 800),
        deviation_px: 0.5,
        size_px: None,
        angle: 1.5,
    };
    let plan = plan_for_view(&prepared, &view);
    let depth = |tile: usize| view.eye.x - prepared.parts[0].tiles[tile].centre.x;
    let chord = |tile: usize| plan.parts[0].tiles[tile].chord;
    let by_depth = |a: &usize, b: &usize| depth(*a).total_cmp(&depth(*b));
    let all = 0..prepared.parts[0].tiles.len();
    let (near, far) = (all.clone().min_by(by_depth).unwrap(), all.max_by(by_depth).unwrap());
    let (ratio, depths) = (chord(far) / chord(near), depth(far) / depth(near));
    assert!(ratio > 0.7 * depths && depths > 4.0, "{ratio} at {depths} times the distance");
    // With parallel lines of sight nothing is far.
    let parallel = View { projection: Projection::Orthographic { height: 100.0 }, ..view };
    let back = View { eye: view.eye + DVec3::X * 1e4, ..parallel };
    let plan = plan_for_view(&prepared, &parallel);
    assert!(plan.parts[0].tiles.iter().all(|tile| tile.chord == 0.5 * 100.0 / 800.0));
    assert_eq!(plan, plan_for_view(&prepared, &back));
}

#[test]
fn a_camera_inside_costs_no_explosion() {
    let mut draw = Draw(3);
    for name in ["teapot", "torus", "flower"] {
        let prepared = shape(name);
        let bounds = prepared.bounds.unwrap();
        let mut most = 0;
        for k in 0..24 {
            let mut view = draw.view(bounds, (0.0, 0.7));
            view.projection = Projection::Perspective { fov_y: 1.0, near: 0.0 };
            view.size = (1920, 1080);
            (view.deviation_px, view.size_px) = (0.5, None);
            if k % 2 == 0 {
                // On the surface.
                let tile = &prepared.parts[0].tiles[draw.range(0.0, prepared.parts[0].tiles.len() as f64) as usize];
                let face = &prepared.parts[0].faces[prepared.parts[0].face_of(tile)];
                let uv = tile.min + (tile.max - tile.min) * DVec2::new(draw.unit(), draw.unit());
                view.eye = face.patches.point(uv.x, uv.y);
            }
            let plan = plan_for_view(&prepared, &view);
            assert_eq!(plan.shortfall, None, "{name} {view:?}");
            let cells = plan.parts[0].tiles.iter().map(|tile| u64::from(tile.cells().0) * u64::from(tile.cells().1));
            most = most.max(cells.sum());
        }
        assert!(most < 500_000, "{name}: {most} cells");
        assert!(most > 1000, "{name}: {most} cells");
    }
}

#[test]
fn all_workers_make_the_same_and_no_camera_is_told() {
    let prepared = shape("teapot");
    let view = Draw(4).view(prepared.bounds.unwrap(), (1.0, 1.5));
    let plan = Arc::new(plan_for_view(&prepared, &view));
    let alone = mesh(&prepared, &plan);
    for workers in [1, 2, 3, 8] {
        let options = SessionOptions::DEFAULT.with_workers(workers).with_edge_lines(false);
        let mut session = Session::start(Arc::clone(&prepared), &options).unwrap();
        let mut frame = MemorySink::default();
        session.frame(&plan, &mut frame).unwrap();
        assert!(frame.batches.iter().zip(&alone.batches).all(|(a, b)| a.tile == b.tile && a.mesh == b.mesh));
        assert_eq!(frame.batches.len(), alone.batches.len());
    }
    for broken in [
        View { eye: DVec3::NAN, ..view },
        View { forward: DVec3::ZERO, ..view },
        View { up: view.forward, ..view },
        View { size: (0, 100), ..view },
        View { projection: Projection::Perspective { fov_y: f64::NAN, near: 0.0 }, ..view },
        View { projection: Projection::Perspective { fov_y: 1.0, near: f64::INFINITY }, ..view },
        View { projection: Projection::Orthographic { height: 0.0 }, ..view },
    ] {
        let plan = plan_for_view(&prepared, &broken);
        assert!(plan.shortfall.is_some_and(|s| s.unusable), "{broken:?}");
        let cells = plan.parts[0].tiles.iter().map(|tile| tile.cells().0 * tile.cells().1);
        assert!(cells.max() < Some(100));
    }
}
