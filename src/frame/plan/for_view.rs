//! One camera -> a plan that keeps its deviations in pixels.

use super::limits::PlanLimits;
use super::make::plan_parts;
use super::planned::Plan;
use crate::frame::view::asked::Asked;
use crate::frame::view::camera::View;
use crate::frame::view::sight::Sight;
use crate::frame::view::tolerance::Tolerance;
use crate::mesh::ScenePart;
use crate::prepare::Prepared;

/// Rates for one camera, within [`PlanLimits::DEFAULT`].
///
/// Every sub-box of a tile, and every strip of an edge, has a tolerance of its own: the deviation asked for over the most
/// pixels that a millimetre covers anywhere in its box, for the instance that shows the most. Cells and segments that lie in
/// several boxes keep the strictest of these. So wherever a point of the surface is in the picture, the triangles are within
/// `deviation_px` of it there; an edge's rate depends on the edge's own boxes and on the lattices beside it, and is the same for all its
/// faces. What is beside the picture is planned as if it were so much deeper that it is in it, for shadows and for the next frame; what is nearer
/// than the near plane or behind the camera, and parts that are not placed, as coarse as angles allow.
///
/// A camera inside the model costs no more than outside: what is nearer than 5 % of half its box's diagonal is planned as if
/// it were that far away. Boxes are a quarter of a Bézier piece wide at most, where it bends, so that such places are about to
/// leave the picture.
///
/// A view whose numbers are no camera's (not finite, no direction, no size) gives as coarse a plan, which says so in
/// [`Plan::shortfall`].
///
/// Cost: as [`plan`](crate::frame::plan()), and about 20 ns for each box of each instance.
#[must_use]
pub fn plan_for_view(prepared: &Prepared, view: &View) -> Plan {
    plan_for_view_within(prepared, view, &PlanLimits::DEFAULT)
}

/// The same within limits of the caller's.
#[must_use]
pub fn plan_for_view_within(prepared: &Prepared, view: &View, limits: &PlanLimits) -> Plan {
    let lens = view.lens();
    let mut seen: Vec<Vec<Sight>> = vec![Vec::new(); prepared.parts.len()];
    for instance in &prepared.scene.instances {
        seen[instance.part.index()].extend(lens.map(|lens| view.sight(lens, instance)));
    }
    let per_pixel = Tolerance { chord: view.deviation_px, angle: view.angle, max_edge: view.size_px };
    let unseen = Tolerance { chord: f64::INFINITY, angle: view.angle, max_edge: None };
    let of_part = |(part, sights): (&ScenePart, Vec<Sight>)| match sights[..] {
        [] => Asked::everywhere(&unseen, part.radius),
        _ => Asked::seen(&per_pixel, sights, part.radius),
    };
    let mut asked: Vec<Asked> = prepared.scene.parts.iter().zip(seen).map(of_part).collect();
    asked.iter_mut().for_each(|asked| asked.unusable |= lens.is_none());
    plan_parts(prepared, &asked, limits)
}
