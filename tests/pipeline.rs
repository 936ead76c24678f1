//! Model -> prepare -> plan -> tiles: closed solids give closed meshes at every tolerance.

mod common;

use common::{placed, prepared_clean};
use glam::DVec3;
use std::sync::Arc;
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::{MemorySink, check_scene};
use trimtess::model::{
    Coedge, CurveKind, Edge, EdgeId, Face, Frame3, Loop, Model, NurbsCurve3, Part, Shell, ShellKind, Surface, VertexId,
};
use trimtess::parallel::{Session, SessionOptions};

fn coedge(edge: u32, reversed: bool) -> Coedge {
    Coedge { edge: EdgeId(edge), reversed }
}

/// A closed cylinder about z of radius 5 and height 8, with or without a seam edge on its side.
fn cylinder(seam: bool) -> Part {
    let top = Frame3 { origin: DVec3::Z * 8.0, ..Frame3::WORLD };
    let circle = |frame: &Frame3| NurbsCurve3::arc(frame, 5.0, 5.0, 0.0, std::f64::consts::TAU);
    let edge = |curve: NurbsCurve3, start: u32, end: u32, kind| {
        let range = curve.domain();
        Edge { curve, range, start: VertexId(start), end: VertexId(end), kind, entity: 0 }
    };
    let vertices = vec![DVec3::new(5.0, 0.0, 0.0), DVec3::new(5.0, 0.0, 8.0)];
    let edges = vec![
        edge(circle(&Frame3::WORLD), 0, 0, CurveKind::Circle),
        edge(circle(&top), 1, 1, CurveKind::Circle),
        edge(NurbsCurve3::line(vertices[0], vertices[1]), 0, 1, CurveKind::Line),
    ];
    let side = if seam {
        vec![Loop::Edges(vec![coedge(0, false), coedge(2, false), coedge(1, true), coedge(2, true)])]
    } else {
        vec![Loop::Edges(vec![coedge(0, false)]), Loop::Edges(vec![coedge(1, true)])]
    };
    let faces = vec![
        Face::new(Surface::Cylinder { frame: Frame3::WORLD, radius: 5.0 }, 0, side, false),
        Face::new(Surface::Plane { frame: Frame3::WORLD }, 0, vec![Loop::Edges(vec![coedge(0, true)])], true),
        Face::new(Surface::Plane { frame: top }, 0, vec![Loop::Edges(vec![coedge(1, false)])], false),
    ];
    Part { vertices, edges, faces, shells: vec![Shell { kind: ShellKind::Outer, entity: 0 }], ..Part::default() }
}

fn mesh(model: Model, chord: f64) -> MemorySink {
    let prepared = prepared_clean(model);
    let plan = Arc::new(plan(&prepared, &Tolerance { chord, angle: 0.5, max_edge: None }));
    let mut sink = MemorySink::default();
    let mut session = Session::start(prepared, &SessionOptions::DEFAULT.with_workers(1)).expect("threads");
    let report = session.frame(plan, &mut sink).expect("a frame");
    assert!(report.degraded.is_empty(), "{:?}", report.degraded);
    sink
}

#[test]
fn a_cylinder_is_closed_with_and_without_a_seam() {
    for seam in [true, false] {
        for chord in [1.0, 0.1, 0.01, 1e-4] {
            let sink = mesh(placed(cylinder(seam)), chord);
            let facts = check_scene(&sink).total;
            assert_eq!(facts.unbalanced_edges, 0, "seam {seam}, chord {chord}: {facts}");
            let exact = std::f64::consts::PI * 25.0 * 8.0;
            let slack = 4.0 * chord * std::f64::consts::TAU * 5.0 * 8.0;
            assert!(facts.volume > exact - slack && facts.volume < exact, "volume {} of {exact}", facts.volume);
        }
    }
}

#[test]
fn a_plate_with_many_holes_has_the_same_bytes_each_time() {
    // Too many corners for one polygon: a constrained Delaunay triangulation, whose order must not affect the result.
    let mut part = trimtess::model::PartBuilder::new("plate");
    let corners = [(0.0, 0.0), (120.0, 0.0), (120.0, 120.0), (0.0, 120.0)];
    let mut loops = vec![Loop::Edges(part.polygon(&corners.map(|(x, y)| DVec3::new(x, y, 0.0))))];
    for k in 0..144 {
        let centre = DVec3::new(f64::from(k % 12) * 10.0 + 5.0, f64::from(k / 12) * 10.0 + 5.0, 0.0);
        let circle = part.circle(&Frame3 { origin: centre, ..Frame3::WORLD }, 3.0);
        loops.push(Loop::Edges(vec![circle.against()]));
    }
    let shell = part.plain_shell(ShellKind::Open);
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, loops, false);
    let part = part.finish().expect("a valid part");
    let first = mesh(placed(part.clone()), 0.05);
    assert!(first.batches.iter().map(|b| b.mesh.triangles.len()).sum::<usize>() > 1000);
    for _ in 0..4 {
        assert_eq!(mesh(placed(part.clone()), 0.05).batches, first.batches);
    }
}
