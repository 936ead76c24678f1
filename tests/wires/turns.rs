//! Wires of solids, bands and washers: doubled, turned, without area, around a closed surface.

use crate::{CHORDS, crosses, flat, mesh, prepared, told, warned};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use trimtess::frame::Rung;
use trimtess::model::{
    Coedge, CurveKind, EdgeId, FaceTrouble, Frame3, Loop, NurbsCurve3, Part, PartBuilder, ShellKind, Surface, VertexId,
    shapes,
};
use trimtess::prepare::Prepared;

/// A prism of height 3 over polygons: walls, and two lids with one wire per polygon.
fn prism(wires: &[&[(f64, f64)]]) -> Part {
    let mut part = PartBuilder::new("prism");
    let shell = part.plain_shell(ShellKind::Outer);
    let up = DVec3::Z * 3.0;
    let mut lids = [Vec::new(), Vec::new()];
    for wire in wires {
        let corners = flat(wire);
        let n = corners.len();
        let [low, high] = [DVec3::ZERO, up].map(|by| {
            let vertices: Vec<VertexId> = corners.iter().map(|&p| part.vertex(p + by)).collect();
            let sides: Vec<EdgeId> = (0..n).map(|k| part.line(vertices[k], vertices[(k + 1) % n])).collect();
            (vertices, sides)
        });
        let posts: Vec<EdgeId> = (0..n).map(|k| part.line(low.0[k], high.0[k])).collect();
        for k in 0..n {
            let next = (k + 1) % n;
            let along = corners[next] - corners[k];
            let frame = Frame3::from_axis(corners[k], along.cross(DVec3::Z), along).expect("a side has a length");
            let wall = vec![low.1[k].along(), posts[next].along(), high.1[k].against(), posts[k].against()];
            part.plain_face(Surface::Plane { frame }, shell, vec![Loop::Edges(wall)], false);
        }
        lids[0].push(Loop::Edges(low.1.iter().map(|e| e.along()).collect()));
        lids[1].push(Loop::Edges(high.1.iter().map(|e| e.along()).collect()));
    }
    let [low, high] = lids;
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, low, true);
    part.plain_face(Surface::Plane { frame: Frame3 { origin: up, ..Frame3::WORLD } }, shell, high, false);
    part.finish().expect("a sound part")
}

#[test]
fn an_eight_leaves_no_gap_towards_its_walls() {
    let prepared = prepared(prism(&[&[(0.0, 0.0), (0.0, 6.0), (5.0, 1.0), (5.0, 5.0)]]));
    for chord in CHORDS {
        let (facts, _) = mesh(&prepared, chord);
        assert_eq!(facts.open_edges, 0, "chord {chord}: {facts}");
    }
}

#[test]
fn a_prism_that_touches_itself_is_closed() {
    // Two squares that meet in a corner, as one wire through two coincident vertices.
    let eight = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (4.0, 2.0), (4.0, 4.0), (2.0, 4.0), (2.0, 2.0), (0.0, 2.0)];
    // A corner that touches a side from inside.
    let dent = [(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (4.0, 4.0), (3.0, 0.0), (2.0, 4.0), (0.0, 4.0)];
    for (wire, area) in [(&eight[..], 8.0), (&dent[..], 20.0)] {
        let prepared = prepared(prism(&[wire]));
        for chord in CHORDS {
            let (facts, _) = mesh(&prepared, chord);
            assert!(facts.is_closed(), "chord {chord}: {facts}");
            assert!((facts.volume - 3.0 * area).abs() < 1e-9, "chord {chord}: {facts}");
        }
    }
}

/// The washer with changed loops on its bottom. Asserts that it is still closed and has the same volume.
fn washer_with(change: impl Fn(&mut Part)) -> Arc<Prepared> {
    let mut part = shapes::washer();
    change(&mut part);
    let prepared = prepared(part);
    for chord in CHORDS {
        let (facts, _) = mesh(&prepared, chord);
        assert!(facts.is_closed(), "chord {chord}: {facts}");
        let (volume, slack) = (PI * 64.0 * 3.0, chord * TAU * 16.0 * 3.0);
        assert!((facts.volume - volume).abs() <= slack, "chord {chord}: {facts}");
    }
    prepared
}

/// The washer's bottom.
const BOTTOM: usize = 2;

#[test]
fn a_wire_given_twice_counts_once() {
    for which in 0..2 {
        let prepared = washer_with(|part| {
            let again = part.faces[BOTTOM].loops[which].clone();
            part.faces[BOTTOM].loops.push(again);
        });
        assert!(warned(&prepared, |k| *k == FaceTrouble::LoopTwice.into()), "{:?}", told(&prepared));
    }
}

