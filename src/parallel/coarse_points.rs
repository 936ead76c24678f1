//! Prepared model -> points all over it, to fit cameras to.

use super::error::FrameError;
use super::once::tessellate_on;
use crate::control::{Control, Jobs};
use crate::frame::{self, PlanLimits, Tolerance};
use crate::mesh::PackedFrame;
use crate::prepare::Prepared;
use crate::view::View;
use glam::DVec3;
use std::sync::Arc;

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
