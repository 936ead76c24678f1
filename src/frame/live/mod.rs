//! Moving cameras: rates that stay, levels of detail, what is drawn, budgets.

pub(super) mod levels;
pub(super) mod planner;
pub(super) mod rate;
pub(super) mod resync;
pub(super) mod shown;
