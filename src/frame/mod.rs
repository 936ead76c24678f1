//! Per frame, one tile, one thread, no locks: from rates to triangles.

mod plan;
pub use plan::{EdgePolyline, PartPlan, Plan, TileLattice, Tolerance, plan};

mod tile;
pub use tile::{Degradation, Scratch, TileOutcome, edge_line, tessellate_tile};
