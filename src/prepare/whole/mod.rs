//! Prepared parts -> the whole model: its box, its scene, and what its tiles cost.

pub(super) mod extent;
pub(super) mod weight;

pub(super) mod prepare;
