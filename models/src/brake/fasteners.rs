//! Dimensions -> bolts, nuts and washers: hexagons with exact chamfers (a cone meets a plane in a hyperbola), threads
//! as rings.

use super::STEEL;
use super::body::{Body, Ring, SideId};
use super::path::{Path, lifted};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_3, FRAC_PI_6};
use trimtess::model::{CurveKind, Frame3, NurbsCurve3, Part, Surface};

/// Thread dimensions of a bolt and its nut.
#[derive(Clone, Copy)]
pub(super) struct Thread {
    /// Largest radius.
    pub(super) radius: f64,
    pub(super) pitch: f64,
}

impl Thread {
    /// Half the width across flats.
    fn flats(self) -> f64 {
        1.5 * self.radius
    }

    /// Corners of `turns` rings upwards from height `z`, between two radii.
    fn rings(self, z: f64, turns: u32, crest: f64, root: f64) -> impl Iterator<Item = (f64, f64, f64)> {
        (0..turns).flat_map(move |turn| {
            let at = |share: f64| z + self.pitch * (f64::from(turn) + share);
            [(crest, at(0.0), 0.0), (crest, at(0.125), 0.0), (root, at(0.5), 0.0), (root, at(0.625), 0.0)]
        })
    }

    fn root(self) -> f64 {
        self.radius - 0.6 * self.pitch
    }
}

/// A bolt along z: head above the plane z = 0, shank below, with `turns` of thread at its end.
pub(super) fn bolt(name: &str, thread: Thread, length: f64, turns: u32) -> Part {
    let mut body = Body::new(name, STEEL);
    let (radius, flats) = (thread.radius, thread.flats());
    let height = 1.25 * radius;
    let seat = body.flat(DVec3::ZERO, DVec3::NEG_Z);
    let top = body.flat(DVec3::Z * height, DVec3::Z);
    hexagon(&mut body, flats, (0.0, height), (Chamfer::None, Chamfer::Cone), [seat, top]);
    let mut corners = vec![(0.0, -length, 0.0), (thread.root(), -length, 0.0)];
    corners.extend(thread.rings(0.6 * thread.pitch - length, turns, radius, thread.root()));
    let end = (0.6 + f64::from(turns)) * thread.pitch - length;
    corners.extend([(radius, end, 0.0), (radius, 0.0, 0.1 * radius), (1.2 * radius, 0.0, 0.0)]);
    // The fillet ends at the seat, which belongs to the head.
    let mut path = Path::open(&corners);
    path.points.pop();
    path.pieces.pop();
    let mut shank = body.turn(&Frame3::WORLD, &path);
    body.join(&mut shank, None, Some(seat));
    body.finish()
}

/// A nut along z, from the plane z = 0 upwards.
pub(super) fn nut(name: &str, thread: Thread, turns: u32) -> Part {
    let mut body = Body::new(name, STEEL);
    let height = f64::from(turns + 1) * thread.pitch;
    let bottom = body.flat(DVec3::ZERO, DVec3::NEG_Z);
    let top = body.flat(DVec3::Z * height, DVec3::Z);
    hexagon(&mut body, thread.flats(), (0.0, height), (Chamfer::Cone, Chamfer::Cone), [bottom, top]);
    let mouth = thread.radius + 0.3 * thread.pitch;
    let mut corners = vec![(mouth, 0.0, 0.0)];
    corners.extend(thread.rings(0.5 * thread.pitch, turns, thread.root(), thread.radius));
    corners.extend([(thread.root(), height - 0.5 * thread.pitch, 0.0), (mouth, height, 0.0)]);
    corners.reverse();
    let mut hole = body.turn(&Frame3::WORLD, &Path::open(&corners));
    body.join(&mut hole, Some(top), Some(bottom));
    body.finish()
}

/// A washer along z on the plane z = 0, with rounded outer edges.
pub(super) fn washer(name: &str, inner: f64, outer: f64, height: f64) -> Part {
    let mut body = Body::new(name, STEEL);
    let round = 0.25 * height;
    let corners = [(inner, 0.0, 0.0), (outer, 0.0, round), (outer, height, round), (inner, height, 0.0)];
    body.turn(&Frame3::WORLD, &Path::closed(&corners));
    body.finish()
}

