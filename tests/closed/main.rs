//! Closed stays closed: what prepare makes of any input sums to what its shells say.

#[path = "../chains/mod.rs"]
mod chains;
#[cfg(feature = "step")]
mod corpus;
mod models;
