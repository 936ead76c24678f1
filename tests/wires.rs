//! Faces with faulty wires: crossing, overlapping, doubled, reversed, without area, not closed. Each yields the
//! triangles of the region of positive winding and a diagnostic with a place. No face is lost.

mod common;
#[path = "sequence/random.rs"]
mod random;

use common::{frame, placed};
use glam::{DVec2, DVec3};
use random::SplitMix;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use trimtess::frame::{Degradation, Rung, Tolerance, plan};
use trimtess::mesh::{MemorySink, MeshFacts, check_scene};
use trimtess::model::{
    BorderTrouble, Coedge, CurveKind, DiagnosticKind, EdgeId, FaceError, FaceTrouble, Frame3, Loop, NurbsCurve3, Part,
    PartBuilder, RegionError, Severity, ShellKind, ShellTrouble, Surface, VertexId, WireTrouble, shapes,
};
use trimtess::parallel::{FrameReport, serial};
use trimtess::prepare::Prepared;

/// Chords: base, /4, /16, /32.
const CHORDS: [f64; 4] = [0.2, 0.05, 0.0125, 0.00625];

/// The part, placed once and prepared, sound or not.
fn prepared(part: Part) -> Arc<Prepared> {
    common::prepared(placed(part))
}

fn mesh(prepared: &Arc<Prepared>, chord: f64) -> (MeshFacts, FrameReport) {
    let plan = plan(prepared, &Tolerance { chord, angle: 0.5, max_edge: None });
    let (sink, report) = frame(prepared, &plan, false);
    let facts = check_scene(&sink);
    assert_eq!(facts.faces_without_triangles, [], "chord {chord}: {:?} {:?}", prepared.diagnostics, report.degraded);
    assert!(facts.total.is_well_formed(), "chord {chord}: {}", facts.total);
    (facts.total, report)
}

/// Severity and kind of all diagnostics. Asserts that each names its face and a place.
fn told(prepared: &Prepared) -> Vec<(Severity, DiagnosticKind)> {
    prepared
        .diagnostics
        .iter()
        .map(|d| {
            assert!(d.face.is_some() && d.place.is_some_and(DVec3::is_finite), "{d:?}");
            (d.severity, d.kind.clone())
        })
        .collect()
}

fn warned(prepared: &Prepared, of: impl Fn(&DiagnosticKind) -> bool) -> bool {
    told(prepared).iter().any(|(severity, kind)| *severity == Severity::Warning && of(kind))
}

fn crosses(kind: &DiagnosticKind) -> bool {
    matches!(kind, DiagnosticKind::Face(FaceTrouble::Crosses | FaceTrouble::LobesTurned { .. }))
}

fn gaps(kind: &DiagnosticKind) -> bool {
    matches!(kind, DiagnosticKind::Wire(WireTrouble::VerticesMoved { .. } | WireTrouble::Bridged { .. }))
}

fn one_lobe(kind: &DiagnosticKind) -> bool {
    matches!(kind, DiagnosticKind::Face(FaceTrouble::LobesTurned { lobes: 1, .. }))
}

fn out_of_order(kind: &DiagnosticKind) -> bool {
    matches!(kind, DiagnosticKind::Wire(WireTrouble::Reordered { .. }))
}

fn one_turned(kind: &DiagnosticKind) -> bool {
    matches!(kind, DiagnosticKind::Wire(WireTrouble::Reordered { turned: 1, .. }))
}

fn flat(points: &[(f64, f64)]) -> Vec<DVec3> {
    points.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect()
}

/// A plane face with one wire per polygon.
fn sheet(wires: &[&[(f64, f64)]]) -> Part {
    let mut part = PartBuilder::new("sheet");
    let shell = part.plain_shell(ShellKind::Open);
    let loops = wires.iter().map(|w| Loop::Edges(part.polygon(&flat(w)))).collect();
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, loops, false);
    part.finish().expect("a sound part")
}

/// Asserts that a plane face has this area at all chords. Returns the prepared part and the report of the finest frame.
fn has_area(part: Part, area: f64) -> (Arc<Prepared>, FrameReport) {
    let prepared = prepared(part);
    let mut last = FrameReport::default();
    for chord in CHORDS {
        let (facts, report) = mesh(&prepared, chord);
        assert!((facts.area - area).abs() <= 1e-9 * area, "chord {chord}: area {} of {area}", facts.area);
        last = report;
    }
    (prepared, last)
}

const PLATE: [(f64, f64); 4] = [(0.0, 0.0), (10.0, 0.0), (10.0, 8.0), (0.0, 8.0)];

