//! Limits on the size of a plan, and the report on what they make coarser than the tolerance requires.

use crate::model::{PartId, RowId, TileId};
use std::fmt;

/// Memory per triangle on its way to a file: its indices, its share of vertices and normals, and as much again for the
/// file's bytes.
pub const BYTES_PER_TRIANGLE: u64 = 128;

/// Limits on the size of a plan. Triangles are counted as two per lattice cell, trimmed away or not, and two per
/// tessellant. Each part counts once, however many instances it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PlanLimits {
    /// Triangles of one tile.
    pub triangles_per_tile: u64,
    /// Triangles of all tiles together.
    pub triangles: u64,
    /// Memory of the whole mesh, bytes, at [`BYTES_PER_TRIANGLE`]. Plans for a tolerance count the prepared model, too.
    pub bytes: u64,
}

impl PlanLimits {
    /// 8 million triangles per tile, 64 million in all, 16 GiB.
    pub const DEFAULT: Self = Self { triangles_per_tile: 1 << 23, triangles: 1 << 26, bytes: 16 << 30 };

    /// Triangles allowed by both limits on the whole mesh, next to a prepared model of `held_mib` MiB.
    pub(crate) fn allowed(&self, held_mib: u32) -> u64 {
        self.triangles.min(self.bytes.saturating_sub(u64::from(held_mib) << 20) / BYTES_PER_TRIANGLE)
    }
}

options! {
    PlanLimits:
    with_triangles_per_tile(triangles_per_tile: u64);
    with_triangles(triangles: u64);
    with_bytes(bytes: u64);
}

/// Where a plan is coarser than its tolerance requires, and because of which limits.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Shortfall {
    /// The limits of the plan.
    pub limits: PlanLimits,
    /// Memory of the prepared model, MiB, which counts towards [`PlanLimits::bytes`]; 0 for views.
    #[cfg_attr(feature = "serde", serde(default))]
    pub held_mib: u32,
    /// Density of lines and tessellants as a fraction of what the tolerance requires: 1 unless
    /// [`PlanLimits::triangles`] or [`PlanLimits::bytes`] lowers it.
    pub density: f64,
    /// Upper bound on the triangles at full density; 0 if the limits allow that.
    pub needed: u64,
    /// Whether the tolerance has a value that is invalid or too small to meet, or the view is invalid. A tolerance is
    /// too small if tiles or edges reach their limits, and a circle as large as the part needs 32768 segments or more;
    /// for splines, extrusions, revolutions and edges by the length of edges alone.
    pub unusable: bool,
    /// Tiles limited by [`PlanLimits::triangles_per_tile`]; ascending. In plans for views, here and below, drawn ones.
    pub tiles: Vec<(PartId, TileId)>,
    /// Tiles limited in their lines; ascending. They have 4096 lines between two creases (32768 where a circle as large
    /// as the part needs 2048) or 32768 in one direction, or their loops meet themselves along edges so far off their
    /// surface that lines for the angle would follow noise. Unless [`unusable`](Self::unusable), the bounds of the
    /// surface's derivatives grow without limit, as they do towards some poles.
    pub lines: Vec<(PartId, TileId)>,
    /// Edges limited in their tessellants; ascending. A [`RowId`] counts the edges of a part, then the borders of its
    /// tiles.
    pub edges: Vec<(PartId, RowId)>,
}

impl Shortfall {
    /// No shortfall.
    pub(crate) fn none(limits: &PlanLimits) -> Self {
        Self {
            limits: *limits,
            held_mib: 0,
            density: 1.0,
            needed: 0,
            unusable: false,
            tiles: Vec::new(),
            lines: Vec::new(),
            edges: Vec::new(),
        }
    }

    pub(crate) fn if_any(self) -> Option<Self> {
        (self != Self { held_mib: self.held_mib, ..Self::none(&self.limits) }).then_some(self)
    }

    /// Memory that full density needs, bytes, and the limit on it, if memory rather than the number of triangles lowers
    /// the density.
    #[must_use]
    pub fn memory(&self) -> Option<[u64; 2]> {
        let Self { limits, held_mib, needed, .. } = self;
        let held = u64::from(*held_mib) << 20;
        let is_least = self.density < 1.0 && limits.allowed(*held_mib) < limits.triangles;
        is_least.then(|| [needed.saturating_mul(BYTES_PER_TRIANGLE).saturating_add(held), limits.bytes])
    }

    /// Whether the tolerance or a limit set by the caller is the cause. Otherwise the cause is noise in single tiles or
    /// edges: derivatives that no real model has, where more lines would only add triangles.
    #[must_use]
    pub fn by_limits(&self) -> bool {
        let noise = |tile| self.lines.binary_search(tile).is_ok();
        self.unusable || self.density < 1.0 || !self.tiles.iter().all(noise)
    }
}

impl fmt::Display for Shortfall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { limits, held_mib, density, needed, unusable, tiles, lines, edges } = self;
        write!(f, "limits make the mesh coarser than the tolerance asks")?;
        if *unusable {
            write!(f, "; the tolerance is too small for the model, or it or the view has values out of range")?;
        }
        if *density < 1.0 {
            write!(f, "; it needs up to {needed} triangles, the limit is {}", limits.triangles)?;
            if let Some([_, bytes]) = self.memory() {
                write!(f, " and {bytes} bytes of memory (PlanLimits::bytes) at {BYTES_PER_TRIANGLE} per triangle")?;
                if *held_mib > 0 {
                    write!(f, " next to {held_mib} MiB of the prepared model")?;
                }
            } else {
                write!(f, " (PlanLimits::triangles)")?;
            }
            write!(f, ": the density of lines is lowered to {density:.1e}")?;
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