#[test]
fn a_wire_given_twice_on_a_closed_surface_counts_once() {
    // A ball with a bore along x: holes in the ball are clear of its poles, and the bore goes round.
    let (radius, bore): (f64, f64) = (5.0, 2.0);
    let h = (radius * radius - bore * bore).sqrt();
    for (face, reversed) in [(0, false), (0, true), (1, false), (1, true)] {
        let mut part = PartBuilder::new("ball with a bore");
        let shell = part.plain_shell(ShellKind::Outer);
        let along_x = |x: f64| Frame3 { origin: DVec3::X * x, x: DVec3::Y, y: DVec3::Z, z: DVec3::X };
        let [low, high] = [-h, h].map(|x| part.circle(&along_x(x), bore));
        let loops = |wires: [Coedge; 2]| wires.map(|c| Loop::Edges(vec![c])).to_vec();
        let ball = Surface::Sphere { frame: Frame3::WORLD, radius };
        part.plain_face(ball, shell, loops([high.against(), low.along()]), false);
        let side = Surface::Cylinder { frame: along_x(0.0), radius: bore };
        part.plain_face(side, shell, loops([low.along(), high.against()]), true);
        let mut part = part.finish().expect("a sound part");
        let Loop::Edges(mut again) = part.faces[face].loops[0].clone() else { panic!("a loop of edges") };
        again[0].reversed ^= reversed;
        part.faces[face].loops.push(Loop::Edges(again));
        let prepared = prepared(part);
        for chord in CHORDS {
            let (facts, _) = mesh(&prepared, chord);
            assert!(facts.is_closed(), "face {face}, {reversed}, chord {chord}: {facts} {:?}", prepared.diagnostics);
            let (volume, slack) = (4.0 / 3.0 * PI * h * h * h, chord * 8.0 * PI * radius * radius);
            assert!((facts.volume - volume).abs() <= slack, "face {face}, {reversed}, chord {chord}: {facts}");
        }
    }
}

#[test]
fn a_lost_face_silences_no_later_one() {
    let mut part = shapes::washer();
    let Loop::Edges(coedges) = &part.faces[0].loops[0] else { panic!("a loop of edges") };
    let vertex = part.edges[coedges[0].edge.index()].start;
    // Off its edges, which the lost face uses, too.
    part.vertices[vertex.index()] += DVec3::splat(0.1);
    part.faces[0].lost = true;
    let again = part.faces[BOTTOM].loops[0].clone();
    part.faces[BOTTOM].loops.push(again);
    let prepared = prepared(part);
    assert!(warned(&prepared, |k| *k == FaceTrouble::LoopTwice.into()), "{:?}", told(&prepared));
}

#[test]
fn the_sense_of_a_wire_does_not_matter() {
    fn turn(l: &mut Loop) {
        let Loop::Edges(coedges) = l else { return };
        coedges.reverse();
        coedges.iter_mut().for_each(|c| c.reversed = !c.reversed);
    }
    for turned in 0..4 {
        let prepared = washer_with(|part| {
            for k in (0..2).filter(|k| turned >> k & 1 == 1) {
                turn(&mut part.faces[BOTTOM].loops[k]);
            }
        });
        assert_eq!(told(&prepared), []);
    }
}

#[test]
fn a_wire_without_area_is_a_slit() {
    washer_with(|part| {
        let ends = [7.0, 9.0].map(|x| {
            part.vertices.push(DVec3::X * x);
            VertexId::new(part.vertices.len() - 1)
        });
        let curve = NurbsCurve3::line(DVec3::X * 7.0, DVec3::X * 9.0);
        let range = curve.domain();
        let (start, end) = (ends[0], ends[1]);
        part.edges.push(trimtess::model::Edge { curve, range, start, end, kind: CurveKind::Line, entity: 0 });
        let edge = EdgeId::new(part.edges.len() - 1);
        let there_and_back = vec![edge.along(), edge.against()];
        part.faces[BOTTOM].loops.push(Loop::Edges(there_and_back));
    });
}

