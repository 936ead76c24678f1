//! Back-face culling leaves out tiles that the picture does not show. Drawn tiles and their edges keep the tolerance.

use super::frames::path;
use super::pixels::project;
use super::{prepared, shape};
use crate::random::SplitMix;
use glam::{DVec2, DVec3};
use std::sync::Arc;
use trimtess::frame::internals::{PlacedInstances, Planner};
use trimtess::frame::{Plan, PlannerOptions};
use trimtess::model::{CurveKind, EdgeId, Frame3, Loop, NurbsCurve3, PartBuilder, ShellKind, Surface, TileId};
use trimtess::prepare::Prepared;
use trimtess::prepare::internals::{EdgeShape, TileUse};
use trimtess::view::{Camera, Projection, View};

/// The largest distance in the picture between drawn edges and their polylines, as a multiple of the tolerance.
fn worst_edge(prepared: &Prepared, view: &View, plan: &Plan) -> f64 {
    let part = &prepared.parts[0];
    let near = 0.05 * prepared.scene.parts[0].radius;
    let is_drawn = |of: &&TileUse| plan.drawn.contains(0, 0, of.tile);
    let mut worst = 0.0_f64;
    for (edge, line) in part.edges.iter().zip(&plan.parts[0].edges) {
        let EdgeShape::Curve(curve) = &edge.shape else { continue };
        if edge.uses.iter().find(is_drawn).is_none() {
            continue;
        }
        for ends in line.ts.windows(2) {
            let [from, to] = [ends[0], ends[1]].map(|t| curve.point(t));
            let shown = [0.5 * (from + to), curve.point(0.5 * (ends[0] + ends[1]))].map(|p| project(view, near, p));
            if let [Some(drawn), Some(exact)] = shown {
                worst = worst.max(drawn.distance(exact) / view.deviation_px);
            }
        }
    }
    worst
}

/// A plate along x whose far end is an arc.
fn plate() -> Arc<Prepared> {
    const SIZE: DVec3 = DVec3::new(60.0, 20.0, 4.0);
    const ANGLE: f64 = 0.25;
    let radius = 0.5 * SIZE.y / ANGLE.sin();
    let mut part = PartBuilder::new("plate");
    let shell = part.plain_shell(ShellKind::Outer);
    let frame = |z: f64| Frame3 { origin: DVec3::new(SIZE.x - radius * ANGLE.cos(), 0.0, z), ..Frame3::WORLD };
    let level = |part: &mut PartBuilder, z: f64| {
        let y = 0.5 * SIZE.y;
        let corners = [(0.0, -y), (SIZE.x, -y), (SIZE.x, y), (0.0, y)].map(|(x, y)| part.vertex(DVec3::new(x, y, z)));
        let [a, b, c, d] = corners;
        let arc = NurbsCurve3::arc(&frame(z), radius, radius, -ANGLE, ANGLE);
        let edges = [part.line(a, b), part.curve(arc, CurveKind::Circle, b, c), part.line(c, d), part.line(d, a)];
        (corners, edges)
    };
    let ((low, foot), (high, head)) = (level(&mut part, 0.0), level(&mut part, SIZE.z));
    let posts = [0, 1, 2, 3].map(|k| part.line(low[k], high[k]));
    for k in 0..4 {
        let next = (k + 1) % 4;
        let wire = vec![foot[k].along(), posts[next].along(), head[k].against(), posts[k].against()];
        let side = [-DVec3::Y, DVec3::X, DVec3::Y, -DVec3::X][k];
        let origin = part.part().vertices[low[k].index()];
        let flat = Frame3::from_axis(origin, side, DVec3::Z).unwrap();
        let surface =
            if k == 1 { Surface::Cylinder { frame: frame(0.0), radius } } else { Surface::Plane { frame: flat } };
        part.plain_face(surface, shell, vec![Loop::Edges(wire)], false);
    }
    let bottom = foot.map(EdgeId::along).to_vec();
    part.plain_face(Surface::Plane { frame: frame(0.0) }, shell, vec![Loop::Edges(bottom)], true);
    let top = head.map(EdgeId::along).to_vec();
    part.plain_face(Surface::Plane { frame: frame(SIZE.z) }, shell, vec![Loop::Edges(top)], false);
    prepared(part.finish().unwrap())
}

