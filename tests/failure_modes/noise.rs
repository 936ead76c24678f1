//! Edges less accurate than their faces need: images cross although edges do not.

use crate::body::{Body, through};
use crate::common::{frame, prepared};
use crate::ladder::Ladder;
use glam::DVec3;
use std::f64::consts::PI;
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::check_scene;
use trimtess::model::{CurveKind, Frame3, NurbsCurve3, Surface};

fn at(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, 0.0)
}

#[test]
fn arcs_a_thousandth_of_their_radius_apart_stay_apart() {
    // Chords of one arc, between any points that a tolerance may choose, must not reach the other.
    const TURN: f64 = 4.0;
    for gap in [2e-2, 2e-3, 2e-4] {
        let mut body = Body::sheet();
        let inner = 5.0 - gap;
        let [outside, inside] = [5.0, inner].map(|radius| body.arc(&Frame3::WORLD, radius, 0.0, TURN));
        let across = [TURN, 0.0].map(|angle: f64| at(angle.cos(), angle.sin()));
        let there = body.line(across[0] * 5.0, across[0] * inner);
        let back = body.line(across[1] * inner, across[1] * 5.0);
        body.flat(Frame3::WORLD, vec![vec![outside.along(), there, inside.against(), back]]);
        Ladder::sheet(body.finish(), 0.5 * TURN * (25.0 - inner * inner)).named(gap).assert_climbs();
    }
}

#[test]
fn arcs_that_leave_a_vertex_side_by_side_stay_apart() {
    // Two quarter circles from one vertex, whose other ends are `gap` apart.
    for gap in [5e-2, 5e-3] {
        let mut body = Body::sheet();
        let outer = body.arc(&Frame3::WORLD, 3.0, 0.0, 0.5 * PI);
        let radius = (3.0 - gap) * 0.5 + 4.5 / (3.0 - gap);
        // Through (3, 0) and the point `gap` below (0, 3), about a centre on the perpendicular bisector of the two.
        let [a, b] = [at(3.0, 0.0), at(0.0, 3.0 - gap)];
        let along = (b - a).normalize();
        let across = DVec3::Z.cross(along);
        let half = 0.5 * a.distance(b);
        let centre = a.midpoint(b) + across * (radius * radius - half * half).sqrt();
        let angle = |p: DVec3| (p - centre).y.atan2((p - centre).x);
        let inner = body.arc(&Frame3 { origin: centre, ..Frame3::WORLD }, radius, angle(a), angle(b));
        let short = body.line(at(0.0, 3.0), at(0.0, 3.0 - gap));
        body.flat(Frame3::WORLD, vec![vec![outer.along(), short, inner.against()]]);
        let turn = 2.0 * (half / radius).asin();
        let below = 1.5 * (3.0 - gap) + 0.5 * radius * radius * (turn - turn.sin());
        Ladder::sheet(body.finish(), 2.25 * PI - below).named(gap).assert_climbs();
    }
}

#[test]
fn a_spline_whose_speed_jumps_by_a_thousand_bounds_a_face() {
    // With one slope for both sides of such a knot, the image would run back over itself.
    let mut body = Body::sheet();
    let xs = [0.0, 1.0, 3.0, 3.0005, 3.001, 3.0015, 3.002, 6.0, 10.0];
    let points: Vec<DVec3> = xs.iter().map(|&x| at(x, 0.0)).collect();
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    let bottom = body.spline(NurbsCurve3 { degree: 2, knots, points, weights: Vec::new() });
    let rest = [at(10.0, 0.0), at(10.0, 5.0), at(0.0, 5.0), at(0.0, 0.0)];
    let mut outline = vec![bottom.along()];
    outline.extend(rest.windows(2).map(|w| body.line(w[0], w[1])));
    body.flat(Frame3::WORLD, vec![outline]);
    Ladder::sheet(body.finish(), 50.0).assert_climbs();
}

#[test]
fn an_edge_whose_curve_starts_beyond_its_neighbour_leaves_its_vertex_inside() {
    for off in [5e-5, 5e-4] {
        let mut body = Body::sheet();
        let corners = [at(0.0, 0.0), at(10.0, 0.0), at(10.0, 10.0), at(0.0, 10.0)];
        let [a, b] = [0, 1].map(|k| body.vertex(corners[k]));
        let curve = NurbsCurve3::line(at(-off, off), corners[1]);
        let bottom = body.part.curve(curve, CurveKind::Line, a, b);
        let mut outline = vec![bottom.along()];
        outline.extend((1..4).map(|k| body.line(corners[k], corners[(k + 1) % 4])));
        body.flat(Frame3::WORLD, vec![outline]);
        Ladder::sheet(body.finish(), 100.0).named(off).assert_climbs();
    }
}

#[test]
fn edges_around_a_small_hole_of_a_closed_face_cross_at_their_vertex() {
    // The first edge runs past its end, over to the other side of the second one, and back. That is much for the hole
    // and little for the face, whose size no seam shows.
    let (major, minor, hole) = (6.0, 3.0, 0.1);
    let torus = Surface::Torus { frame: Frame3::WORLD, major, minor };
    let on = |angle: f64, share: f64| {
        let (u, v) = (1.0 + hole * share * angle.cos() / major, 0.5 * PI + hole * share * angle.sin() / minor);
        torus.point(u, v)
    };
    for past in [0.05, 0.1] {
        let first = |t: f64| {
            // To `past` the end at t = 0.9, outside the second edge, and back inside it.
            let angle = if t < 0.9 { (PI + past) * (t / 0.9) } else { PI + past * (1.0 - t) / 0.1 };
            let aside = if t < 0.8 { 0.0 } else { 0.005 * (10.0 * PI * (0.9 - t)).sin() };
            on(angle, 1.0 + aside)
        };
        let mut body = Body::sheet();
        let one = body.spline(through(first, (0.0, 1.0), 400));
        let two = body.spline(through(|t| on(PI * (1.0 + t), 1.0), (0.0, 1.0), 40));
        body.face(torus.clone(), vec![vec![two.against(), one.against()]], false);
        let prepared = prepared(body.finish());
        let told: Vec<_> = prepared.diagnostics.iter().map(|d| d.kind.code()).collect();
        assert_eq!(told, ["edge-images-crossed"], "{past}: {:?}", prepared.diagnostics);
        for chord in [0.1, 0.01, 1e-3] {
            let (sink, report) =
                frame(&prepared, &plan(&prepared, &Tolerance { chord, angle: 0.5, max_edge: None }), true);
            assert!(report.degraded.is_empty(), "{past}, {chord}: {:?}", report.degraded);
            let (area, whole) = (check_scene(&sink).total.area, 4.0 * PI * PI * major * minor);
            assert!((area - whole).abs() < 0.05 * whole, "{past}, {chord}: {area} of {whole}");
        }
    }
}