#[test]
fn a_figure_eight_keeps_both_lobes() {
    // Lobes of 9 and 4 around (3, 3), in both directions; and two equal ones.
    let eight: [(f64, f64); 4] = [(0.0, 0.0), (0.0, 6.0), (5.0, 1.0), (5.0, 5.0)];
    let mut back = eight;
    back.reverse();
    for (wire, area, place) in [
        (eight, 13.0, (3.0, 3.0)),
        (back, 13.0, (3.0, 3.0)),
        ([(0.0, 0.0), (10.0, 10.0), (10.0, 0.0), (0.0, 10.0)], 50.0, (5.0, 5.0)),
    ] {
        let (prepared, report) = has_area(sheet(&[&wire]), area);
        assert!(warned(&prepared, one_lobe), "{:?}", told(&prepared));
        let at = prepared.diagnostics[0].place.expect("a place");
        assert!(at.distance(DVec3::new(place.0, place.1, 0.0)) < 1e-9, "{at}");
        assert_eq!(report.ladder.count(Rung::Repaired), 1);
        assert_eq!(report.rungs.len(), 1);
    }
}

/// A plane face with one wire through points that may lie off the plane.
fn sheet_through(points: &[DVec3]) -> Part {
    let mut part = PartBuilder::new("sheet");
    let shell = part.plain_shell(ShellKind::Open);
    let wire = Loop::Edges(part.polygon(points));
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![wire], false);
    part.finish().expect("a sound part")
}

#[test]
fn a_lobe_whose_edges_cross_above_each_other_leaves_no_crack() {
    // The edges of the eight cross in (u,v) and pass each other at distance z in space, zero included.
    let eight = |z: f64| [(0.0, 0.0, 0.0), (10.0, 10.0, 0.0), (10.0, 0.0, z), (0.0, 10.0, z)].map(DVec3::from);
    // Three diameters of a hexagon, one above the other: six lobes that meet in one point of the plane and in three
    // points of space.
    let corner = |k: f64, z: f64| DVec3::new(5.0 * (k * PI / 3.0).cos(), 5.0 * (k * PI / 3.0).sin(), z);
    let star = |z: f64| {
        [(0.0, 0.0), (3.0, 0.0), (1.0, z), (4.0, z), (2.0, 2.0 * z), (5.0, 2.0 * z)].map(|(k, z)| corner(k, z)).to_vec()
    };
    for z in [0.0, 1e-9, 1e-5, 1e-3, 0.05] {
        for points in [eight(z).to_vec(), star(z)] {
            let prepared = prepared(sheet_through(&points));
            for chord in CHORDS {
                let mut sink = MemorySink::default();
                let plan = plan(&prepared, &Tolerance { chord, angle: 0.5, max_edge: None });
                serial(&prepared, &plan, true, &mut sink).expect("a frame");
                let facts = check_scene(&sink).total;
                assert_eq!(facts.defects, 0, "{} corners, z {z}: {facts}; {:?}", points.len(), prepared.diagnostics);
            }
        }
    }
}

#[test]
fn a_hole_like_an_eight_is_two_holes() {
    // Two lobes of 2 x 2 / 2 around (3, 4), and the same crossing at a vertex that is passed twice.
    let lobes = [(2.0, 3.0), (4.0, 5.0), (4.0, 3.0), (2.0, 5.0)];
    let (prepared, _) = has_area(sheet(&[&PLATE, &lobes]), 78.0);
    assert!(warned(&prepared, one_lobe), "{:?}", told(&prepared));
    let through = [(2.0, 3.0), (3.0, 4.0), (4.0, 5.0), (4.0, 3.0), (3.0, 4.0), (2.0, 5.0)];
    let (prepared, _) = has_area(sheet(&[&PLATE, &through]), 78.0);
    assert!(warned(&prepared, one_lobe), "{:?}", told(&prepared));
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
fn a_wire_wound_twice_through_one_vertex_is_covered_twice() {
    let wire = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (0.0, 0.0), (9.0, 1.0), (9.0, 9.0), (1.0, 9.0)];
    let (prepared, report) = has_area(sheet(&[&wire]), 100.0 + 72.0);
    assert!((report.fills[0].rewound - 72.0).abs() < 1e-9, "{:?}", report.fills);
    assert!(warned(&prepared, |k| *k == FaceTrouble::Crosses.into()), "{:?}", told(&prepared));
    assert_eq!(report.ladder.count(Rung::Repaired), 1);
}

/// A plate with a hole, its wires changed.
fn plate_with(change: impl Fn(&mut Vec<Loop>)) -> Part {
    let mut part = sheet(&[&PLATE, &[(2.0, 2.0), (2.0, 4.0), (4.0, 4.0), (4.0, 2.0)]]);
    change(&mut part.faces[0].loops);
    part
}

