//! Per frame, one tile, one thread, no locks: from rates to triangles.

/// Points and normals of lattices and tessellants.
pub mod evaluate;

mod asked;

mod density;

mod fill;
pub use fill::fill_tile;

mod ladder;
pub use ladder::{Ladder, Rung};

mod lattice;

mod levels;
pub use levels::Levels;

mod lift;

mod limits;
pub use limits::{BYTES_PER_TRIANGLE, PlanLimits, Shortfall};

mod narrow;

mod patch;
pub use patch::{Patch, TileMemory, patch_tile};

mod path;
pub use path::{CameraPath, Picture, UnknownPath};

mod plan;
pub use plan::{EdgePolyline, PartPlan, Plan, TileLattice, cell_coordinate, plan, plan_within};

mod planner;
pub use planner::{PlanChanges, Planner, PlannerOptions};

mod rate;

mod record;
pub use record::{TileRecord, record_tile};

mod refill;

mod resync;

mod samples;

mod shown;

mod split;
pub use split::{Intensive, Lines};

mod tessellants;

mod tile;
pub use tile::{Degradation, Scratch, TileOutcome, edge_line, tessellate_tile};

mod tolerance;
pub use tolerance::Tolerance;

/// Trim triangulation of one tile in cell units.
pub mod trim;

mod unfold;

mod view;
pub use view::{Projection, View, plan_for_view, plan_for_view_within};

mod web;
