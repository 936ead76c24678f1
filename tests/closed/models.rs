//! Smallest inputs, stated by hand.

use crate::chains::assert_chains_close;
use crate::common;
use glam::DVec3;
use std::sync::Arc;
use trimtess::model::{
    CurveKind, Edge, EdgeId, Frame3, Loop, NurbsCurve3, NurbsSurface, Part, PartBuilder, Severity, ShellKind, Surface,
    VertexId,
};
use trimtess::prepare::Prepared;

/// Prepares a part, sound or not.
fn prepared(part: Part) -> Arc<Prepared> {
    let prepared = common::prepared(part);
    assert_chains_close(&prepared);
    prepared
}

fn is_closed(prepared: &Prepared) -> bool {
    prepared.scene.parts[0].closed
}

fn filled(prepared: &Prepared) -> usize {
    prepared.parts[0].faces.iter().filter(|face| face.filled).count()
}

const CORNERS: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [4.0, 0.0, 0.0],
    [4.0, 3.0, 0.0],
    [0.0, 3.0, 0.0],
    [0.0, 0.0, 2.0],
    [4.0, 0.0, 2.0],
    [4.0, 3.0, 2.0],
    [0.0, 3.0, 2.0],
];

/// Corners of the sides of a block, counter-clockwise from outside.
const SIDES: [[usize; 4]; 6] = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

/// A block of 4 × 3 × 2 with shared edges; sides are faces 0 to 5.
fn block() -> Part {
    let mut part = PartBuilder::new("block");
    let shell = part.plain_shell(ShellKind::Outer);
    let vertices = CORNERS.map(|p| part.vertex(DVec3::from_array(p)));
    let mut edges: Vec<([usize; 2], EdgeId)> = Vec::new();
    for side in SIDES {
        let mut coedges = Vec::new();
        for k in 0..4 {
            let (a, b) = (side[k], side[(k + 1) % 4]);
            let known = edges.iter().find(|e| e.0 == [b, a]).map(|e| e.1.against());
            coedges.push(known.unwrap_or_else(|| {
                let edge = part.line(vertices[a], vertices[b]);
                edges.push(([a, b], edge));
                edge.along()
            }));
        }
        let [a, b, _, d] = side.map(|k| DVec3::from_array(CORNERS[k]));
        let frame = Frame3::from_axis(a, (b - a).cross(d - a), b - a).expect("an axis");
        part.plain_face(Surface::Plane { frame }, shell, vec![Loop::Edges(coedges)], false);
    }
    part.finish().expect("a sound block")
}

#[test]
fn a_block_is_closed() {
    let prepared = prepared(block());
    assert!(is_closed(&prepared) && filled(&prepared) == 0, "{:?}", prepared.diagnostics);
    assert!(prepared.diagnostics.is_empty(), "{:?}", prepared.diagnostics);
}

#[test]
fn a_face_with_an_unusable_surface_is_filled() {
    let bilinear = |points: Vec<DVec3>| NurbsSurface::bezier((1, 1), points, Vec::new());
    let of = |points: [DVec3; 4]| Surface::Nurbs(bilinear(points.to_vec()));
    let surfaces = [
        // Far off.
        Surface::Plane { frame: Frame3 { origin: DVec3::Z * 9.0, ..Frame3::WORLD } },
        // A NaN radius, and a net without points.
        Surface::Sphere { frame: Frame3::WORLD, radius: f64::NAN },
        Surface::Nurbs(bilinear(Vec::new())),
        // Without area: a line, and a point.
        of([0.0, 1.0, 1.0, 2.0].map(|x| DVec3::X * x)),
        of([DVec3::ZERO; 4]),
        // Its arithmetic overflows.
        of([DVec3::ZERO, DVec3::X * 1e300, DVec3::Y * 1e300, DVec3::splat(1e300)]),
        // Edge on: the loop has no width there.
        Surface::Plane { frame: Frame3 { x: DVec3::X, y: DVec3::Z, z: -DVec3::Y, ..Frame3::WORLD } },
    ];
    for (k, surface) in surfaces.into_iter().enumerate() {
        let mut part = block();
        part.faces[0].surface = surface;
        let prepared = prepared(part);
        assert!(is_closed(&prepared) && filled(&prepared) == 1, "{k}: {:?}", prepared.diagnostics);
        let told = prepared.diagnostics.iter().find(|d| d.face.is_some_and(|face| face.0 == 0));
        assert!(told.is_some_and(|d| d.severity < Severity::Error), "{k}: {:?}", prepared.diagnostics);
    }
}

