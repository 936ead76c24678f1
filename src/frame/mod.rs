//! A tolerance or a camera -> triangles, tile by tile: each tile is the work of one thread, without locks.
//!
//! Modules are in processing order, and a module may `use` only those above it (`tests/layers.rs`). The last two,
//! `live` and `update`, serve moving cameras; meshing for a tolerance uses neither.

mod view;
pub use view::camera::{Projection, View};
pub use view::path::{CameraPath, Picture, UnknownPath};
pub use view::tolerance::Tolerance;

mod plan;
pub use plan::for_view::{plan_for_view, plan_for_view_within};
pub use plan::limits::{BYTES_PER_TRIANGLE, PlanLimits, Shortfall};
pub use plan::make::{plan, plan_within};
pub use plan::planned::{EdgePolyline, PartPlan, Plan, TileLattice, cell_coordinate};
pub use plan::split::{Intensive, Lines};

/// Trim triangulation of one tile in cell units.
pub mod trim;

mod vertices;
pub use vertices::boundary::edge_line;
pub use vertices::evaluate;
pub use vertices::scratch::Scratch;

mod refine;

mod tile;
pub use tile::fill::fill_tile;
pub use tile::job::tessellate_tile;
pub use tile::ladder::{Ladder, Rung};
pub use tile::outcome::{Degradation, TileOutcome};
pub use tile::record::{TileRecord, record_tile};

mod live;
pub use live::levels::Levels;
pub use live::planner::{PlanChanges, Planner, PlannerOptions};

mod update;
pub use update::tile::{Reuse, TileCache, UpdateScratch, update_tile};