#[test]
fn edges_listed_in_another_order_are_chained() {
    let coedges = |l: &mut Loop| match l {
        Loop::Edges(coedges) => std::mem::take(coedges),
        Loop::Vertex(_) => Vec::new(),
    };
    for which in 0..2 {
        // In the order 1, 3, 2, 4, and with the wrong sense of the third edge.
        let shuffled = plate_with(|loops| {
            let mut all = coedges(&mut loops[which]);
            all.swap(1, 2);
            loops[which] = Loop::Edges(all);
        });
        let mistaken = plate_with(|loops| {
            let mut all = coedges(&mut loops[which]);
            all[2].reversed = true;
            loops[which] = Loop::Edges(all);
        });
        for (part, of) in [(shuffled, out_of_order as fn(&DiagnosticKind) -> bool), (mistaken, one_turned)] {
            let (prepared, _) = has_area(part, 76.0);
            assert!(warned(&prepared, of), "{:?}", told(&prepared));
            assert_eq!(prepared.diagnostics.len(), 1, "{:?}", told(&prepared));
        }
    }
    // Both wires as one list.
    let joined = plate_with(|loops| {
        let hole = loops.pop();
        let mut all = coedges(&mut loops[0]);
        all.extend(hole.map(|mut l| coedges(&mut l)).unwrap_or_default());
        loops[0] = Loop::Edges(all);
    });
    let (prepared, _) = has_area(joined, 76.0);
    assert!(warned(&prepared, out_of_order), "{:?}", told(&prepared));
}

#[test]
fn edges_whose_ends_lie_close_together_are_chained() {
    // Each edge has its own vertices, 3e-4 off the corner; the third edge has the wrong sense.
    let mut plate = PartBuilder::new("plate");
    let shell = plate.plain_shell(ShellKind::Open);
    let corners = flat(&PLATE);
    let coedges = (0..4).map(|k| {
        let off = 3e-4 * DVec3::new([1.0, 0.0, -1.0, 0.0][k], [0.0, 1.0, 0.0, -1.0][k], 0.0);
        let [from, to] = [corners[k] + off, corners[(k + 1) % 4] + off].map(|p| plate.vertex(p));
        Coedge { reversed: k == 2, ..plate.line(from, to).along() }
    });
    let coedges = coedges.collect();
    plate.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![Loop::Edges(coedges)], false);
    let prepared = prepared(plate.part().clone());
    let (facts, _) = mesh(&prepared, CHORDS[0]);
    assert!((facts.area - 80.0).abs() < 0.02, "{facts}");
    assert!(warned(&prepared, one_turned), "{:?}", told(&prepared));
    assert!(
        !warned(&prepared, |k| matches!(k, DiagnosticKind::Wire(WireTrouble::Bridged { .. }))),
        "{:?}",
        told(&prepared)
    );
}

#[test]
fn an_inner_wire_across_the_outer_is_reversed_outside() {
    // 4 x 2 in the middle of the right side: half of it outside, nearly all of it, less than half.
    for (inside, x) in [(2.0, 8.0), (0.5, 9.5), (3.5, 6.5)] {
        let hole: [(f64, f64); 4] = [(x, 3.0), (x, 5.0), (x + 4.0, 5.0), (x + 4.0, 3.0)];
        let outside = 8.0 - 2.0 * inside;
        let (prepared, report) = has_area(sheet(&[&PLATE, &hole]), 80.0 - 2.0 * inside + outside);
        assert!((report.fills[0].rewound - outside).abs() < 1e-9, "{:?}", report.fills);
        assert!(warned(&prepared, crosses), "{:?}", told(&prepared));
        assert_eq!(report.ladder.count(Rung::Repaired), 1);
    }
}

#[test]
fn holes_are_reversed_where_they_overlap() {
    let holes: [[(f64, f64); 4]; 2] =
        [[(2.0, 2.0), (2.0, 5.0), (6.0, 5.0), (6.0, 2.0)], [(4.0, 3.0), (4.0, 7.0), (8.0, 7.0), (8.0, 3.0)]];
    let (prepared, _) = has_area(sheet(&[&PLATE, &holes[0], &holes[1]]), 80.0 - 12.0 - 16.0 + 2.0 * 4.0);
    assert!(warned(&prepared, crosses), "{:?}", told(&prepared));
}

#[test]
fn holes_that_share_a_side_or_a_corner_are_two() {
    let a: [(f64, f64); 4] = [(2.0, 2.0), (2.0, 5.0), (4.0, 5.0), (4.0, 2.0)];
    for b in [[(4.0, 2.0), (4.0, 5.0), (6.0, 5.0), (6.0, 2.0)], [(4.0, 5.0), (4.0, 7.0), (6.0, 7.0), (6.0, 5.0)]] {
        has_area(sheet(&[&PLATE, &a, &b]), 80.0 - 12.0 + if b[0].1 == 2.0 { 0.0 } else { 2.0 });
    }
    // A side on part of the outer wire, and a corner on it.
    has_area(sheet(&[&PLATE, &[(10.0, 2.0), (7.0, 2.0), (7.0, 5.0), (10.0, 5.0)]]), 71.0);
    has_area(sheet(&[&PLATE, &[(10.0, 4.0), (8.0, 3.0), (8.0, 5.0)]]), 78.0);
}

