//! A tolerance or a camera -> triangles, tile by tile: each tile is the work of one thread, without locks.
//!
//! Modules are in processing order, and a module may `use` only those above it (`tests/circles`). The last one, `live`,
//! serves moving cameras; meshing for a tolerance does not use it.

mod tolerance;
pub use tolerance::Tolerance;

mod plan;
pub use plan::damage::DamagedPlan;
pub use plan::limits::{BYTES_PER_TRIANGLE, PlanLimits, Shortfall};
pub use plan::make::{PlanError, plan, plan_for_view, plan_for_view_on, plan_for_view_within, plan_on, plan_within};
pub use plan::output::Plan;

mod trim;

mod vertices;

mod refine;

mod tile;
pub use tile::outcome::{Degradation, Ladder, Rung};

mod live;
pub use live::attributes::Attributes;
pub use live::rates::PlannerOptions;

/// What this project's own program, benches and tests use of the stages. Not part of the stable interface.
#[doc(hidden)]
pub mod internals {
    pub(crate) use super::live::culling::largest_tile;
    pub use super::live::levels::Levels;
    pub(crate) use super::live::levels::add_level;
    pub use super::live::pages::PlanChanges;
    pub(crate) use super::live::placed::InstanceLook;
    pub use super::live::placed::PlacedInstances;
    pub use super::live::planner::Planner;
    pub(crate) use super::plan::make::{completed, plan_of_view};
    pub(crate) use super::plan::output::free;
    pub use super::plan::output::{EdgePolyline, PartPlan, TileLattice, cell_coordinate};
    pub use super::plan::rows::PlanRows;
    pub(crate) use super::plan::targets::PlanModel;
    pub(crate) use super::tile::job::fill_tile;
    pub use super::tile::job::tessellate_tile;
    pub use super::tile::outcome::TileOutcome;
    pub use super::tile::record::{TileRecord, record_tile};
    pub use super::vertices::{Scratch, edge_line, evaluate, lattice};

    /// Trim triangulation of one tile in cell units.
    pub mod trim {
        pub use crate::frame::trim::climb::{TrimScratch, trim_tile};
        pub use crate::frame::trim::input::{TrimInput, TrimInputError};
        pub use crate::frame::trim::output::{TrimOutcome, TrimOutput, TrimStats};
        pub use crate::frame::trim::record::{TracedCrossing, TrimRecord};
        pub use crate::frame::trim::reference;
    }
}
