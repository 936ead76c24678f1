//! Per frame, one tile, one thread, no locks: from rates to triangles.

/// Points and normals of lattices and tessellants.
pub mod evaluate;

mod lattice;

mod plan;
pub use plan::{EdgePolyline, PartPlan, Plan, TileLattice, Tolerance, cell_coordinate, plan, plan_part};

mod tile;
pub use tile::{Degradation, Scratch, TileOutcome, edge_line, tessellate_tile};

/// Trim triangulation of one tile in cell units.
pub mod trim;

mod view;
pub use view::{View, plan_for_view};
