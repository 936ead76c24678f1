//! Model -> prepare -> plan -> tiles: closed solids give closed meshes at every tolerance.

mod common;

use common::prepared_clean;
use glam::DVec3;
use std::sync::Arc;
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::{MemorySink, check_scene};
use trimtess::model::{EdgeId, Frame3, Loop, Part, PartBuilder, ShellKind, Surface, shapes};
use trimtess::parallel::{Session, SessionOptions};

/// The cylinder, with or without a seam edge on its side.
fn cylinder(seam: bool) -> Part {
    let mut part = shapes::cylinder();
    if !seam {
        let circles = [EdgeId(0).along(), EdgeId(1).against()];
        part.faces[0].loops = circles.map(|circle| Loop::Edges(vec![circle])).into();
    }
    part
}

fn mesh(part: Part, chord: f64) -> MemorySink {
    let prepared = prepared_clean(part);
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
            let sink = mesh(cylinder(seam), chord);
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
    let mut part = PartBuilder::new("plate");
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
    let first = mesh(part.clone(), 0.05);
    assert!(first.batches.iter().map(|b| b.mesh.triangles.len()).sum::<usize>() > 1000);
    for _ in 0..4 {
        assert_eq!(mesh(part.clone(), 0.05).batches, first.batches);
    }
}
