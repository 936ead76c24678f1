//! Wires of a plane face that cross, overlap, touch or are out of order.

use crate::{
    CHORDS, PLATE, assert_area, crosses, flat, mesh, one_lobe, one_turned, out_of_order, prepared, sheet, told, warned,
};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use trimtess::frame::{Degradation, Rung, Tolerance, plan};
use trimtess::mesh::{MemorySink, check_scene};
use trimtess::model::{
    Coedge, CurveKind, DiagnosticKind, Edge, FaceTrouble, Frame3, Loop, NurbsCurve3, Part, PartBuilder, Severity,
    ShellKind, Surface, WireTrouble,
};
use trimtess::parallel::serial;

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
        let (prepared, report) = assert_area(sheet(&[&wire]), area);
        assert!(warned(&prepared, one_lobe), "{:?}", told(&prepared));
        let at = prepared.diagnostics[0].place.expect("a place");
        assert!(at.distance(DVec3::new(place.0, place.1, 0.0)) < 1e-9, "{at}");
        assert_eq!(report.ladder.count(Rung::Repaired), 1);
        assert_eq!(report.rungs.len(), 1);
    }
}

#[test]
fn an_eight_with_kinks_keeps_both_lobes() {
    for corners in [12, 30, 90] {
        // One closed edge of straight pieces: a kink at every corner.
        let at = |k: usize| {
            let t = TAU * (k as f64 + 0.37) / f64::from(corners) + 0.5 * PI;
            DVec3::new(4.0 * t.cos(), 2.0 * (2.0 * t).sin(), 0.0)
        };
        let points: Vec<DVec3> = (0..=corners as usize).map(at).collect();
        let knots = (0..=corners).map(f64::from);
        let knots = std::iter::once(0.0).chain(knots).chain([f64::from(corners)]).collect();
        let mut part = PartBuilder::new("eight");
        let shell = part.plain_shell(ShellKind::Open);
        let curve = NurbsCurve3 { degree: 1, knots, points: points.clone(), weights: Vec::new() };
        let start = part.vertex(points[0]);
        let range = curve.domain();
        let edge = part.edge(Edge { curve, range, start, end: start, kind: CurveKind::Spline, entity: 0 });
        part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![Loop::Edges(vec![edge.along()])], false);
        // The lobes are mirror images of each other, and cross on x = 0.
        let enter = points.windows(2).find(|w| w[0].x < 0.0 && w[1].x >= 0.0).expect("a segment across x = 0");
        let crossing = enter[0].lerp(enter[1], -enter[0].x / (enter[1].x - enter[0].x));
        let from_crossing = |p: DVec3| (p - crossing).truncate();
        let right = points.windows(2).filter(|w| w[0].x > 0.0 && w[1].x > 0.0);
        let lobe: f64 = right.map(|w| 0.5 * from_crossing(w[0]).perp_dot(from_crossing(w[1]))).sum();
        let (prepared, report) = assert_area(part.finish().expect("a sound part"), 2.0 * lobe.abs());
        assert!(warned(&prepared, one_lobe), "{corners}: {:?}", told(&prepared));
        assert_eq!(report.ladder.count(Rung::Repaired), 1);
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
                let plan = Arc::new(plan(&prepared, &Tolerance { chord, angle: 0.5, max_edge: None }));
                serial(&prepared, &plan, true, &mut sink).expect("a frame");
                let facts = check_scene(&sink).total;
                assert_eq!(facts.defects, 0, "{} corners, z {z}: {facts}; {:?}", points.len(), prepared.diagnostics);
            }
        }
    }
}

#[test]
fn chords_of_curves_that_touch_in_a_cusp_may_cross_within_the_tolerance() {
    // Parabolas y = x² and y = (1 + gap) x² from (0, 0) to x = 4, and the line between their ends.
    let (mut crossed, mut rewound) = (0, 0);
    for gap in [0.01, 0.02, 0.05, 0.1, 0.2] {
        let mut part = PartBuilder::new("cusp");
        let shell = part.plain_shell(ShellKind::Open);
        let ends = [0.0, 16.0, 16.0 * (1.0 + gap)].map(|y: f64| DVec3::new(if y > 0.0 { 4.0 } else { 0.0 }, y, 0.0));
        let [cusp, low, high] = ends.map(|p| part.vertex(p));
        let parabola = |part: &mut PartBuilder, to, point: DVec3| {
            let curve = NurbsCurve3::bezier(vec![DVec3::ZERO, DVec3::X * 2.0, point], Vec::new());
            part.edge(Edge { range: curve.domain(), curve, start: cusp, end: to, kind: CurveKind::Spline, entity: 0 })
        };
        let area = gap * 64.0 / 3.0;
        let sides = [parabola(&mut part, low, ends[1]), parabola(&mut part, high, ends[2])];
        let wire = vec![sides[0].along(), part.line(low, high).along(), sides[1].against()];
        part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![Loop::Edges(wire)], false);
        let prepared = prepared(part.finish().expect("a sound part"));
        for k in 0..40 {
            let chord = 0.5 * 0.8_f64.powi(k);
            let plan = Arc::new(plan(&prepared, &Tolerance { chord, angle: 0.5, max_edge: None }));
            let mut sink = MemorySink::default();
            let report = serial(&prepared, &plan, true, &mut sink).expect("a frame");
            let told = report.diagnostics(&sink, &prepared);
            assert!(told.iter().all(|d| d.severity == Severity::Note), "{gap} {chord}: {told:?}");
            let depths = report.degraded.iter().map(|tile| match tile.degradation {
                Degradation::NotSimple { depth, .. } => depth,
                _ => panic!("{gap} {chord}: {tile:?}"),
            });
            crossed += depths.filter(|depth| *depth > 1e-5).count();
            rewound += usize::from(report.fills.iter().any(|fill| fill.rewound > 2e-4 * area));
            let facts = check_scene(&sink).total;
            assert_eq!(facts.defects, 0, "{gap} {chord}: {facts}");
        }
    }
    assert!(crossed > 0 && rewound > 0, "{crossed} crossings, {rewound} with a large share of the face");
}

