//! Findings about faces, and the reasons why a face cannot be used.

pub(super) mod finding;
pub(super) mod guard;
pub(super) mod refusals;
pub(super) mod room;
