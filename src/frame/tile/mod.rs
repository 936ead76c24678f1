//! One tile and a plan -> its triangles, and the rung that they needed.

pub(super) mod outcome;
pub(super) mod job;
pub(super) mod record;