#[test]
fn a_wire_outside_the_others_is_kept_as_a_region_of_its_own() {
    has_area(sheet(&[&PLATE, &[(12.0, 0.0), (12.0, 3.0), (14.0, 3.0), (14.0, 0.0)]]), 86.0);
}

#[test]
fn a_pentagram_is_covered_twice_in_the_middle() {
    let tip = |k: usize| {
        let p = DVec2::from_angle(TAU * (2 * k) as f64 / 5.0) * 5.0;
        (p.x, p.y)
    };
    let star: Vec<(f64, f64)> = (0..5).map(tip).collect();
    // Five triangles from the centre to a tip and the notches on both sides of it: |tip| |notch| sin 36° each.
    let notch = 5.0 * (TAU / 5.0).cos() / (TAU / 10.0).cos();
    let once = 5.0 * 5.0 * notch * (TAU / 10.0).sin();
    let middle = 2.5 * notch * notch * (TAU / 5.0).sin();
    let (prepared, _) = has_area(sheet(&[&star]), once + middle);
    assert!(warned(&prepared, crosses), "{:?}", told(&prepared));
}

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

/// A box whose edges have their own vertices, up to `by` off the corner.
fn loose_box(by: f64) -> Part {
    let mut part = shapes::cuboid();
    for k in 0..part.edges.len() {
        for end in 0..2 {
            let stated = if end == 0 { part.edges[k].start } else { part.edges[k].end };
            let off = DVec3::from_array([k % 3, k % 5, k % 7].map(|n| n as f64 / 7.0 - 0.5)) * by;
            part.vertices.push(part.vertices[stated.index()] + off);
            let own = VertexId::new(part.vertices.len() - 1);
            *(if end == 0 { &mut part.edges[k].start } else { &mut part.edges[k].end }) = own;
        }
    }
    part
}

#[test]
fn gaps_within_the_tolerance_close_and_stay_closed_between_faces() {
    for (by, tolerance) in [(1e-3, 2e-3), (1e-6, 0.0)] {
        let prepared = prepared(Part { tolerance, ..loose_box(by) });
        let told = told(&prepared);
        assert!(!told.is_empty() && told.iter().all(|(severity, _)| *severity == Severity::Note), "{told:?}");
        for chord in CHORDS {
            let (facts, report) = mesh(&prepared, chord);
            assert!(facts.is_closed(), "chord {chord}: {facts}");
            assert!((facts.volume - 6000.0).abs() < 1e3 * by, "chord {chord}: {facts}");
            assert_eq!(report.ladder.count(Rung::Normal), 6);
        }
    }
}

#[test]
fn wider_gaps_are_closed_straight_and_reported() {
    // One side of the plate is missing, 8 wide.
    let mut part = sheet(&[&PLATE]);
    let Loop::Edges(coedges) = &mut part.faces[0].loops[0] else { unreachable!("a loop of edges") };
    coedges.remove(1);
    let (prepared, report) = has_area(part, 80.0);
    let gap = WireTrouble::Bridged { width_mm: 8.0, gaps: 1 }.into();
    assert!(warned(&prepared, |k| *k == gap), "{:?}", told(&prepared));
    assert_eq!(report.ladder.count(Rung::Repaired), 1);
    assert!(prepared.diagnostics[0].place.is_some_and(|p| p.distance(DVec3::X * 10.0) < 1e-12));
}

#[test]
fn gaps_beyond_the_tolerance_that_are_small_for_the_part_leave_no_crack() {
    let prepared = prepared(Part { tolerance: 1e-6, ..loose_box(1e-3) });
    assert!(warned(&prepared, gaps), "{:?}", told(&prepared));
    for chord in CHORDS {
        let (facts, report) = mesh(&prepared, chord);
        assert!(facts.is_closed() && (facts.volume - 6000.0).abs() < 1.0, "chord {chord}: {facts}");
        assert_eq!(report.ladder.count(Rung::Repaired), 6);
    }
}

#[test]
fn faces_that_miss_the_same_edge_close_it_together() {
    let mut part = shapes::cuboid();
    for face in &mut part.faces {
        let Loop::Edges(coedges) = &mut face.loops[0] else { unreachable!("a loop of edges") };
        coedges.retain(|c| c.edge != EdgeId(3));
    }
    let prepared = prepared(part);
    assert_eq!(told(&prepared).len(), 2);
    for chord in CHORDS {
        let (facts, report) = mesh(&prepared, chord);
        assert!(facts.is_closed() && (facts.volume - 6000.0).abs() < 1e-6, "chord {chord}: {facts}");
        assert_eq!(report.ladder.count(Rung::Repaired), 2);
    }
}