/// A band of a cylinder of radius 5 between two ellipses, each at a height and with a slope along y.
fn band(wires: [(f64, f64); 2]) -> Part {
    let mut part = PartBuilder::new("band");
    let shell = part.plain_shell(ShellKind::Open);
    let loops = wires.map(|(height, slope)| {
        let y = DVec3::new(0.0, 1.0, slope);
        let frame =
            Frame3 { origin: DVec3::Z * height, x: DVec3::X, y: y.normalize(), z: DVec3::X.cross(y).normalize() };
        let start = part.vertex(frame.place(DVec3::X * 5.0));
        let curve = NurbsCurve3::arc(&frame, 5.0, 5.0 * y.length(), 0.0, TAU);
        Loop::Edges(vec![part.curve(curve, CurveKind::Conic, start, start).along()])
    });
    part.plain_face(Surface::Cylinder { frame: Frame3::WORLD, radius: 5.0 }, shell, loops.to_vec(), false);
    part.finish().expect("a sound part")
}

#[test]
fn bounds_of_a_band_that_cross_reverse_what_lies_between_them() {
    // The upper bound lies below the lower one for part of the turn: height |a + b sin θ|.
    for (height, slope) in [(2.0, 0.8), (0.5, 0.8), (3.9, 0.8), (1.0, -0.5)] {
        let prepared = prepared(band([(0.0, 0.0), (height, slope)]));
        assert!(warned(&prepared, crosses), "{:?}", told(&prepared));
        let b = 5.0 * f64::abs(slope);
        let from = f64::asin(-height / b);
        // ∫ (a + b sin θ) from `from` to π - from.
        let above = 5.0 * (height * (PI - 2.0 * from) + 2.0 * b * from.cos());
        let exact = 2.0 * above - 5.0 * height * TAU;
        for chord in CHORDS {
            let (facts, report) = mesh(&prepared, chord);
            let slack = 8.0 * chord * TAU * 5.0;
            assert!((facts.area - exact).abs() <= slack, "chord {chord}: {} of {exact}", facts.area);
            assert_eq!(report.ladder.count(Rung::Repaired), 1);
            // One or two pieces; nothing is open except the wires themselves.
            assert!(facts.nonmanifold_edges == 0, "chord {chord}: {facts}");
        }
    }
}

#[test]
fn wires_that_cross_where_a_closed_surface_is_cut_open() {
    // Squares all around a cylinder: wherever the seam lies, it cuts them where they overlap.
    let mut part = PartBuilder::new("tube");
    let shell = part.plain_shell(ShellKind::Open);
    let radius = 5.0;
    let ring = |part: &mut PartBuilder, height: f64| {
        let frame = Frame3 { origin: DVec3::Z * height, ..Frame3::WORLD };
        vec![part.circle(&frame, radius).along()]
    };
    let mut loops = vec![Loop::Edges(ring(&mut part, 0.0)), Loop::Edges(ring(&mut part, 6.0))];
    let count = 8;
    let width = 1.5 * TAU / f64::from(count);
    for k in 0..count {
        let from = TAU * f64::from(k) / f64::from(count);
        let low = if k % 2 == 0 { 1.0 } else { 1.5 };
        let arc = |a: f64, b: f64, z: f64| {
            let frame = Frame3 { origin: DVec3::Z * z, ..Frame3::WORLD };
            NurbsCurve3::arc(&frame, radius, radius, a, b)
        };
        let at = |angle: f64, z: f64| (DVec2::from_angle(angle) * radius).extend(z);
        let corners = [(from, low), (from + width, low), (from + width, low + 3.0), (from, low + 3.0)];
        let v = corners.map(|(angle, z)| part.vertex(at(angle, z)));
        let bottom = part.curve(arc(from, from + width, low), CurveKind::Circle, v[0], v[1]);
        let right = part.line(v[1], v[2]);
        let top = part.curve(arc(from, from + width, low + 3.0), CurveKind::Circle, v[3], v[2]);
        let left = part.line(v[0], v[3]);
        let wire: Vec<Coedge> = vec![left.along(), top.along(), right.against(), bottom.against()];
        loops.push(Loop::Edges(wire));
    }
    part.plain_face(Surface::Cylinder { frame: Frame3::WORLD, radius }, shell, loops, false);
    let prepared = prepared(part.finish().expect("a sound part"));
    assert!(warned(&prepared, crosses), "{:?}", told(&prepared));
    // The holes cover the heights from 1.5 to 4 at every angle, and by turns a half unit more below or above: both
    // where two holes overlap, one elsewhere. In the overlap the tube is covered again, reversed.
    let turn = TAU * radius;
    let both = 0.5 * turn;
    let union = 2.5 * turn + both + 0.5 * (turn - both);
    let exact = 6.0 * turn - union + (1.5 * 3.0 * turn - union);
    for chord in CHORDS {
        let (facts, _) = mesh(&prepared, chord);
        let slack = 4.0 * chord * turn;
        assert!((facts.area - exact).abs() <= slack, "chord {chord}: {} of {exact}", facts.area);
    }
}
