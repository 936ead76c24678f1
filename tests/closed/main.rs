//! Closed stays closed: the edges of any prepared input sum to what its shells say.

#[path = "../chains/mod.rs"]
mod chains;
#[cfg(feature = "step")]
mod corpus;
mod models;
