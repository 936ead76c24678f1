//! The paper's models -> meshes at three tolerances: no face lost, no cracks, deviation within the tolerance, and the
//! exact volume.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod brake;
mod teapots;
mod volumes;

use glam::{DAffine3, DVec3};
use std::sync::Arc;
use trimtess::audit::{self, DeviationReport};
use trimtess::frame::{self, Tolerance};
use trimtess::mesh::{MemorySink, SceneFacts, check_scene};
use trimtess::model::{Model, Part, Severity};
use trimtess::parallel::serial;
use trimtess::prepare::internals::EdgeShape;
use trimtess::prepare::{PrepareOptions, Prepared, prepare};

/// Prepares the model of that name. Fails on warnings and errors; notes report borders that were sewn.
fn prepared(name: &str) -> Arc<Prepared> {
    of_model(trimtess_models::by_name(name).unwrap())
}

fn of_model(model: Model) -> Arc<Prepared> {
    let name = model.name.clone();
    let prepared = prepare(model, &PrepareOptions::DEFAULT).expect("within the limits");
    let complaints = prepared.diagnostics.iter().any(|d| d.severity > Severity::Note);
    assert!(!complaints, "{name}: {:?}", prepared.diagnostics);
    Arc::new(prepared)
}

/// Prepares a model of one part.
fn alone(part: Part) -> Arc<Prepared> {
    of_model(part.into())
}

/// Meshes with a chord tolerance of `share` of the diagonal; returns the tolerance, the facts and the deviation.
///
/// Asserts that no tile is degraded, every face has triangles, and only edges with a single use are open.
fn meshed(prepared: &Arc<Prepared>, share: f64) -> (f64, SceneFacts, DeviationReport) {
    let chord = share * prepared.diagonal;
    let plan = Arc::new(frame::plan(prepared, &Tolerance { chord, angle: 0.5, max_edge: None }));
    let mut sink = MemorySink::default();
    let report = serial(prepared, &plan, false, &mut sink).unwrap();
    assert!(report.degraded.is_empty(), "at {share}: {:?}", report.degraded);
    let facts = check_scene(&sink);
    assert!(facts.faces_without_triangles.is_empty(), "at {share}: {:?}", facts.faces_without_triangles);
    let edges = || prepared.parts.iter().zip(&plan.parts).flat_map(|(part, plan)| part.edges.iter().zip(&plan.edges));
    let once = edges().filter(|(edge, _)| edge.uses.len() == 1 && matches!(edge.shape, EdgeShape::Curve(_)));
    let open: usize = once.map(|(_, line)| line.ts.len() - 1).sum();
    assert_eq!(facts.total.unbalanced_edges, open as u64, "at {share}: {}", facts.total);
    (chord, facts, audit::deviation(prepared, &sink, chord))
}

/// Number of Bézier patches of all faces. Counts parts, not instances; a plane face has one patch.
fn patches(prepared: &Prepared) -> usize {
    let faces = prepared.parts.iter().flat_map(|part| &part.faces);
    faces.map(|face| (face.patches.breaks_u.len() - 1) * (face.patches.breaks_v.len() - 1)).sum()
}

/// Weights of the tiles of a model placed at a scale.
fn weights(name: &str, scale: f64) -> Vec<f64> {
    let mut model = trimtess_models::by_name(name).unwrap();
    for instance in &mut model.instances {
        instance.transform = DAffine3::from_scale(DVec3::splat(scale)) * instance.transform;
    }
    let prepared = prepare(model, &PrepareOptions::DEFAULT).expect("within the limits");
    prepared.tiles().map(|(_, _, tile)| tile.weight).collect()
}

#[test]
fn weights_do_not_depend_on_the_size() {
    for name in trimtess_models::NAMES {
        let (plain, large) = (weights(name, 1.0), weights(name, 1000.0));
        assert!(plain.iter().all(|weight| *weight > 0.0 && weight.is_finite()), "{name}: {plain:?}");
        assert!(plain.iter().zip(&large).all(|(a, b)| (a / b - 1.0).abs() < 1e-6), "{name}");
    }
}
