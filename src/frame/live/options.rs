//! What a planner may do: limits, a budget of time, culling.

use crate::frame::plan::limits::PlanLimits;
use std::time::Duration;

/// Options of the plans for frames of views.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PlannerOptions {
    /// Limits on the size of a plan.
    pub limits: PlanLimits,
    /// Budget for the tiles of a frame, as predicted time of a single worker. Changes beyond it wait for the next
    /// frame. New tiles are always built, at a coarse level if the budget is spent. `None` disables it.
    pub budget: Option<Duration>,
    /// Cull back-facing tiles of closed parts.
    /// Only valid while no camera is inside a part and the near plane clips none.
    pub cull_back_faces: bool,
}

impl PlannerOptions {
    /// Default limits, no budget, no back-face culling.
    pub const DEFAULT: Self = Self { limits: PlanLimits::DEFAULT, budget: None, cull_back_faces: false };
}

options! {
    PlannerOptions:
    with_limits(limits: PlanLimits);
    with_budget(budget: Option<Duration>);
    with_cull_back_faces(cull_back_faces: bool);
}