#[test]
fn a_gap_on_a_curved_surface_is_closed_along_it() {
    // A third of a cylinder's side without its upper arc.
    let (radius, height, turn) = (5.0, 4.0, TAU / 3.0);
    let mut part = PartBuilder::new("shell");
    let shell = part.plain_shell(ShellKind::Open);
    let at = |angle: f64, z: f64| (DVec2::from_angle(angle) * radius).extend(z);
    let v = [(0.0, 0.0), (turn, 0.0), (turn, height), (0.0, height)].map(|(a, z)| part.vertex(at(a, z)));
    let bottom = part.curve(NurbsCurve3::arc(&Frame3::WORLD, radius, radius, 0.0, turn), CurveKind::Circle, v[0], v[1]);
    let (right, left) = (part.line(v[1], v[2]), part.line(v[3], v[0]));
    let wire = Loop::Edges(vec![bottom.along(), right.along(), left.along()]);
    part.plain_face(Surface::Cylinder { frame: Frame3::WORLD, radius }, shell, vec![wire], false);
    let prepared = prepared(part.part().clone());
    assert!(warned(&prepared, gaps), "{:?}", told(&prepared));
    for chord in CHORDS {
        let (facts, _) = mesh(&prepared, chord);
        let exact = radius * turn * height;
        assert!((facts.area - exact).abs() <= 4.0 * chord * radius * turn, "chord {chord}: {} of {exact}", facts.area);
    }
}

#[test]
fn a_wire_that_goes_round_twice_and_its_foot_once_bound_no_band_and_are_closed() {
    // Both turns are ellipses through one vertex. No area on the cylinder is bounded by one turn below and two above.
    let mut part = PartBuilder::new("band");
    let shell = part.plain_shell(ShellKind::Open);
    let start = part.vertex(DVec3::new(5.0, 0.0, 4.0));
    let slope = 0.4;
    let turns = [slope, -slope].map(|slope| {
        let y = DVec3::new(0.0, 1.0, slope);
        let frame = Frame3 { origin: DVec3::Z * 4.0, x: DVec3::X, y: y.normalize(), z: DVec3::X.cross(y).normalize() };
        let curve = NurbsCurve3::arc(&frame, 5.0, 5.0 * y.length(), 0.0, TAU);
        part.curve(curve, CurveKind::Conic, start, start).along()
    });
    let foot = part.circle(&Frame3::WORLD, 5.0);
    for foot in [foot.along(), foot.against()] {
        let mut part = part.clone();
        let loops = vec![Loop::Edges(vec![foot]), Loop::Edges(turns.to_vec())];
        part.plain_face(Surface::Cylinder { frame: Frame3::WORLD, radius: 5.0 }, shell, loops, false);
        let prepared = prepared(part.finish().expect("a sound part"));
        let closed = |k: &DiagnosticKind| matches!(k, DiagnosticKind::Face(FaceTrouble::TilesClosed { .. }));
        assert!(warned(&prepared, closed), "{:?}", told(&prepared));
        for chord in CHORDS {
            let (facts, report) = mesh(&prepared, chord);
            assert_eq!(report.ladder.count(Rung::Repaired), 1);
            // The foot and both turns, and nothing else.
            let exact = TAU * 5.0 + 2.0 * ellipse(5.0, 5.0 * (1.0 + slope * slope).sqrt());
            let length = facts.unbalanced_length;
            assert!(length < exact && length > 0.9 * exact, "chord {chord}: {length} of {exact}");
        }
    }
}

/// Circumference of an ellipse (S. Ramanujan's second approximation, 1914: exact to 1e-9 for these).
fn ellipse(a: f64, b: f64) -> f64 {
    let h = ((a - b) / (a + b)).powi(2);
    PI * (a + b) * (1.0 + 3.0 * h / (10.0 + (4.0 - 3.0 * h).sqrt()))
}

#[test]
fn a_band_without_one_of_its_bounds_ends_where_its_surface_does() {
    // A spline tube of height 6, bounded at height 2 only.
    let mut part = PartBuilder::new("tube");
    let shell = part.plain_shell(ShellKind::Open);
    let profile = NurbsCurve3::line(DVec3::new(5.0, 0.0, 0.0), DVec3::new(5.0, 0.0, 6.0));
    let foot = part.circle(&Frame3 { origin: DVec3::Z * 2.0, ..Frame3::WORLD }, 5.0);
    let surface = Surface::Revolution { curve: profile, frame: Frame3::WORLD };
    part.plain_face(surface, shell, vec![Loop::Edges(vec![foot.along()])], false);
    let prepared = prepared(part.finish().expect("a sound part"));
    let ends = |k: &DiagnosticKind| matches!(k, DiagnosticKind::Face(FaceTrouble::EndsWithSurface { axis: 1, .. }));
    assert!(warned(&prepared, ends), "{:?}", told(&prepared));
    for chord in CHORDS {
        let (facts, _) = mesh(&prepared, chord);
        let exact = TAU * 5.0 * 4.0;
        assert!((facts.area - exact).abs() <= 4.0 * chord * TAU * 5.0, "chord {chord}: {} of {exact}", facts.area);
    }
}

