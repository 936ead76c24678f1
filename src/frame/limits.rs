//! What a plan may cost in all, and what it says when that is less than the tolerance asks for.

use crate::mesh::TileId;
use crate::model::PartId;
use std::fmt;

/// Most that a plan may hold. A cell becomes up to two triangles, each of about 50 bytes in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanLimits {
    /// Cells of one tile's lattice.
    pub cells_per_tile: u64,
    /// Cells of all lattices, kept or trimmed away, and tessellants of all edges together; each part counts once.
    pub cells: u64,
}

impl PlanLimits {
    /// 4 million per tile, 32 million in all: a mesh of at most about 3 GB.
    pub const DEFAULT: Self = Self { cells_per_tile: 1 << 22, cells: 1 << 25 };
}

impl Default for PlanLimits {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// In what a plan is coarser than its tolerance asks.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortfall {
    /// Lines and tessellants per parameter as a share of what is asked: 1 unless [`PlanLimits::cells`] does not allow it.
    pub density: f64,
    /// Whether the tolerance had to be replaced by one that can be used.
    pub unusable: bool,
    /// Tiles limited by [`PlanLimits::cells_per_tile`] or the limit on lines; ascending.
    pub tiles: Vec<(PartId, TileId)>,
    /// Edges limited in their tessellants, as indices into [`PreparedPart::edges`](crate::prepare::PreparedPart::edges);
    /// ascending.
    pub edges: Vec<(PartId, u32)>,
}

impl Shortfall {
    /// Nothing is missing.
    pub(super) const NONE: Self = Self { density: 1.0, unusable: false, tiles: Vec::new(), edges: Vec::new() };

    pub(super) fn if_any(self) -> Option<Self> {
        (self != Self::NONE).then_some(self)
    }
}

impl fmt::Display for Shortfall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { density, unusable, tiles, edges } = self;
        write!(f, "the mesh is coarser than asked:")?;
        if *unusable {
            write!(f, " the tolerance is not a usable number, or too small for the model;")?;
        }
        if *density < 1.0 {
            write!(f, " all lattices have {density:.1e} times the lines, or there would be too many;")?;
        }
        write!(f, " {} tiles and {} edges reach the limit of lines", tiles.len(), edges.len())
    }
}

/// What is left of the limits.
pub(super) struct Budget {
    /// Of [`PlanLimits::cells`].
    pub(super) left: u64,
    pub(super) cells_per_tile: u64,
}

impl Budget {
    pub(super) fn of(limits: &PlanLimits) -> Self {
        Self { left: limits.cells, cells_per_tile: limits.cells_per_tile.max(1) }
    }

    /// `None` when there is not as much.
    pub(super) fn spend(&mut self, cells: u64) -> Option<()> {
        self.left = self.left.checked_sub(cells)?;
        Some(())
    }
}
