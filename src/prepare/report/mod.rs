//! Findings about faces, and the reasons why a face cannot be used.

pub(super) mod room;
pub(super) mod finding;
pub(super) mod refusals;
pub(super) mod guard;
