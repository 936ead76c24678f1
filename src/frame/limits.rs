//! What a plan may cost in all, and what it says when that is less than the tolerance asks for.

use crate::mesh::TileId;
use crate::model::PartId;
use std::fmt;

/// Memory of one triangle on its way to a file: its corners' numbers, its share of the vertices with their normals, and the
/// same again as the file's bytes.
pub const BYTES_PER_TRIANGLE: u64 = 128;

/// Most that a plan may hold. Triangles are counted as two per cell of a lattice, kept or trimmed away, and two per tessellant;
/// each part counts once, however often it is placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanLimits {
    /// Triangles of one tile.
    pub triangles_per_tile: u64,
    /// Triangles of all tiles together.
    pub triangles: u64,
    /// Memory of the whole mesh, bytes, at [`BYTES_PER_TRIANGLE`].
    pub bytes: u64,
}

impl PlanLimits {
    /// 8 million triangles per tile, 64 million in all, 16 GiB.
    pub const DEFAULT: Self = Self { triangles_per_tile: 1 << 23, triangles: 1 << 26, bytes: 16 << 30 };

    /// Triangles that both limits on the whole allow.
    fn allowed(&self) -> u64 {
        self.triangles.min(self.bytes / BYTES_PER_TRIANGLE)
    }
}

impl Default for PlanLimits {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// In what a plan is coarser than its tolerance asks, and because of which limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortfall {
    /// The limits of the plan.
    pub limits: PlanLimits,
    /// Lines and tessellants per parameter as a share of what is asked: 1 unless [`PlanLimits::triangles`] or
    /// [`PlanLimits::bytes`] does not allow it.
    pub density: f64,
    /// Triangles that the lattices would have at the density that is asked; 0 where that is allowed.
    pub needed: u64,
    /// Whether the tolerance had to be replaced by one that can be used.
    pub unusable: bool,
    /// Tiles limited by [`PlanLimits::triangles_per_tile`] or the limit on lines; ascending.
    pub tiles: Vec<(PartId, TileId)>,
    /// Edges limited in their tessellants, as indices into [`PreparedPart::edges`](crate::prepare::PreparedPart::edges);
    /// ascending.
    pub edges: Vec<(PartId, u32)>,
}

impl Shortfall {
    /// Nothing is missing.
    pub(super) fn none(limits: &PlanLimits) -> Self {
        Self { limits: *limits, density: 1.0, needed: 0, unusable: false, tiles: Vec::new(), edges: Vec::new() }
    }

    pub(super) fn if_any(self) -> Option<Self> {
        (self != Self::none(&self.limits)).then_some(self)
    }

    /// Whether surfaces are coarser than asked. Else only edges are, whose curves run to and fro far more often than those
    /// of real models: noise, which no limit of the caller's would make smooth.
    #[must_use]
    pub fn of_surfaces(&self) -> bool {
        self.unusable || self.density < 1.0 || !self.tiles.is_empty()
    }
}

impl fmt::Display for Shortfall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { limits, density, needed, unusable, tiles, edges } = self;
        write!(f, "the mesh is coarser than the tolerance asks")?;
        if *unusable {
            write!(f, "; the tolerance is not a usable number, or too small for the model")?;
        }
        if *density < 1.0 {
            write!(f, "; it would have up to {needed} triangles, the limit is {}", limits.triangles)?;
            if limits.allowed() < limits.triangles {
                let bytes = limits.bytes;
                write!(f, " and {bytes} bytes of memory (PlanLimits::bytes) at {BYTES_PER_TRIANGLE} per triangle")?;
            } else {
                write!(f, " (PlanLimits::triangles)")?;
            }
            write!(f, ": {density:.1e} times the lines")?;
        }
        if !tiles.is_empty() {
            let (count, most) = (tiles.len(), limits.triangles_per_tile);
            write!(
                f,
                "; {count} tiles reach the limit of {most} triangles (PlanLimits::triangles_per_tile) or of lines"
            )?;
        }
        if !edges.is_empty() {
            write!(f, "; {} edges reach the limit of segments", edges.len())?;
        }
        Ok(())
    }
}

impl std::error::Error for Shortfall {}

/// What is left of the limits.
pub(super) struct Budget {
    /// Cells and tessellants.
    pub(super) left: u64,
    pub(super) cells_per_tile: u64,
}

impl Budget {
    pub(super) fn of(limits: &PlanLimits) -> Self {
        Self { left: limits.allowed() / 2, cells_per_tile: (limits.triangles_per_tile / 2).max(1) }
    }

    /// `None` when there is not as much.
    pub(super) fn spend(&mut self, cells: u64) -> Option<()> {
        self.left = self.left.checked_sub(cells)?;
        Some(())
    }
}