#[test]
fn a_hole_like_an_eight_is_two_holes() {
    // Two lobes of 2 x 2 / 2 around (3, 4), and the same crossing at a vertex that is passed twice.
    let lobes = [(2.0, 3.0), (4.0, 5.0), (4.0, 3.0), (2.0, 5.0)];
    let (prepared, _) = assert_area(sheet(&[&PLATE, &lobes]), 78.0);
    assert!(warned(&prepared, one_lobe), "{:?}", told(&prepared));
    let through = [(2.0, 3.0), (3.0, 4.0), (4.0, 5.0), (4.0, 3.0), (3.0, 4.0), (2.0, 5.0)];
    let (prepared, _) = assert_area(sheet(&[&PLATE, &through]), 78.0);
    assert!(warned(&prepared, one_lobe), "{:?}", told(&prepared));
}

#[test]
fn a_wire_wound_twice_through_one_vertex_is_covered_twice() {
    let wire = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (0.0, 0.0), (9.0, 1.0), (9.0, 9.0), (1.0, 9.0)];
    let (prepared, report) = assert_area(sheet(&[&wire]), 100.0 + 72.0);
    assert!((report.fills[0].rewound - 72.0).abs() < 1e-9, "{:?}", report.fills);
    assert!(warned(&prepared, |k| *k == FaceTrouble::Crosses.into()), "{:?}", told(&prepared));
    assert_eq!(report.ladder.count(Rung::Repaired), 1);
    // Also where edges are short, so that triangles lie far within.
    for (max_edge, chord) in [(None, 0.1), (Some(0.5), 2.0)] {
        let plan = Arc::new(plan(&prepared, &Tolerance { chord, angle: 0.5, max_edge }));
        let mut sink = MemorySink::default();
        let report = serial(&prepared, &plan, true, &mut sink).expect("a frame");
        let told = report.diagnostics(&sink, &prepared);
        let codes: Vec<_> = told.iter().map(|d| (d.severity, d.kind.code())).collect();
        assert!(codes.contains(&(Severity::Warning, "face-wound-again")), "{chord}: {codes:?}");
    }
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
            let (prepared, _) = assert_area(part, 76.0);
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
    let (prepared, _) = assert_area(joined, 76.0);
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
        let (prepared, report) = assert_area(sheet(&[&PLATE, &hole]), 80.0 - 2.0 * inside + outside);
        assert!((report.fills[0].rewound - outside).abs() < 1e-9, "{:?}", report.fills);
        assert!(warned(&prepared, crosses), "{:?}", told(&prepared));
        assert_eq!(report.ladder.count(Rung::Repaired), 1);
    }
}

#[test]
fn holes_are_reversed_where_they_overlap() {
    let holes: [[(f64, f64); 4]; 2] =
        [[(2.0, 2.0), (2.0, 5.0), (6.0, 5.0), (6.0, 2.0)], [(4.0, 3.0), (4.0, 7.0), (8.0, 7.0), (8.0, 3.0)]];
    let (prepared, _) = assert_area(sheet(&[&PLATE, &holes[0], &holes[1]]), 80.0 - 12.0 - 16.0 + 2.0 * 4.0);
    assert!(warned(&prepared, crosses), "{:?}", told(&prepared));
}

#[test]
fn holes_that_share_a_side_or_a_corner_are_two() {
    let a: [(f64, f64); 4] = [(2.0, 2.0), (2.0, 5.0), (4.0, 5.0), (4.0, 2.0)];
    for b in [[(4.0, 2.0), (4.0, 5.0), (6.0, 5.0), (6.0, 2.0)], [(4.0, 5.0), (4.0, 7.0), (6.0, 7.0), (6.0, 5.0)]] {
        assert_area(sheet(&[&PLATE, &a, &b]), 80.0 - 12.0 + if b[0].1 == 2.0 { 0.0 } else { 2.0 });
    }
    // A side on part of the outer wire, and a corner on it.
    assert_area(sheet(&[&PLATE, &[(10.0, 2.0), (7.0, 2.0), (7.0, 5.0), (10.0, 5.0)]]), 71.0);
    assert_area(sheet(&[&PLATE, &[(10.0, 4.0), (8.0, 3.0), (8.0, 5.0)]]), 78.0);
}

#[test]
fn a_wire_outside_the_others_is_kept_as_a_region_of_its_own() {
    assert_area(sheet(&[&PLATE, &[(12.0, 0.0), (12.0, 3.0), (14.0, 3.0), (14.0, 0.0)]]), 86.0);
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
    let (prepared, _) = assert_area(sheet(&[&star]), once + middle);
    assert!(warned(&prepared, crosses), "{:?}", told(&prepared));
}
