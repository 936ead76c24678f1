//! Faces between curves that run close together.

use crate::body::{Body, level};
use crate::common::{frame, prepared};
use crate::ladder::Ladder;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use trimtess::audit;
use trimtess::frame::{Tolerance, plan};
use trimtess::model::{Coedge, EdgeId, Frame3, Surface};

const RADIUS: f64 = 5.0;

#[test]
fn a_crescent_between_equal_circles() {
    for offset in [1e-1, 1e-2, 1e-3] {
        for forward in [true, false] {
            let mut body = Body::sheet();
            let turn = (0.5 * offset / RADIUS).acos();
            let outer = body.arc(&Frame3::WORLD, RADIUS, turn, TAU - turn);
            let shifted = Frame3 { origin: DVec3::X * offset, ..Frame3::WORLD };
            let inner = body.arc(&shifted, RADIUS, PI - turn, PI + turn);
            let round = if forward { [outer.along(), inner.against()] } else { [inner.along(), outer.against()] };
            body.flat(Frame3::WORLD, vec![round.to_vec()]);
            Ladder::sheet(body.finish(), 2.0 * RADIUS * offset).named((offset, forward)).assert_climbs();
        }
    }
}

#[test]
fn a_ring_between_concentric_circles() {
    for gap in [1e-1, 1e-2, 1e-3, 1e-4] {
        let mut body = Body::sheet();
        let [outer, inner] = [RADIUS, RADIUS - gap].map(|radius| body.circle(&level(0.0), radius));
        body.flat(Frame3::WORLD, vec![vec![outer.along()], vec![inner.against()]]);
        Ladder::sheet(body.finish(), TAU * RADIUS * gap).named(gap).assert_climbs();
    }
}

/// The seam of the side is far shorter than the coin is wide, and no pole.
#[test]
fn a_coin_with_a_side_of_splines() {
    for height in [1e-1, 1e-3, 3e-5] {
        let mut body = Body::solid();
        let [low, high] = [0.0, height].map(|z| body.circle(&level(z), RADIUS));
        let side = Surface::Cylinder { frame: Frame3::WORLD, radius: RADIUS };
        let (side, _) = side.to_nurbs((0.0, TAU), (0.0, height));
        body.face(Surface::Nurbs(side), vec![vec![low.along()], vec![high.against()]], false);
        body.face(Surface::Plane { frame: level(0.0) }, vec![vec![low.against()]], true);
        body.face(Surface::Plane { frame: level(height) }, vec![vec![high.along()]], false);
        let (volume, area) = (PI * RADIUS * RADIUS * height, TAU * RADIUS * (height + RADIUS));
        Ladder::solid(body.finish(), volume, area).named(height).assert_climbs();
    }
}

/// The rims have vertices in different places, so triangles between them are wider than a cell. The tolerance exceeds
/// the radius of the groove: heights along its normals are less than distances.
#[test]
fn a_groove_narrower_than_the_tolerance() {
    let (major, minor, half) = (30.0, 0.5, 0.75_f64);
    let mut body = Body::sheet();
    let mut rim = |z: f64, count: u32| -> Vec<EdgeId> {
        let turn = |k: u32| TAU * f64::from(k) / f64::from(count);
        let radius = major - minor * half.cos();
        (0..count).map(|k| body.arc(&level(z), radius, turn(k), turn(k + 1))).collect()
    };
    let [low, high] = [rim(-minor * half.sin(), 7), rim(minor * half.sin(), 8)];
    let low: Vec<Coedge> = low.into_iter().rev().map(EdgeId::against).collect();
    let high: Vec<Coedge> = high.into_iter().map(EdgeId::along).collect();
    body.face(Surface::Torus { frame: Frame3::WORLD, major, minor }, vec![low, high], true);
    let prepared = prepared(body.finish());
    for chord in [0.3, 0.6, 0.95, 1.2, 1.6] {
        for angle in [30.0_f64, 35.0, 45.0, 60.0, 90.0] {
            let plan = plan(&prepared, &Tolerance { chord, angle: angle.to_radians(), max_edge: None });
            let (sink, _) = frame(&prepared, &plan, false);
            let worst = audit::deviation(&prepared, &sink, chord).beyond_gap.worst;
            assert!(worst <= 1.0, "chord {chord}, angle {angle}: {worst} times the tolerance");
        }
    }
}

#[test]
fn a_star_of_many_spikes() {
    // The boxes of a spike's sides overlap those of hundreds of others.
    let (inner, outer, spikes) = (5.0, 8.0, 1250_u32);
    let turn = PI / f64::from(spikes);
    let corner = |k: u32| {
        let radius = if k.is_multiple_of(2) { inner } else { outer };
        let angle = turn * f64::from(k);
        radius * DVec3::new(angle.cos(), angle.sin(), 0.0)
    };
    let corners: Vec<DVec3> = (0..2 * spikes).map(corner).collect();
    let mut body = Body::sheet();
    let around = body.polygon(&corners);
    body.flat(Frame3::WORLD, vec![around]);
    Ladder::sheet(body.finish(), f64::from(spikes) * inner * outer * turn.sin()).assert_climbs();
}
