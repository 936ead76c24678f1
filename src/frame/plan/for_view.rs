//! One camera -> a plan that meets its screen-space error.

use super::limits::PlanLimits;
use super::make::{PlanError, plan_parts};
use super::output::Plan;
use crate::control::{Call, Control, Jobs, Rayon};
use crate::frame::tolerance::box_tolerance::PartTolerance;
use crate::frame::tolerance::object_tolerance::Tolerance;
use crate::frame::tolerance::part_camera::PartCamera;
use crate::math::buckets::Buckets;
use crate::mesh::{Scene, ScenePart};
use crate::prepare::Prepared;
use crate::view::View;
use std::sync::Arc;

/// Plans lattice lines and tessellants for one camera, within [`PlanLimits::DEFAULT`].
///
/// Every sub-box of a tile and every strip of an edge has its own tolerance: `deviation_px` over the most pixels that a
/// millimetre covers anywhere in the box, for the instance where that is largest. Cells and segments that lie in
/// several boxes meet the strictest of their tolerances. Wherever a point of the surface is in the image, the triangles
/// are therefore within `deviation_px` of it. The density of an edge depends on its own boxes and on the lattices next
/// to it, and is the same for all its faces.
///
/// Off-screen surface is planned at the depth where the frustum is wide enough to contain it, for shadows and for the
/// next frame. Surface that is nearer than the near plane or behind the camera, and parts without instances, are as
/// coarse as the angle allows.
///
/// A camera inside the model costs no more than one outside: a box nearer than 5 % of half its diagonal is planned at
/// that distance. Where a surface bends, boxes are usually a quarter of a Bézier piece wide, so that such a box is
/// about to leave the image.
///
/// An invalid view (not finite, no direction, no size) gives the coarsest plan, and [`Plan::shortfall`] reports it.
///
/// Cost: that of [`plan`](crate::frame::plan()), plus about 20 ns for each box of each instance.
/// Runs on [`Rayon`]'s threads.
#[must_use]
pub fn plan_for_view(prepared: &Prepared, view: &View) -> Plan {
    plan_for_view_within(prepared, view, &PlanLimits::DEFAULT)
}

/// As [`plan_for_view`], within the limits of the caller.
#[must_use]
pub fn plan_for_view_within(prepared: &Prepared, view: &View, limits: &PlanLimits) -> Plan {
    plan_for_view_on(&Rayon, prepared, view, limits, &Control::default()).unwrap_or_default()
}

/// As [`plan_for_view_within`], on the threads of `jobs`, with cancellation, as [`plan_on`](crate::frame::plan_on).
///
/// # Errors
/// When cancelled.
pub fn plan_for_view_on(
    jobs: &dyn Jobs,
    prepared: &Prepared,
    view: &View,
    limits: &PlanLimits,
    control: &Control,
) -> Result<Plan, PlanError> {
    let (lens, Scene { parts, instances, .. }) = (view.lens(), &prepared.scene);
    let rows = instances.iter().enumerate().map(|(row, instance)| (instance.part.0, row as u32));
    let of_parts = Buckets::of(parts.len(), rows);
    let sights = |lens| of_parts.all().iter().map(|&row| view.sight(lens, &instances[row as usize])).collect();
    let cameras: Arc<[PartCamera]> = lens.map(sights).unwrap_or_default();
    let per_pixel = Tolerance { chord: view.deviation_px, angle: view.angle, max_edge: view.size_px };
    let unseen = Tolerance { chord: f64::INFINITY, angle: view.angle, max_edge: None };
    let of_part = |(row, part): (usize, &ScenePart)| match of_parts.range(row as u32) {
        seen if cameras.is_empty() || seen.is_empty() => PartTolerance::everywhere(&unseen, part.radius),
        seen => PartTolerance::seen(&per_pixel, (Arc::clone(&cameras), seen), (part.centre, part.radius)),
    };
    let mut asked: Vec<PartTolerance> = parts.iter().enumerate().map(of_part).collect();
    asked.iter_mut().for_each(|asked| asked.unusable |= lens.is_none());
    plan_parts(Call::new(jobs, control), prepared.parts.clone(), asked, limits, 0).ok_or(PlanError::Cancelled)
}