/// The end of a hexagonal prism.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Chamfer {
    None,
    /// Cut by a cone at 30° to the end plane.
    Cone,
}

/// Adds the sides of a hexagonal prism about z between two heights. `ends` are the end planes, which get their outer
/// boundary.
fn hexagon(body: &mut Body, flats: f64, heights: (f64, f64), chamfers: (Chamfer, Chamfer), ends: [SideId; 2]) {
    let rims = [(heights.0, chamfers.0, 1.0), (heights.1, chamfers.1, -1.0)].map(|(z, chamfer, inwards)| {
        let corner = flats / FRAC_PI_6.cos();
        let slope = inwards * FRAC_PI_6.tan();
        let circle = 0.95 * flats;
        let low = if chamfer == Chamfer::Cone { z + slope * (corner - circle) } else { z };
        let point = |k: u32| {
            let angle = FRAC_PI_3 * f64::from(k % 6) + FRAC_PI_6;
            DVec3::new(corner * angle.cos(), corner * angle.sin(), low)
        };
        let vertices: Vec<_> = (0..6).map(|k| body.vertex(point(k))).collect();
        let edge = |k: u32| {
            let (a, b) = (point(k), point(k + 1));
            let curve = match chamfer {
                Chamfer::None => (NurbsCurve3::line(a, b), CurveKind::Line),
                Chamfer::Cone => (hyperbola(a, b, DVec3::NEG_Z * (0.25 * slope * corner)), CurveKind::Conic),
            };
            body.edge(curve, vertices[k as usize], vertices[(k as usize + 1) % 6])
        };
        let edges: Vec<_> = (0..6).map(edge).collect();
        (edges, vertices, circle, slope, z)
    });
    let [low, high] = &rims;
    let posts: Vec<_> = (0..6)
        .map(|k| {
            let [a, b] = [low.1[k], high.1[k]];
            body.line(a, b)
        })
        .collect();
    for k in 0..6 {
        let angle = FRAC_PI_3 * (k as f64 + 1.0);
        let outwards = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let side = body.flat(outwards * flats, outwards);
        let next = (k + 1) % 6;
        body.bound(side, vec![low.0[k].along(), posts[next].along(), high.0[k].against(), posts[k].against()]);
    }
    for (top, ((edges, _, circle, slope, z), chamfer)) in rims.into_iter().zip([chamfers.0, chamfers.1]).enumerate() {
        // Counter-clockwise about z, with the surface above on the left.
        let above: Ring = edges.iter().map(|edge| edge.along()).collect();
        let below: Ring = edges.iter().rev().map(|edge| edge.against()).collect();
        let (outer, of_end) = if top == 1 { (above.clone(), above) } else { (below.clone(), below) };
        if chamfer == Chamfer::None {
            body.bound(ends[top], of_end);
            continue;
        }
        let frame = lifted(&Frame3::WORLD, z);
        let cone = body.side(Surface::Cone { frame, radius: circle, half_angle: (1.0 / slope).atan() }, false);
        let ring = body.circle(&frame, circle);
        let (inner, of_end) = if top == 1 { (ring.against(), ring.along()) } else { (ring.along(), ring.against()) };
        body.bound(cone, outer);
        body.bound(cone, vec![inner]);
        body.bound(ends[top], vec![of_end]);
    }
}

/// The intersection of a cone about z with a plane parallel to its axis, between two points of equal height 60° apart.
/// The tangents at these points meet `rise` above their midpoint.
///
/// At distance d from the axis, height falls by tan 30° · √(d² + s²) with s along the plane.
/// Over |s| ≤ d tan 30° this is the rational quadratic with middle weight 2/√3, for every d and slope of the cone.
fn hyperbola(a: DVec3, b: DVec3, rise: DVec3) -> NurbsCurve3 {
    NurbsCurve3::bezier(vec![a, (a + b) * 0.5 + rise, b], vec![1.0, 1.0 / FRAC_PI_6.cos(), 1.0])
}
