//! Holes that touch the outer border, each other, or a vertex; and hairlines between them.

use crate::body::{Body, level};
use crate::common::{frame, prepared};
use crate::ladder::Ladder;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};
use trimtess::frame::{Tolerance, plan};
use trimtess::model::{Coedge, EdgeId, Frame3, Severity, Surface};

fn at(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, 0.0)
}

/// The square of side 20 about the origin.
fn square() -> [DVec3; 4] {
    [at(-10.0, -10.0), at(10.0, -10.0), at(10.0, 10.0), at(-10.0, 10.0)]
}

/// A circle about (x, y) whose vertex lies at the given angle.
fn ring(body: &mut Body, (x, y): (f64, f64), radius: f64, angle: f64) -> EdgeId {
    let out = at(angle.cos(), angle.sin());
    body.circle(&Frame3 { origin: at(x, y), x: out, y: DVec3::Z.cross(out), z: DVec3::Z }, radius)
}

/// A plate with holes.
fn plate(body: &mut Body, holes: Vec<Vec<Coedge>>) {
    let mut loops = vec![body.polygon(&square())];
    loops.extend(holes);
    body.flat(Frame3::WORLD, loops);
}

#[test]
fn holes_at_a_hairline_from_the_border_and_from_each_other() {
    for gap in [1e-2, 1e-4, 1e-6] {
        let mut body = Body::sheet();
        let holes = [((7.0 - gap, 0.0), 3.0), ((1.0 - 3.0 * gap, 0.0), 3.0 - gap)];
        let holes = holes.map(|(centre, radius)| vec![ring(&mut body, centre, radius, 0.3).against()]);
        plate(&mut body, holes.to_vec());
        let area = 400.0 - PI * (9.0 + (3.0 - gap) * (3.0 - gap));
        Ladder::sheet(body.finish(), area).named(gap).assert_climbs();
    }
}

#[test]
fn a_hole_tangent_to_the_border() {
    // Its vertex at the point of contact, opposite, and elsewhere.
    for angle in [0.0, PI, 1.0] {
        let mut body = Body::sheet();
        let hole = ring(&mut body, (7.0, 0.0), 3.0, angle);
        plate(&mut body, vec![vec![hole.against()]]);
        Ladder::sheet(body.finish(), 400.0 - 9.0 * PI).touching().named(angle).assert_climbs();
    }
}

#[test]
fn holes_tangent_to_each_other() {
    for (a, b) in [(0.0, PI), (1.0, 2.0), (PI, 0.0)] {
        let mut body = Body::sheet();
        let holes = [((-3.0, 0.0), a), ((3.0, 0.0), b)];
        let holes = holes.map(|(centre, angle)| vec![ring(&mut body, centre, 3.0, angle).against()]);
        plate(&mut body, holes.to_vec());
        Ladder::sheet(body.finish(), 400.0 - 18.0 * PI).touching().named((a, b)).assert_climbs();
    }
}

#[test]
fn holes_that_overlap_by_less_than_the_tolerances_are_a_note() {
    // The part's own tolerance is 1e-7.
    for (overlap, chord, severity) in [
        (1e-11, 1e-3, Severity::Note),
        (1e-9, 1e-3, Severity::Note),
        (1e-5, 1e-3, Severity::Note),
        (1e-9, 1e-6, Severity::Note),
        (1e-5, 1e-6, Severity::Warning),
    ] {
        let mut body = Body::sheet();
        let holes = [(-3.0, 0.0), (3.0 - overlap, PI)];
        let holes = holes.map(|(x, angle)| vec![ring(&mut body, (x, 0.0), 3.0, angle).against()]);
        plate(&mut body, holes.to_vec());
        let mut part = body.finish();
        part.tolerance = 1e-7;
        let prepared = prepared(part);
        assert!(prepared.diagnostics.is_empty(), "{:?}", prepared.diagnostics);
        let (sink, report) =
            frame(&prepared, &plan(&prepared, &Tolerance { chord, angle: 0.35, max_edge: None }), true);
        let told = report.diagnostics(&sink, &prepared);
        let told: Vec<_> = told.iter().map(|d| (d.severity, d.kind.code())).collect();
        assert_eq!(told, [(severity, "tile-crosses-itself")], "{overlap} {chord}");
    }
}

