//! Meshes measured against the exact geometry, independently of the bounds that made them.
//!
//! [`check_scene`](crate::mesh::check_scene) judges topology by exact bits; this judges geometry by dense sampling.

mod foot;

mod tally;
pub use tally::Spread;

mod report;
pub use report::{DeviationReport, EdgePlace, Place};

mod edges;

mod deviation;
pub use deviation::deviation;

mod economy;
pub use economy::{EconomyReport, TileEconomy, economy};
