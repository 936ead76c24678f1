//! Plans for moving cameras: culling, levels of detail, hysteresis, budgets.

pub(super) mod culling;
pub(super) mod levels;
pub(super) mod planner;
pub(super) mod rate;
pub(super) mod resync;
pub(super) mod split;