#[test]
fn a_face_without_a_region_is_filled_and_says_why_and_where() {
    // A cylinder has no end of its own.
    let mut part = PartBuilder::new("endless");
    let shell = part.plain_shell(ShellKind::Open);
    let foot = part.circle(&Frame3 { origin: DVec3::Z * 2.0, ..Frame3::WORLD }, 5.0);
    let wire = vec![Loop::Edges(vec![foot.along()])];
    part.plain_face(Surface::Cylinder { frame: Frame3::WORLD, radius: 5.0 }, shell, wire, false);
    let prepared = prepared(part.finish().expect("a sound part"));
    let told = told(&prepared);
    let one_sided = FaceError::Region(RegionError::OneSided { loops: 1 });
    let why = told[0].1.face_error();
    assert!(told.len() == 1 && told[0].0 == Severity::Warning && why == Some(&one_sided), "{told:?}");
    let (facts, report) = mesh(&prepared, 0.1);
    assert_eq!((report.ladder.count(Rung::Filled), report.rungs.len()), (1, 1));
    assert!((facts.area - 25.0 * PI).abs() < 0.1 * TAU * 5.0, "{facts}");
    assert!(facts.unbalanced_edges > 10 && facts.unbalanced_edges == facts.open_edges, "{facts}");
}

#[test]
fn a_bore_that_touches_the_outside_along_a_line_leaves_a_closed_solid() {
    // A cylinder of radius 5 and a bore of radius 3 that touch at (5, 0), with the wires' vertices there or elsewhere.
    let height = 4.0;
    for angles in [[0.0, 0.0], [1.0, 2.0], [2.5, 4.0]] {
        let mut part = PartBuilder::new("crescent");
        let shell = part.plain_shell(ShellKind::Outer);
        let mut lids = [Vec::new(), Vec::new()];
        for ((radius, x), angle) in [(5.0, 0.0), (3.0, 2.0)].into_iter().zip(angles) {
            let frame = |z: f64| {
                let x_axis = DVec2::from_angle(angle).extend(0.0);
                Frame3 { origin: DVec3::new(x, 0.0, z), x: x_axis, y: DVec3::Z.cross(x_axis), z: DVec3::Z }
            };
            let [low, high] = [0.0, height].map(|z| part.circle(&frame(z), radius));
            let wall = vec![Loop::Edges(vec![low.along()]), Loop::Edges(vec![high.against()])];
            part.plain_face(Surface::Cylinder { frame: frame(0.0), radius }, shell, wall, x > 0.0);
            lids[0].push(Loop::Edges(vec![if x > 0.0 { low.against() } else { low.along() }]));
            lids[1].push(Loop::Edges(vec![if x > 0.0 { high.against() } else { high.along() }]));
        }
        let [low, high] = lids;
        part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, low, true);
        let top = Frame3 { origin: DVec3::Z * height, ..Frame3::WORLD };
        part.plain_face(Surface::Plane { frame: top }, shell, high, false);
        let prepared = prepared(part.finish().expect("a sound part"));
        assert_eq!(told(&prepared), [], "{angles:?}");
        for chord in CHORDS {
            let (facts, report) = mesh(&prepared, chord);
            assert_eq!(report.ladder.count(Rung::Repaired), 0, "{angles:?}, chord {chord}");
            assert!(facts.is_closed(), "{angles:?}, chord {chord}: {facts}");
            let exact = PI * 16.0 * height;
            assert!((facts.volume - exact).abs() <= chord * TAU * 8.0 * height, "chord {chord}: {facts}");
        }
    }
}

#[test]
fn a_scribble_has_its_own_segments_as_its_boundary() {
    // Every segment crosses a quarter of the others: a quarter of a million crossings.
    let mut random = SplitMix(1);
    let scribble: Vec<(f64, f64)> = (0..1500).map(|_| (random.range(0.0, 10.0), random.range(0.0, 10.0))).collect();
    let (facts, report) = mesh(&prepared(sheet(&[&scribble])), 0.1);
    let [fill] = report.fills[..] else { panic!("{:?}", report.fills) };
    assert!(fill.slivers > 0 && fill.rewound > 0.0, "{fill:?}");
    assert_eq!(report.ladder.count(Rung::Repaired), 1);
    assert!(facts.is_well_formed() && facts.unbalanced_edges >= 1500, "{facts}");
    let length: f64 = (0..1500)
        .map(|k| {
            let [(a, b), (c, d)] = [scribble[k], scribble[(k + 1) % 1500]];
            (a - c).hypot(b - d)
        })
        .sum();
    assert!((facts.unbalanced_length - length).abs() < 1e-9 * length, "{} of {length}", facts.unbalanced_length);
}

