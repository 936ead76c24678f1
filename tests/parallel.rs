//! Contract: the same bytes for any number of workers, with threads or without, in every frame of a session.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::prepared;
use glam::DVec3;
use std::sync::Arc;
use trimtess::control::{Control, Threads};
use trimtess::frame::{self, Plan, Tolerance};
use trimtess::mesh::{MemorySink, check_scene};
use trimtess::model::{Frame3, Loop, Model, PartBuilder, ShellKind, Surface};
use trimtess::parallel::{FrameReport, Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, Prepared, prepare_on};

/// All bits of a frame except which worker made it.
fn bytes(sink: &MemorySink) -> Vec<u8> {
    let mut bytes = Vec::new();
    let put = |bytes: &mut Vec<u8>, numbers: &[u32]| numbers.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
    let put_f64 = |bytes: &mut Vec<u8>, numbers: &[f64]| numbers.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
    for batch in &sink.batches {
        let mesh = &batch.mesh;
        put(&mut bytes, &[batch.part.0, batch.face.0, batch.tile.0, u32::try_from(mesh.positions.len()).unwrap()]);
        mesh.positions.iter().for_each(|p| put_f64(&mut bytes, &p.to_array()));
        mesh.normals.iter().for_each(|n| put(&mut bytes, &n.to_array().map(f32::to_bits)));
        mesh.uvs.iter().for_each(|uv| put(&mut bytes, &uv.to_array().map(f32::to_bits)));
        mesh.origins.iter().for_each(|origin| bytes.extend(format!("{origin:?}").bytes()));
        mesh.triangles.iter().for_each(|triangle| put(&mut bytes, triangle));
    }
    for line in &sink.edge_lines {
        put(&mut bytes, &[line.part.0, line.edge.0]);
        line.points.iter().for_each(|p| put_f64(&mut bytes, &p.to_array()));
    }
    bytes
}

/// A plate with too many corners for one polygon: a constrained Delaunay triangulation, whose order must not matter.
fn plate() -> Model {
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
    part.finish().unwrap().into()
}

fn models() -> Vec<(String, Model)> {
    let mut models: Vec<_> =
        trimtess_models::names().map(|name| (name.to_owned(), trimtess_models::by_name(name).unwrap())).collect();
    #[cfg(feature = "step")]
    for name in ["red_cube_blue_cylinder", "nist_ctc05"] {
        use trimtess::import::step;
        let path = format!("{}/tests/data/{name}.step", env!("CARGO_MANIFEST_DIR"));
        models.push((name.into(), step::read(&std::fs::read(path).unwrap(), &step::StepOptions::default()).unwrap()));
    }
    models.push(("plate".into(), plate()));
    models.retain(|(_, model)| !model.instances.is_empty());
    assert!(!models.is_empty());
    models
}

/// Three plans: fine, coarse, fine again. A worker's scratch must carry nothing from one to the next.
fn plans(prepared: &Prepared) -> [Arc<Plan>; 3] {
    [1e-3, 1e-2, 1e-3].map(|relative| {
        let tolerance = Tolerance { chord: relative * prepared.diagonal, angle: 0.35, max_edge: None };
        Arc::new(frame::plan(prepared, &tolerance))
    })
}

#[test]
fn the_number_of_workers_does_not_matter() {
    for (name, model) in models() {
        let prepared = prepared(model);
        let plans = plans(&prepared);
        let reference = plans.each_ref().map(|plan| {
            let (sink, report) = common::frame(&prepared, plan, true);
            (report, bytes(&sink))
        });
        assert!(reference[0].0.triangles > 0, "{name} has no triangles");
        assert!(reference[0].1 == reference[2].1, "{name}: the same plan gave different bytes");
        for workers in [1, 2, 3, 8] {
            let mut session =
                Session::start(Arc::clone(&prepared), &SessionOptions::DEFAULT.with_workers(workers)).unwrap();
            assert_eq!(session.workers(), workers);
            for (number, (plan, (expected, expected_bytes))) in plans.iter().zip(&reference).enumerate() {
                let mut sink = MemorySink::default();
                let report = session.frame(Arc::clone(plan), &mut sink).unwrap();
                assert!(bytes(&sink) == *expected_bytes, "{name}, {workers} workers, frame {number}: different bytes");
                let said = |r: &FrameReport| (r.batches, r.triangles, r.degraded.clone());
                assert_eq!(said(&report), said(expected), "{name}, {workers} workers, frame {number}");
                assert_eq!(report.frame, number as u64);
                let tiles: usize = report.workers.iter().map(|w| w.tiles as usize).sum();
                assert_eq!(tiles, prepared.tiles().count(), "{name}: every tile is made once");
            }
        }
    }
}

#[test]
fn the_threads_of_prepare_do_not_matter() {
    for (name, model) in models() {
        let frames = [1, 2, 3].map(|threads| {
            let threads = Threads::start(threads).expect("threads");
            let made = prepare_on(&threads, &model, &PrepareOptions::DEFAULT, &Control::default());
            let prepared = Arc::new(made.expect("within the limits"));
            bytes(&common::frame(&prepared, &plans(&prepared)[0], true).0)
        });
        assert!(frames[0] == frames[1] && frames[1] == frames[2], "{name}");
    }
}

#[test]
fn edge_lines_come_on_request_and_lie_on_mesh_vertices() {
    for (name, model) in models() {
        let prepared = prepared(model);
        let plan = &plans(&prepared)[1];
        let [with, without] = [true, false].map(|lines| common::frame(&prepared, plan, lines).0);
        assert_eq!(with.edge_lines.len(), prepared.brep_edges().count(), "{name}");
        assert!(without.edge_lines.is_empty() && without.batches == with.batches, "{name}");
        let vertices: std::collections::HashSet<_> = with
            .batches
            .iter()
            .flat_map(|b| b.mesh.positions.iter().map(move |p| (b.part, p.to_array().map(f64::to_bits))))
            .collect();
        for line in &with.edge_lines {
            assert!(line.points.len() >= 2, "{name}: {line:?}");
            for point in &line.points {
                assert!(vertices.contains(&(line.part, point.to_array().map(f64::to_bits))), "{name}: {line:?}");
            }
        }
        assert!(check_scene(&with).total.is_well_formed(), "{name}");
    }
}