/// A view whose near plane cuts the far end of a plate gives it a step for each of its boxes. Then the camera flies
/// over the plate, behind that end, towards the edge between both.
#[test]
fn edges_of_culled_tiles_keep_the_tolerance_where_their_other_tile_is_drawn() {
    let prepared = plate();
    let at = |eye: DVec3, target: DVec3, near: f64| View {
        camera: Camera {
            eye,
            forward: target - eye,
            up: DVec3::Z,
            projection: Projection::Perspective { fov_y: 2.17, near },
        },
        size: (1000, 1000),
        deviation_px: 0.1,
        size_px: None,
        angle: 1.5,
    };
    let end = DVec3::new(60.5, 0.0, 2.0);
    let mut views = vec![at(end + 300.0 * DVec3::X, end, 300.0)];
    let eyes = [DVec3::new(-49.9, 40.7, 8.0), DVec3::new(31.2, 35.7, 31.4)];
    let targets = [DVec3::new(39.7, -0.6, 2.0), DVec3::new(12.0, 7.0, 2.0)];
    views.extend((0..=40).map(|k| {
        let [eye, target] = [eyes, targets].map(|[from, to]| from.lerp(to, f64::from(k) / 40.0));
        at(eye, target, 0.02)
    }));
    let options = PlannerOptions::DEFAULT.with_cull_back_faces(true);
    let (mut planner, mut placed) = (Planner::new(Arc::clone(&prepared), &options), PlacedInstances::of(&prepared));
    let (mut most, mut culled) = (0.0_f64, 0);
    for (k, view) in views.iter().enumerate() {
        let plan = Arc::clone(planner.plan(&mut placed, &[*view]));
        let worst = worst_edge(&prepared, view, &plan);
        assert!(worst <= 1.0, "frame {k}: {worst} times the tolerance");
        most = most.max(worst);
        culled += usize::from(k > 0 && !plan.drawn.contains(0, 0, TileId(1)));
    }
    assert!(most > 0.3 && culled > 30, "{most} {culled}");
}

#[test]
fn culled_tiles_are_not_in_the_picture() {
    let prepared = shape("washer");
    let mut planner = Planner::new(Arc::clone(&prepared), &PlannerOptions::DEFAULT.with_cull_back_faces(true));
    let mut placed = PlacedInstances::of(&prepared);
    let mut draw = SplitMix(4);
    let (mut culled, mut behind) = (0, 0);
    for view in path(&mut draw, prepared.bounds.unwrap(), 200) {
        let plan = Arc::clone(planner.plan(&mut placed, &[view]));
        for (t, tile) in prepared.parts[0].tiles.iter().enumerate() {
            if plan.drawn.contains(0, 0, TileId(t as u32)) {
                continue;
            }
            culled += 1;
            let face = prepared.parts[0].face_of(tile);
            for k in 0..25 {
                let at = tile.min + (tile.max - tile.min) * DVec2::new(f64::from(k % 5), f64::from(k / 5)) / 4.0;
                let d = face.patches.derivatives(at.x, at.y);
                let normal = d.du.cross(d.dv) * if face.reversed { -1.0 } else { 1.0 };
                let away = normal.dot(d.point - view.camera.eye) > 0.0;
                let shown = project(&view, 0.02 * prepared.scene.parts[0].radius, d.point).is_some();
                assert!(away || !shown, "tile {t} at {at} by {view:?}");
                behind += usize::from(away && shown);
            }
        }
    }
    assert!(culled > 100 && behind > 1000, "{culled} {behind}");
}