#[test]
fn crossings_that_only_the_frame_resolves_keep_the_proportions_of_the_sheet() {
    // More crossings than the number for which prepare makes common points.
    let mut random = SplitMix(7);
    let scribble: Vec<(f64, f64)> = (0..160).map(|_| (random.range(0.0, 10.0), random.range(0.0, 10.0))).collect();
    let area = |stretch: f64| {
        let stretched: Vec<(f64, f64)> = scribble.iter().map(|&(x, y)| (x * stretch, y)).collect();
        let (facts, report) = mesh(&prepared(sheet(&[&stretched])), 0.1);
        let split = |d: &Degradation| matches!(d, Degradation::NotSimple { split, .. } if *split > 0);
        assert!(report.degraded.iter().any(|d| split(&d.degradation)), "{:?}", report.degraded);
        facts.area / stretch
    };
    // Triangles that only close the boundary lie along the segments and have no area.
    let [square, wide] = [1.0, 12.0].map(area);
    assert!((square - wide).abs() < 1e-6 * square, "{square} and {wide}");
}

/// A box of side 2 whose faces have their own edges, each face `off` further out than the one before.
fn own_edges(tolerance: f64, off: f64) -> Part {
    let mut part = PartBuilder::new("loose box");
    let shell = part.plain_shell(ShellKind::Outer);
    for (number, axis, side) in (0..6).map(|k| (k, k / 2, [-1.0, 1.0][k % 2])) {
        let [z, x] = [axis, (axis + 1) % 3].map(|k| DVec3::from_array(std::array::from_fn(|i| f64::from(i == k))));
        let frame = Frame3::from_axis(z * (side + off * number as f64), z * side, x).expect("axes");
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let corners = corners.map(|(u, v)| frame.origin + frame.x * u + frame.y * v);
        let wire = Loop::Edges(part.polygon(&corners));
        part.plain_face(Surface::Plane { frame }, shell, vec![wire], false);
    }
    let mut part = part.finish().expect("a sound part");
    part.tolerance = tolerance;
    part
}

#[test]
fn a_solid_whose_faces_share_no_edges_is_reported_as_open() {
    for (tolerance, off) in [(0.0, 0.0), (1e-3, 1e-2)] {
        let prepared = prepared(own_edges(tolerance, off));
        let open = ShellTrouble::Open { free: 24, edges: 24 }.into();
        assert!(warned(&prepared, |k| *k == open), "{:?}", told(&prepared));
    }
}

#[test]
fn edges_that_coincide_within_the_tolerance_are_sewn() {
    for off in [0.0, 1e-6, 1e-4] {
        let prepared = prepared(own_edges(1e-3, off));
        let (facts, _) = mesh(&prepared, 0.1);
        assert!(facts.is_closed() && (facts.volume - 8.0).abs() < 1e-2, "{off}: {facts}");
        // Sewing moves the edges of the outer faces inwards; the note says by how much.
        let told = told(&prepared);
        let sewn = matches!(told[0].1, DiagnosticKind::Border(BorderTrouble::Sewn { pairs: 12, .. }));
        assert!(told.iter().all(|t| t.0 == Severity::Note) && sewn, "{told:?}");
    }
}

/// A disc of radius 5 whose faces have their own edges: circles of `arcs` pieces.
fn coin(thickness: f64, tolerance: f64, arcs: usize) -> Part {
    let mut part = PartBuilder::new("coin");
    let shell = part.plain_shell(ShellKind::Outer);
    let frame = |z: f64| Frame3 { origin: DVec3::Z * z, ..Frame3::WORLD };
    let circle = |part: &mut PartBuilder, z: f64| -> Vec<EdgeId> {
        let at = |k: usize| TAU * k as f64 / arcs as f64;
        let point = |k: usize| frame(z).place(5.0 * DVec2::from_angle(at(k)).extend(0.0));
        let vertices: Vec<VertexId> = (0..arcs).map(|k| part.vertex(point(k))).collect();
        let arc = |k: usize| {
            let curve = NurbsCurve3::arc(&frame(z), 5.0, 5.0, at(k), at(k + 1));
            part.curve(curve, CurveKind::Conic, vertices[k], vertices[(k + 1) % arcs])
        };
        (0..arcs).map(arc).collect()
    };
    let up = |edges: Vec<EdgeId>| Loop::Edges(edges.into_iter().map(EdgeId::along).collect());
    let down = |edges: Vec<EdgeId>| Loop::Edges(edges.into_iter().rev().map(EdgeId::against).collect());
    let [bottom, low, high, top] = [0.0, 0.0, thickness, thickness].map(|z| circle(&mut part, z));
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![up(bottom)], true);
    part.plain_face(Surface::Plane { frame: frame(thickness) }, shell, vec![up(top)], false);
    let side = Surface::Cylinder { frame: Frame3::WORLD, radius: 5.0 };
    part.plain_face(side, shell, vec![up(low), down(high)], false);
    let mut part = part.finish().expect("a sound part");
    part.tolerance = tolerance;
    part
}

