//! What a plan may cost in all, and what it says when that is less than the tolerance asks for.

use crate::model::{PartId, RowId, TileId};
use std::fmt;

/// Memory of one triangle on its way to a file: its corners' numbers, its share of the vertices with their normals, and the
/// same again as the file's bytes.
pub const BYTES_PER_TRIANGLE: u64 = 128;

/// Most that a plan may hold. Triangles are counted as two per cell of a lattice, kept or trimmed away, and two per tessellant;
/// each part counts once, however often it is placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
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
    pub(crate) fn allowed(&self) -> u64 {
        self.triangles.min(self.bytes / BYTES_PER_TRIANGLE)
    }

    /// Sets [`triangles_per_tile`](Self::triangles_per_tile).
    #[must_use]
    pub const fn with_triangles_per_tile(mut self, triangles_per_tile: u64) -> Self {
        self.triangles_per_tile = triangles_per_tile;
        self
    }

    /// Sets [`triangles`](Self::triangles).
    #[must_use]
    pub const fn with_triangles(mut self, triangles: u64) -> Self {
        self.triangles = triangles;
        self
    }

    /// Sets [`bytes`](Self::bytes).
    #[must_use]
    pub const fn with_bytes(mut self, bytes: u64) -> Self {
        self.bytes = bytes;
        self
    }
}

impl Default for PlanLimits {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// In what a plan is coarser than its tolerance asks, and because of which limits.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
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
    /// Tiles limited by [`PlanLimits::triangles_per_tile`]; ascending.
    pub tiles: Vec<(PartId, TileId)>,
    /// Tiles with as many lines between two creases as there may be, 4096, or whose loops meet themselves along edges so far off
    /// their surface that lines for the angle would follow noise; ascending. Real shapes get to 4096 at tolerances of
    /// 1e-8 of their size; else the bounds of the surface's derivatives grow without limit, as they do towards some poles.
    pub lines: Vec<(PartId, TileId)>,
    /// Edges limited in their tessellants, as rows of [`PreparedPart::edges`](crate::prepare::internals::PreparedPart::edges);
    /// ascending.
    pub edges: Vec<(PartId, RowId)>,
}

impl Shortfall {
    /// Nothing is missing.
    pub(crate) fn none(limits: &PlanLimits) -> Self {
        Self {
            limits: *limits,
            density: 1.0,
            needed: 0,
            unusable: false,
            tiles: Vec::new(),
            lines: Vec::new(),
            edges: Vec::new(),
        }
    }

    pub(crate) fn if_any(self) -> Option<Self> {
        (self != Self::none(&self.limits)).then_some(self)
    }

    /// Whether the tolerance or a limit of the caller's is the cause. Else single tiles or edges of the model are, whose
    /// derivatives no real model has: noise, to which more lines would only add triangles.
    #[must_use]
    pub fn by_limits(&self) -> bool {
        let noise = |tile| self.lines.contains(tile);
        self.unusable || self.density < 1.0 || !self.tiles.iter().all(noise)
    }
}

impl fmt::Display for Shortfall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { limits, density, needed, unusable, tiles, lines, edges } = self;
        write!(f, "limits make the mesh coarser than the tolerance asks")?;
        if *unusable {
            write!(f, "; the tolerance is not a usable number, or too small for the model")?;
        }
        if *density < 1.0 {
            write!(f, "; its cells and boundaries can make {needed} triangles, the limit is {}", limits.triangles)?;
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
            write!(f, "; {count} tiles reach the limit of {most} triangles (PlanLimits::triangles_per_tile)")?;
        }
        if !lines.is_empty() {
            write!(f, "; {} tiles reach the limit of lines", lines.len())?;
        }
        if !edges.is_empty() {
            write!(f, "; {} edges reach the limit of segments", edges.len())?;
        }
        Ok(())
    }
}

impl std::error::Error for Shortfall {}
