//! Wires that leave gaps, miss bounds or have no region.

use crate::random::SplitMix;
use crate::{CHORDS, PLATE, assert_area, gaps, mesh, prepared, sheet, told, warned};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use trimtess::frame::{Degradation, Rung};
use trimtess::model::{
    CurveKind, DiagnosticKind, EdgeId, FaceError, FaceTrouble, Frame3, Loop, NurbsCurve3, Part, PartBuilder,
    RegionError, Severity, ShellKind, Surface, VertexId, WireTrouble, shapes,
};

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
    let (prepared, report) = assert_area(part, 80.0);
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
