//! Faces between curves that run close together.

use crate::body::{Body, level};
use crate::ladder::Ladder;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use trimtess::model::Frame3;

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
            Ladder::sheet(body.finish(), 2.0 * RADIUS * offset).named((offset, forward)).climb();
        }
    }
}

#[test]
fn a_ring_between_concentric_circles() {
    for gap in [1e-1, 1e-2, 1e-3, 1e-4] {
        let mut body = Body::sheet();
        let [outer, inner] = [RADIUS, RADIUS - gap].map(|radius| body.circle(&level(0.0), radius));
        body.flat(Frame3::WORLD, vec![vec![outer.along()], vec![inner.against()]]);
        Ladder::sheet(body.finish(), TAU * RADIUS * gap).named(gap).climb();
    }
}
