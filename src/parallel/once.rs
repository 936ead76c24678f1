//! Prepared model and a plan -> one frame, without a session; points all over the model.

use super::commit::{FrameReport, Rows};
use super::engine::whole_frame;
use super::error::FrameError;
use super::owners::{hands, workers_on};
use super::worker::Crew;
use crate::control::{Alone, Control, Jobs, width};
use crate::frame::{self, Plan, PlanLimits, Tolerance};
use crate::mesh::{MeshSink, PackedFrame};
use crate::prepare::Prepared;
use crate::view::View;
use glam::DVec3;
use std::sync::Arc;

/// Makes the same frame as [`Session::frame`](super::Session::frame) on the caller's thread alone.
///
/// # Errors
/// When the plan is not of this model. When the sink refuses; its `abort` was called.
pub fn serial(
    prepared: &Arc<Prepared>,
    plan: &Arc<Plan>,
    edge_lines: bool,
    sink: &mut dyn MeshSink,
) -> Result<FrameReport, FrameError> {
    tessellate_on(&Alone, prepared, plan, edge_lines, &Control::default(), sink)
}

/// Tessellates the whole model by `plan`, once, on the threads of `jobs`. The sink gets the same calls for any number
/// of threads.
///
/// # Errors
/// When the plan is not of this model; the sink was not touched. When the sink refuses; its `abort` was called. When
/// cancelled: the sink was not touched, or its `abort` was called.
pub fn tessellate_on(
    jobs: &dyn Jobs,
    prepared: &Arc<Prepared>,
    plan: &Arc<Plan>,
    edge_lines: bool,
    control: &Control,
    sink: &mut dyn MeshSink,
) -> Result<FrameReport, FrameError> {
    plan.check(&prepared.parts)?;
    let threads = width(jobs);
    let mut crew = Crew::of(prepared, hands(prepared, (workers_on(threads), threads), edge_lines));
    let with = (&mut crew, &mut Rows::default());
    whole_frame(with, (jobs, prepared, None), plan, (&prepared.scene, control), sink)
}

/// Chord tolerance, as a fraction of the diagonal.
const CHORD_REL: f64 = 1e-2;

/// The vertices of a coarse mesh of the placed model, millimetres. A camera that is fitted to them sees all of the
/// model up to a hundredth of its size.
///
/// # Errors
/// When cancelled.
pub fn coarse_points(
    jobs: &dyn Jobs,
    prepared: &Arc<Prepared>,
    limits: &PlanLimits,
    control: &Control,
) -> Result<Vec<DVec3>, FrameError> {
    let tolerance = Tolerance { chord: CHORD_REL * prepared.diagonal, angle: View::ANGLE, max_edge: None };
    let plan = Arc::new(frame::plan_on(jobs, prepared, &tolerance, limits, control)?);
    let mut coarse = PackedFrame::default();
    tessellate_on(jobs, prepared, &plan, false, control, &mut coarse)?;
    let mut points = Vec::new();
    for instance in &coarse.scene.instances {
        let of_part = coarse.parts.get(instance.part.index()).into_iter().flat_map(|part| &part.positions);
        points.extend(of_part.map(|&point| instance.transform.transform_point3(point)));
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::assert_each_cancels;
    use crate::frame::{DamagedPlan, Tolerance, plan};
    use crate::mesh::{MemorySink, MeshLists};
    use crate::model::shapes;
    use crate::prepare::{PrepareOptions, prepare};

    #[test]
    fn plans_of_other_models_are_refused() {
        let of = |model| Arc::new(prepare(model, &PrepareOptions::DEFAULT).expect("within the limits"));
        let (all, one) = (of(shapes::all()), of(shapes::by_name("cylinder").expect("a shape")));
        let tolerance = Tolerance { chord: 0.01, angle: 0.5, max_edge: None };
        for (prepared, planned) in [(&all, &one), (&one, &all)] {
            let mut sink = MemorySink::default();
            let frame = serial(prepared, &Arc::new(plan(planned, &tolerance)), false, &mut sink);
            assert!(matches!(frame, Err(FrameError::Plan(DamagedPlan::Rows { .. }))), "{frame:?}");
            assert!(sink.batches.is_empty());
        }
    }

    #[test]
    fn lists_that_a_sink_does_not_read_are_not_made() {
        let prepared = prepare(shapes::all(), &PrepareOptions::DEFAULT).expect("within the limits");
        let tolerance = Tolerance { chord: 0.01, angle: 0.5, max_edge: None };
        let (plan, prepared) = (Arc::new(plan(&prepared, &tolerance)), Arc::new(prepared));
        let [all, none] = [MeshLists::ALL, MeshLists::NONE].map(|lists| {
            let mut sink = MemorySink::reading(lists);
            serial(&prepared, &plan, true, &mut sink).expect("a frame");
            sink
        });
        assert_eq!((all.batches.len(), &all.edge_lines), (none.batches.len(), &none.edge_lines));
        for (all, none) in all.batches.iter().zip(&none.batches) {
            let (all, none) = (&all.mesh, &none.mesh);
            assert_eq!((&all.positions, &all.normals), (&none.positions, &none.normals));
            assert_eq!(all.triangles, none.triangles);
            assert_eq!([all.uvs.len(), all.origins.len()], [all.positions.len(); 2]);
            assert_eq!([none.uvs.len(), none.origins.len(), none.lines[0].len()], [0; 3]);
        }
    }

    #[test]
    fn frames_are_cancelled_wherever_they_look() {
        let prepared = prepare(shapes::all(), &PrepareOptions::DEFAULT).expect("within the limits");
        let tolerance = Tolerance { chord: 0.01, angle: 0.5, max_edge: None };
        let plan = Arc::new(plan(&prepared, &tolerance));
        let prepared = Arc::new(prepared);
        assert_each_cancels("shapes", 1000, |control| {
            let mut sink = MemorySink::default();
            let frame = tessellate_on(&Alone, &prepared, &plan, true, control, &mut sink);
            let cancelled = matches!(frame, Err(FrameError::Cancelled));
            // An aborted sink is empty.
            assert_eq!(sink.batches.is_empty() && sink.scene.parts.is_empty(), cancelled);
            cancelled
        });
    }
}