#[test]
fn an_edge_without_a_curve_is_straight() {
    for broken in [0, 1, 2] {
        let mut part = block();
        let edge = &mut part.edges[0];
        match broken {
            0 => edge.curve.points.truncate(1),
            1 => edge.range = (1.0, 0.0),
            _ => edge.curve.points[1] = DVec3::NAN,
        }
        let prepared = prepared(part);
        // The vertices state where a line ends, whatever its points are.
        let expected = if broken == 2 { 0 } else { 2 };
        assert!(is_closed(&prepared) && filled(&prepared) == expected, "{broken}: {:?}", prepared.diagnostics);
    }
}

#[test]
fn only_faces_with_a_nan_have_no_tile() {
    let mut part = block();
    part.vertices[0].x = f64::NAN;
    let prepared = prepared(part);
    let lost = prepared.parts[0].face_rows.iter().filter(|row| row.is_none()).count();
    assert!(!is_closed(&prepared) && lost == 3, "{lost}: {:?}", prepared.diagnostics);
}

#[test]
fn faces_that_name_missing_entities_cost_only_themselves() {
    let mut part = block();
    let Loop::Edges(coedges) = &mut part.faces[1].loops[0] else { unreachable!() };
    coedges[0].edge = EdgeId(99);
    part.edges[11].start = VertexId(99);
    let prepared = prepared(part);
    assert!(!is_closed(&prepared) && prepared.parts[0].faces.len() >= 3, "{:?}", prepared.diagnostics);
}

#[test]
fn a_slit_between_two_faces_is_filled_as_far_as_it_does_not_cancel() {
    // A face between two coincident edges, on a surface that is a line; the block's face next to it has the other edge.
    let mut part = block();
    let first = part.edges[0].clone();
    part.edges.push(Edge { kind: CurveKind::Line, ..first });
    let twin = EdgeId::new(part.edges.len() - 1);
    let Loop::Edges(coedges) = &mut part.faces[0].loops[0] else { unreachable!() };
    let old = coedges.iter_mut().find(|c| c.edge == EdgeId(0)).expect("face 0 has edge 0");
    old.edge = twin;
    let reversed = old.reversed;
    let [a, b] = [part.edges[0].start, part.edges[0].end].map(|v| part.vertices[v.index()]);
    let surface = Surface::Nurbs(NurbsSurface::bezier((1, 1), vec![a, b, a, b], Vec::new()));
    let [own, other] = if reversed { [EdgeId(0).against(), twin.along()] } else { [EdgeId(0).along(), twin.against()] };
    let face = trimtess::model::Face { surface, loops: vec![Loop::Edges(vec![own, other])], ..part.faces[0].clone() };
    part.faces.push(face);
    let prepared = prepared(part);
    assert!(is_closed(&prepared) && filled(&prepared) == 1, "{:?}", prepared.diagnostics);
    assert_eq!(prepared.scene.parts[0].without_area.len(), 1);
}

#[test]
fn a_lobe_with_neighbours_is_not_turned() {
    // A bow tie: the adjacent sides of the block traverse its edges consistently with it.
    let mut part = block();
    // Top and bottom swap their second and third corner; the sides follow.
    part.vertices.swap(1, 2);
    part.vertices.swap(5, 6);
    for e in &mut part.edges {
        let [a, b] = [e.start, e.end].map(|v| part.vertices[v.index()]);
        e.curve = NurbsCurve3::line(a, b);
        e.range = e.curve.domain();
    }
    let corner = |part: &Part, k: usize| part.vertices[k];
    for (k, side) in SIDES.iter().enumerate().skip(2) {
        let [a, b, d] = [side[0], side[1], side[3]].map(|k| corner(&part, k));
        let frame = Frame3::from_axis(a, (b - a).cross(d - a), b - a).expect("an axis");
        part.faces[k].surface = Surface::Plane { frame };
    }
    let prepared = prepared(part);
    assert!(is_closed(&prepared), "{:?}", prepared.diagnostics);
}
