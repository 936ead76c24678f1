//! One mesh of a prepared model: made on the threads that a run has, and checked.

use crate::Failure;
use crate::closedness::Closedness;
use crate::limits::LimitArgs;
use crate::report::Report;
use std::sync::Arc;
use trimtess::audit;
use trimtess::control::{Control, Rayon};
use trimtess::frame;
use trimtess::mesh::{MemorySink, MeshLists, check_scene};
use trimtess::parallel::{self, balance};
use trimtess::prepare::{Prepared, Shells};

/// Makes the mesh of a plan on the program's threads, with these lists, and a report about it. Fails if the limits made
/// the plan coarser without `--coarsen`; with it, the report warns of that.
pub(crate) fn make(
    prepared: &Arc<Prepared>,
    plan: &Arc<frame::Plan>,
    (edge_lines, lists): (bool, MeshLists),
    limits: &LimitArgs,
) -> Result<(MemorySink, Report), Failure> {
    limits.check(plan.shortfall.as_ref())?;
    let mut frame = MemorySink::reading(lists);
    let made = parallel::tessellate_on(&Rayon, prepared, plan, edge_lines, &Control::default(), &mut frame);
    let made = made.map_err(Failure::cannot)?;
    tracing::info!(
        triangles = made.triangles,
        batches = made.batches,
        workers = made.workers.len(),
        balance = balance(&made.workers, made.workers.len()),
        "made in {:?}, committed in {:?}",
        made.made_in,
        made.committed_in
    );
    let mut report = Report::of(&frame, prepared, &made);
    plan.shortfall.iter().for_each(|shortfall| report.add_warning(shortfall.to_string()));
    limits.warn_if_over(made.triangles, &mut report);
    Ok((frame, report))
}

/// Runs `check_scene` and the audit on the program's threads, and adds their results and errors to the report.
pub(crate) fn check_mesh(prepared: &Prepared, shells: &[Shells], frame: &MemorySink, chord: f64, report: &mut Report) {
    // The audit alone takes one core for seconds.
    let (facts, (deviation, economy)) = rayon::join(
        || check_scene(frame),
        || rayon::join(|| audit::deviation(prepared, frame, chord), || audit::economy(prepared, frame, chord)),
    );
    report.open_edges = Some(facts.total.open_edges);
    report.unbalanced_edges = Some(facts.total.unbalanced_edges);
    tracing::info!("{}", facts.total);
    report.defects = Some(facts.total.defects);
    let parts = frame.scene.parts.iter().zip(&facts.parts);
    let closedness = (0..).zip(parts).map(|(k, (part, mesh))| Closedness::of(k, part, mesh));
    report.closedness = Some(closedness.collect());
    audit::mesh_faults(&frame.scene, &facts, shells).into_iter().for_each(|fault| report.add_error(fault));
    deviation.faults().for_each(|fault| report.add_error(fault));
    tracing::info!("{deviation}");
    tracing::info!("{economy}");
    report.book(deviation, economy);
}

/// A model, prepared and meshed, for tests.
#[cfg(test)]
pub(crate) fn meshed(model: trimtess::model::Model, chord: f64) -> (Arc<Prepared>, MemorySink, parallel::FrameReport) {
    let options = trimtess::prepare::PrepareOptions::DEFAULT;
    let prepared = Arc::new(trimtess::prepare::prepare(model, &options).expect("within the limits"));
    let plan = Arc::new(frame::plan(&prepared, &frame::Tolerance { chord, angle: 0.5, max_edge: None }));
    let mut frame = MemorySink::default();
    let made = parallel::serial(&prepared, &plan, true, &mut frame).expect("a frame");
    (prepared, frame, made)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trimtess::model::shapes;

    /// Errors that `check` reports for a shape after `tamper` changed its mesh or shells.
    fn errors(name: &str, chord: f64, tamper: impl Fn(&mut MemorySink, &mut Vec<Shells>)) -> Vec<String> {
        let model = shapes::by_name(name).unwrap_or_default();
        let mut shells: Vec<Shells> = model.parts.iter().map(Shells::of).collect();
        let (prepared, mut frame, _) = meshed(model, 0.05);
        tamper(&mut frame, &mut shells);
        let mut report = Report::default();
        check_mesh(&prepared, &shells, &frame, chord, &mut report);
        report.diagnostics.into_iter().map(|entry| entry.reason).collect()
    }

    #[test]
    fn a_sound_mesh_passes() {
        for name in ["box", "cylinder", "sphere", "square", "wave"] {
            assert_eq!(errors(name, 0.05, |_, _| ()), [""; 0], "{name}");
        }
    }

    #[test]
    fn cracks_inversion_and_deviation_are_errors() {
        let crack = errors("cylinder", 0.05, |frame, _| drop(frame.batches.pop()));
        assert!(crack.len() == 1 && crack[0].contains("unbalanced"), "{crack:?}");
        let turn = |frame: &mut MemorySink| {
            let triangles = frame.batches.iter_mut().flat_map(|batch| &mut batch.mesh.triangles);
            triangles.for_each(|corners| corners.swap(0, 1));
        };
        let turned = errors("cylinder", 0.05, |frame, _| turn(frame));
        assert!(turned.len() == 1 && turned[0].contains("inside out"), "{turned:?}");
        let coarse = errors("cylinder", 0.001, |_, _| ());
        assert!(coarse.len() == 2 && coarse[1].contains("edges"), "{coarse:?}");
        // Voids have negative volume.
        let void = errors("cylinder", 0.05, |frame, shells| {
            turn(frame);
            shells[0].voids = 1;
        });
        assert_eq!(void, [""; 0]);
    }
}
