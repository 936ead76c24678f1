//! Limits -> what remains of them while a plan is made; a tile and its plan -> its predicted time.

use super::limits::PlanLimits;
use super::output::{PartPlan, TileLattice};
use crate::prepare::internals::{EdgeUse, Tile, nanoseconds};

/// What remains of the limits.
pub(crate) struct Budget {
    /// Cells and tessellants.
    pub(crate) left: u64,
    pub(crate) cells_per_tile: u64,
}

impl Budget {
    /// `held_mib`: memory of the prepared model, MiB.
    pub(crate) fn of(limits: &PlanLimits, held_mib: u32) -> Self {
        Self { left: limits.allowed(held_mib) / 2, cells_per_tile: (limits.triangles_per_tile / 2).max(1) }
    }
}

/// Number of cells of a lattice.
pub(crate) fn cells(lattice: &TileLattice) -> u64 {
    let (nu, nv) = lattice.cells();
    u64::from(nu) * u64::from(nv)
}

/// Predicted time of a tile in nanoseconds, with its number of cells scaled by `growth` and its boundary tessellants by
/// √`growth`.
pub(crate) fn predicted(plan: &PartPlan, tile: &Tile, t: usize, growth: f64) -> f64 {
    let tessellants = |u: &EdgeUse| {
        let breaks = &plan.edges[u.edge.index()].breaks;
        let at = |k: u32| breaks.get(k as usize).copied().unwrap_or(0);
        f64::from(at(u.from).abs_diff(at(u.to)))
    };
    let boundary: f64 = tile.loops.iter().flatten().map(tessellants).sum();
    nanoseconds(growth * cells(&plan.tiles[t]) as f64, growth.sqrt() * boundary)
}
