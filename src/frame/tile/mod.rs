//! One tile and a plan -> triangles, and how they came about.

pub(super) mod fill;
pub(super) mod job;
pub(super) mod ladder;
pub(super) mod outcome;
pub(super) mod record;
