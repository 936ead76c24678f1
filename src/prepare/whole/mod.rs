//! Prepared parts -> the whole model: its box, its scene and the expected cost of its tiles.

mod extent;
pub(super) mod weight;

pub(super) mod prepare;
