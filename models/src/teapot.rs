//! M. Newell's control points of the Utah teapot (1975; the bottom was added later) -> 32 bicubic Bézier patches that
//! share their common borders.
//!
//! Body, rim, lid and bottom are profiles turned by four quarter turns; handle and spout are half tubes and their
//! mirror images. Only the profiles and the sections of the tubes are stored.

use glam::DVec3;
use std::collections::BTreeMap;
use trimtess::model::{
    Coedge, CurveKind, EdgeId, Loop, NurbsCurve, NurbsSurface, Part, PartBuilder, ShellKind, Surface, VertexId,
};

/// A profile: distance from the axis and height of four rows of control points.
///
/// `second` is the offset of the inner control points of the arc in the second row, as a fraction of the distance. It
/// differs from [`ARC`] in one profile of the lid.
struct Profile {
    rows: [(f64, f64); 4],
    second: f64,
    reversed: bool,
}

const ARC: f64 = 0.56;

const PROFILES: [Profile; 6] = [
    // Rim.
    Profile { rows: [(1.4, 2.4), (1.3375, 2.53125), (1.4375, 2.53125), (1.5, 2.4)], second: ARC, reversed: true },
    // Body.
    Profile { rows: [(1.5, 2.4), (1.75, 1.875), (2.0, 1.35), (2.0, 0.9)], second: ARC, reversed: true },
    Profile { rows: [(2.0, 0.9), (2.0, 0.45), (1.5, 0.225), (1.5, 0.15)], second: ARC, reversed: true },
    // Lid.
    Profile { rows: [(0.0, 3.15), (0.8, 3.15), (0.0, 2.85), (0.2, 2.7)], second: 0.5625, reversed: true },
    Profile { rows: [(0.2, 2.7), (0.4, 2.55), (1.3, 2.55), (1.3, 2.4)], second: ARC, reversed: true },
    // Bottom.
    Profile { rows: [(0.0, 0.0), (1.425, 0.0), (1.5, 0.075), (1.5, 0.15)], second: ARC, reversed: false },
];

/// Four sections of a tube: inner and outer (x, z), and half the width.
type Tube = [((f64, f64), (f64, f64), f64); 4];

const TUBES: [Tube; 4] = [
    // Handle.
    [
        ((-1.6, 2.025), (-1.5, 2.25), 0.3),
        ((-2.3, 2.025), (-2.5, 2.25), 0.3),
        ((-2.7, 2.025), (-3.0, 2.25), 0.3),
        ((-2.7, 1.8), (-3.0, 1.8), 0.3),
    ],
    [
        ((-2.7, 1.8), (-3.0, 1.8), 0.3),
        ((-2.7, 1.575), (-3.0, 1.35), 0.3),
        ((-2.5, 1.125), (-2.65, 0.9375), 0.3),
        ((-2.0, 0.9), (-1.9, 0.6), 0.3),
    ],
    // Spout.
    [
        ((1.7, 1.425), (1.7, 0.6), 0.66),
        ((2.6, 1.425), (3.1, 0.825), 0.66),
        ((2.3, 2.1), (2.4, 2.025), 0.25),
        ((2.7, 2.4), (3.3, 2.4), 0.25),
    ],
    [
        ((2.7, 2.4), (3.3, 2.4), 0.25),
        ((2.8, 2.475), (3.525, 2.49375), 0.25),
        ((2.9, 2.475), (3.45, 2.5125), 0.15),
        ((2.8, 2.4), (3.2, 2.4), 0.15),
    ],
];

/// Control points of a patch, rows along u, and whether its outward normal is opposite to `S_u × S_v`.
pub(crate) type Net = ([[DVec3; 4]; 4], bool);

/// The 32 patches in the published unit, in which the body is 4 wide.
pub(crate) fn nets() -> Vec<Net> {
    let mut out = Vec::with_capacity(32);
    for profile in &PROFILES {
        let mut net = [[DVec3::ZERO; 4]; 4];
        for (i, (row, (r, z))) in net.iter_mut().zip(profile.rows).enumerate() {
            let bulge = r * if i == 1 { profile.second } else { ARC };
            *row = [(r, 0.0), (r, -bulge), (bulge, -r), (0.0, -r)].map(|(x, y)| DVec3::new(x, y, z));
        }
        for _ in 0..4 {
            out.push((net, profile.reversed));
            // An exact quarter turn. Adding to 0.0 avoids -0.0.
            net = net.map(|row| row.map(|p| DVec3::new(0.0 + p.y, 0.0 - p.x, p.z)));
        }
    }
    for tube in TUBES {
        for (side, reversed) in [(-1.0, true), (1.0, false)] {
            let row = |((x0, z0), (x1, z1), width): ((f64, f64), (f64, f64), f64)| {
                [(x0, 0.0, z0), (x0, side * width, z0), (x1, side * width, z1), (x1, 0.0, z1)].map(DVec3::from)
            };
            out.push((tube.map(row), reversed));
        }
    }
    out
}

/// The teapot at 20 mm per published unit. Open where the original is: between lid and rim, and where handle and spout
/// enter the body.
pub(crate) fn teapot() -> Part {
    const SCALE: f64 = 20.0;
    let mut maker = Maker { part: PartBuilder::new("teapot"), vertices: BTreeMap::new(), edges: BTreeMap::new() };
    let shell = maker.part.plain_shell(ShellKind::Open);
    for (net, reversed) in nets() {
        let net = net.map(|row| row.map(|p| p * SCALE));
        let column = |j: usize| [0, 1, 2, 3].map(|i| net[i][j]);
        // Around the patch, with its inside on the left.
        let sides = [(column(0), false), (net[3], false), (column(3), true), (net[0], true)];
        let coedges = sides.into_iter().filter_map(|(points, back)| maker.side(points, back)).collect();
        let surface = NurbsSurface::bezier((3, 3), net.concat(), Vec::new());
        maker.part.plain_face(Surface::Nurbs(surface), shell, vec![Loop::Edges(coedges)], reversed);
    }
    maker.part.finish().expect("the teapot is stated soundly")
}

type Key = [u64; 3];

struct Maker {
    part: PartBuilder,
    vertices: BTreeMap<Key, VertexId>,
    /// Edges by control points, in one of the two directions.
    edges: BTreeMap<[Key; 4], EdgeId>,
}

impl Maker {
    /// The coedge along these control points, or against them if `back`. `None` for a border that is one point.
    fn side(&mut self, points: [DVec3; 4], back: bool) -> Option<Coedge> {
        if points.iter().all(|&p| p == points[0]) {
            return None;
        }
        let keys = points.map(key);
        let turned = [keys[3], keys[2], keys[1], keys[0]];
        let (edge, against) = match (self.edges.get(&keys), self.edges.get(&turned)) {
            (Some(&edge), _) => (edge, false),
            (_, Some(&edge)) => (edge, true),
            _ => {
                let [start, end] = [points[0], points[3]].map(|p| self.vertex(p));
                let curve = NurbsCurve::bezier(points.to_vec(), Vec::new());
                let edge = self.part.curve(curve, CurveKind::Spline, start, end);
                self.edges.insert(keys, edge);
                (edge, false)
            }
        };
        Some(if against == back { edge.along() } else { edge.against() })
    }

    fn vertex(&mut self, p: DVec3) -> VertexId {
        let part = &mut self.part;
        *self.vertices.entry(key(p)).or_insert_with(|| part.vertex(p))
    }
}

/// The bits of a point, with -0.0 as 0.0.
fn key(p: DVec3) -> Key {
    p.to_array().map(|x| (x + 0.0).to_bits())
}
