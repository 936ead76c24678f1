//! Meshes to their deviation from the exact geometry, measured independently of the bounds that made them.
//!
//! [`check_scene`](crate::mesh::check_scene) checks topology by exact bits; this module checks geometry by dense
//! sampling.

mod foot;

mod report;
pub use report::{DeviationReport, EdgePlace, Place, Spread, mesh_faults};

mod deviation;
pub use deviation::deviation;

mod economy;
pub use economy::{EconomyReport, TileEconomy, economy};
