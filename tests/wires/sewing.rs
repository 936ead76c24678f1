//! Faces without common edges: what is sewn and what is not.

use crate::common::whole;
use crate::{mesh, prepared, told, warned};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use trimtess::model::{
    BorderTrouble, CurveKind, DiagnosticKind, EdgeId, FaceError, Frame3, Loop, NurbsCurve3, NurbsSurface, Part,
    PartBuilder, Severity, ShellKind, ShellTrouble, Surface, VertexId,
};

/// A box of side 2 whose faces have their own edges, each face `off` further out than the one before.
fn own_edges(kind: ShellKind, tolerance: f64, off: f64) -> Part {
    let mut part = PartBuilder::new("loose box");
    let shell = part.plain_shell(kind);
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
        let prepared = prepared(own_edges(ShellKind::Outer, tolerance, off));
        let open = ShellTrouble::Open { free: 24, edges: 24 }.into();
        assert!(warned(&prepared, |k| *k == open), "{:?}", told(&prepared));
    }
}

#[test]
fn edges_that_coincide_within_the_tolerance_are_sewn() {
    // The last tolerance is too large for edges of length 2, but they coincide within a smaller one.
    let solid = [(1e-3, 0.0), (1e-3, 1e-6), (1e-3, 1e-4), (0.5, 0.0), (0.5, 1e-4)].map(|case| (ShellKind::Outer, case));
    // Sheets are sewn within a millionth of the part at most.
    let open = [(1e-3, 0.0), (1e-3, 1e-7), (1e-7, 0.0)].map(|case| (ShellKind::Open, case));
    for (kind, (tolerance, off)) in solid.into_iter().chain(open) {
        let prepared = prepared(own_edges(kind, tolerance, off));
        let (facts, _) = mesh(&prepared, 0.1);
        assert!(facts.is_closed() && (facts.volume - 8.0).abs() < 1e-2, "{tolerance} {off}: {facts}");
        // Sewing moves the edges of the outer faces inwards; the note says by how much.
        let told = told(&prepared);
        let sewn = matches!(told[0].1, DiagnosticKind::Border(BorderTrouble::Sewn { pairs: 12, .. }));
        assert!(told.iter().all(|t| t.0 == Severity::Note) && sewn, "{told:?}");
    }
}

#[test]
fn sheets_on_top_of_each_other_stay_two_sheets() {
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    // Of one face or two side by side each.
    for (off, faces) in [(0.0, 1_u8), (1e-7, 1), (0.0, 2), (1e-7, 2)] {
        let mut part = PartBuilder::new("plies");
        let shell = part.plain_shell(ShellKind::Open);
        for (z, x) in [0.0, off].into_iter().flat_map(|z| (0..faces).map(move |x| (z, f64::from(x)))) {
            let frame = Frame3 { origin: DVec3::new(x, 0.0, z), ..Frame3::WORLD };
            let wire = Loop::Edges(part.polygon(&square.map(|corner| corner + frame.origin)));
            part.plain_face(Surface::Plane { frame }, shell, vec![wire], false);
        }
        let mut part = part.finish().expect("a sound part");
        part.tolerance = 1e-3;
        let prepared = prepared(part);
        let open = prepared.parts[0].open_edges().count;
        assert!(open >= 4 * (usize::from(faces) + 1), "{off} {faces}: {open} open");
        assert!(prepared.parts[0].edges.iter().all(|edge| edge.uses.len() <= 2), "{off} {faces}");
        assert!(prepared.parts[0].faces.iter().all(|face| !face.reversed), "{off} {faces}: turned over");
    }
}

#[test]
fn sheets_that_miss_each_other_by_more_than_a_millionth_are_not_sewn() {
    let (facts, _) = mesh(&prepared(own_edges(ShellKind::Open, 1e-3, 1e-4)), 0.1);
    assert_eq!(facts.open_edges, 24, "{facts}");
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
    // A spline along one line; and a circle turned about its own axis.
    let line = NurbsSurface::bezier((1, 1), [0.0, 1.0, 1.0, 2.0].map(at).to_vec(), Vec::new());
    let circle = NurbsCurve3::arc(&Frame3::WORLD, 2.0, 2.0, 0.0, TAU);
    for surface in [Surface::Nurbs(line), Surface::Revolution { curve: circle, frame: Frame3::WORLD }] {
        let prepared = prepared(whole(surface));
        assert_eq!(prepared.tiles().count(), 0);
        let why = prepared.diagnostics[0].kind.face_error();
        assert!(matches!(why, Some(FaceError::NoArea { .. })), "{:?}", prepared.diagnostics);
    }
}
