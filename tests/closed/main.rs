//! Closed stays closed: the edges of any prepared input sum to what its shells say.

#[path = "../chains/mod.rs"]
mod chains;
#[path = "../common/mod.rs"]
mod common;
#[cfg(feature = "step")]
mod corpus;
mod models;
#[cfg(feature = "step")]
#[path = "../parts/mod.rs"]
mod parts;
#[cfg(feature = "step")]
#[path = "../mutants/points.rs"]
mod points;
#[cfg(feature = "step")]
#[path = "../sequence/random.rs"]
mod random;
