//! What there is to tell of a face, and why one cannot be used.

pub(super) mod guard;
pub(super) mod refusals;
pub(super) mod told;
