//! Plans for moving cameras: culling, levels of detail, hysteresis, budgets.

pub(super) mod attributes;
pub(super) mod culling;
pub(super) mod placed;
pub(super) mod rate;
pub(super) mod pages;
pub(super) mod draft;
pub(super) mod rates;
pub(super) mod limited;
pub(super) mod undo;
pub(super) mod first;
pub(super) mod defer;
pub(super) mod planner;
pub(super) mod levels;