#[test]
fn sewing_keeps_faces_that_are_thinner_than_the_tolerance() {
    for (thickness, arcs) in [(0.5, 1), (5e-3, 1), (5e-3, 2), (5e-3, 3), (1e-3, 2)] {
        let prepared = prepared(coin(thickness, 1e-2, arcs));
        let (facts, _) = mesh(&prepared, 1e-2);
        let volume = PI * 25.0 * thickness;
        assert!(facts.is_closed() && (facts.volume - volume).abs() < 2e-2 * volume, "{thickness}, {arcs}: {facts}");
        let told = told(&prepared);
        let kept = told.iter().any(|t| matches!(t.1, DiagnosticKind::Border(BorderTrouble::ThinFace { .. })));
        assert!(told.iter().all(|t| t.0 == Severity::Note) && kept == (thickness < 1e-2), "{told:?}");
    }
}

#[test]
fn a_seam_of_two_edges_becomes_one() {
    let mut part = PartBuilder::new("cylinder");
    let shell = part.plain_shell(ShellKind::Outer);
    let height = 10.0;
    let frame = |z: f64| Frame3 { origin: DVec3::Z * z, ..Frame3::WORLD };
    let [low, high] = [0.0, height].map(|z| part.circle(&frame(z), 5.0));
    let ends = [low, high].map(|e| part.part().edges[e.index()].start);
    let seam = [0, 1].map(|_| part.line(ends[0], ends[1]));
    let side = Loop::Edges(vec![low.along(), seam[0].along(), high.against(), seam[1].against()]);
    part.plain_face(Surface::Cylinder { frame: Frame3::WORLD, radius: 5.0 }, shell, vec![side], false);
    part.plain_face(Surface::Plane { frame: frame(0.0) }, shell, vec![Loop::Edges(vec![low.along()])], true);
    part.plain_face(Surface::Plane { frame: frame(height) }, shell, vec![Loop::Edges(vec![high.along()])], false);
    let mut part = part.finish().expect("a sound part");
    part.tolerance = 1e-2;
    let prepared = prepared(part);
    let (facts, _) = mesh(&prepared, 1e-2);
    assert!(facts.is_closed() && (facts.volume / (PI * 250.0) - 1.0).abs() < 1e-2, "{facts}");
}

#[test]
fn a_solid_of_the_same_half_twice_is_reported_to_enclose_nothing() {
    let mut part = PartBuilder::new("two halves of one kind");
    let shell = part.plain_shell(ShellKind::Outer);
    let equator = part.circle(&Frame3::WORLD, 10.0);
    let sphere = Surface::Sphere { frame: Frame3::WORLD, radius: 10.0 };
    for _ in 0..2 {
        part.plain_face(sphere.clone(), shell, vec![Loop::Edges(vec![equator.along()])], false);
    }
    let prepared = prepared(part.finish().expect("a sound part"));
    assert!(warned(&prepared, |k| *k == ShellTrouble::NoVolume { faces: 2 }.into()), "{:?}", told(&prepared));
}

#[test]
fn surfaces_without_area_are_reported_and_have_no_triangles() {
    let at = |x: f64| DVec3::X * x;
    let knots = vec![0.0, 0.0, 1.0, 1.0];
    // A spline along one line; and a circle turned about its own axis.
    let line = trimtess::model::NurbsSurface {
        degree_u: 1,
        degree_v: 1,
        knots_u: knots.clone(),
        knots_v: knots,
        points: vec![at(0.0), at(1.0), at(1.0), at(2.0)],
        weights: Vec::new(),
    };
    let circle = NurbsCurve3::arc(&Frame3::WORLD, 2.0, 2.0, 0.0, TAU);
    for surface in [Surface::Nurbs(line), Surface::Revolution { curve: circle, frame: Frame3::WORLD }] {
        let mut part = PartBuilder::new("no area");
        let shell = part.plain_shell(ShellKind::Open);
        part.plain_face(surface, shell, Vec::new(), false);
        let prepared = prepared(part.finish().expect("a sound part"));
        assert_eq!(prepared.tiles().count(), 0);
        let why = prepared.diagnostics[0].kind.face_error();
        assert!(matches!(why, Some(FaceError::NoArea { .. })), "{:?}", prepared.diagnostics);
    }
}