#[test]
fn holes_that_share_a_vertex() {
    // With each other, with a corner of the border, and with a vertex in one of its sides.
    let spots: [&[[DVec3; 3]]; 3] = [
        &[[at(0.0, 0.0), at(-5.0, 2.0), at(-4.0, -3.0)], [at(0.0, 0.0), at(4.0, -3.0), at(5.0, 2.0)]],
        &[[at(10.0, 10.0), at(3.0, 5.0), at(5.0, 3.0)]],
        &[[at(10.0, 0.0), at(4.0, 1.5), at(4.0, -1.5)]],
    ];
    for (k, holes) in spots.into_iter().enumerate() {
        let mut body = Body::sheet();
        let mut corners = square().to_vec();
        if k == 2 {
            corners.insert(2, at(10.0, 0.0));
        }
        let mut loops = vec![body.polygon(&corners)];
        let mut area = 400.0;
        for hole in holes {
            let mut clockwise = *hole;
            let twice = (hole[1] - hole[0]).cross(hole[2] - hole[0]).z;
            if twice > 0.0 {
                clockwise.reverse();
            }
            area -= 0.5 * twice.abs();
            loops.push(body.polygon(&clockwise));
        }
        body.flat(Frame3::WORLD, loops);
        Ladder::sheet(body.finish(), area).named(k).assert_climbs();
    }
}

#[test]
fn round_holes_that_share_a_vertex_with_the_border() {
    // Tangent in a vertex of both: no segment is split.
    let mut body = Body::sheet();
    let mut corners = square().to_vec();
    corners.insert(2, at(10.0, 0.0));
    let hole = ring(&mut body, (7.0, 0.0), 3.0, 0.0);
    let loops = vec![body.polygon(&corners), vec![hole.against()]];
    body.flat(Frame3::WORLD, loops);
    Ladder::sheet(body.finish(), 400.0 - 9.0 * PI).assert_climbs();
}

#[test]
fn two_discs_joined_at_a_point() {
    // One loop that touches itself: both discs of an eight, traversed without a crossing.
    let mut body = Body::sheet();
    let (left, right) = (ring(&mut body, (-3.0, 0.0), 3.0, 0.0), ring(&mut body, (3.0, 0.0), 3.0, PI));
    body.flat(Frame3::WORLD, vec![vec![left.along(), right.along()]]);
    Ladder::sheet(body.finish(), 18.0 * PI).assert_climbs();
}

#[test]
fn touching_windows_in_a_cylinder() {
    // Four windows that share corners, on a side with its own lattice.
    let (radius, height) = (5.0, 12.0);
    let mut body = Body::sheet();
    let [low, high] = [0.0, height].map(|z| body.circle(&level(z), radius));
    let mut loops = vec![vec![low.along()], vec![high.against()]];
    for (u, v) in [(0.0, 3.0), (0.8, 6.0), (-0.8, 6.0), (0.0, 9.0)] {
        loops.push(body.window(radius, (u - 0.4, u + 0.4), (v - 1.5, v + 1.5)));
    }
    body.face(Surface::Cylinder { frame: Frame3::WORLD, radius }, loops, false);
    let area = 2.0 * PI * radius * height - 4.0 * (0.8 * radius * 3.0);
    Ladder::sheet(body.finish(), area).assert_climbs();
}

#[test]
fn a_quarter_disc_whose_arc_leaves_along_its_side() {
    // The arc is tangent to the straight side that follows it: the angle between them is zero.
    let mut body = Body::sheet();
    let arc = body.arc(&Frame3 { origin: at(0.0, 5.0), ..Frame3::WORLD }, 5.0, -FRAC_PI_2, 0.0);
    let (up, down) = (body.line(at(5.0, 5.0), at(5.0, 0.0)), body.line(at(5.0, 0.0), at(0.0, 0.0)));
    let outside = vec![arc.along(), up, down];
    body.flat(Frame3::WORLD, vec![outside]);
    Ladder::sheet(body.finish(), 25.0 - 6.25 * PI).assert_climbs();
}
