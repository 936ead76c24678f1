//! Output of the trim stage: triangles, full cells, and counts of the work.

use super::input::TrimInput;
use crate::math::lanes::widest;
use glam::DVec2;

/// The triangulated trim part of a tile.
///
/// The boundary of all triangles together (`triangles`, the halves of `full_cells`, `layers` with their multiplicities,
/// and `closing`) is the sum of the loops' segments, as a chain over places in which an edge and its reverse cancel.
/// This holds for every valid input.
///
/// A vertex id below `points.len()` is that tessellant; the id `points.len() + j * (cells.0 + 1) + i` is the lattice
/// corner (i, j); ids from `points.len() + (cells.0 + 1) * (cells.1 + 1)` on are indices into `extra_points`.
#[derive(Clone, Default, Debug)]
pub struct TrimOutput {
    /// Counter-clockwise triangles, strictly positive. With `full_cells`, they cover the points of positive winding
    /// number once.
    pub triangles: Vec<[u32; 3]>,
    /// Kept cells (i, j) that no loop touches. The caller splits each along a diagonal of its choice.
    pub full_cells: Vec<[u32; 2]>,
    /// Counter-clockwise triangles where the winding number is neither 0 nor 1, with how many more times each is used,
    /// reversed if negative. Empty unless the outcome is [`TrimOutcome::Repaired`], as are the next two fields.
    pub layers: Vec<([u32; 3], i32)>,
    /// Triangles of any shape that complete the boundary to the loops.
    pub closing: Vec<[u32; 3]>,
    /// Points where segments cross each other.
    pub extra_points: Vec<DVec2>,
    /// Counts of the work.
    pub stats: TrimStats,
}

/// The rung of the ladder that a tile needed, in order of rising cost.
///
/// On all rungs but [`TrimOutcome::Repaired`], simple loops are covered once. Every tessellant segment that no other
/// cancels is an edge of exactly one triangle, in its direction, and all other edges match in pairs. Loops that cross
/// without winding backwards around any point may pass as well: a point then has as many layers as the loops wind
/// around it, and layers may meet in an edge.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub enum TrimOutcome {
    /// Every cell polygon was triangulated by itself.
    #[default]
    Certified,
    /// Some cells, or the whole tile, needed a constrained Delaunay triangulation. As conforming as the rungs above.
    Cdt,
    /// The loops cross or overlap themselves or each other, or points at different places coincide. Each point is
    /// covered as often as the loops wind around it, by reversed triangles where that is negative. Closing triangles
    /// complete the boundary.
    Repaired {
        /// Number of tessellant segments that are not one edge: split at a crossing or at another loop's vertex.
        split: u32,
    },
}

/// Counts for one tile. A tile that went to the reference keeps the counts of the failed attempt.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
#[non_exhaustive]
pub struct TrimStats {
    /// The rung that was needed, as returned.
    pub outcome: TrimOutcome,
    /// Cell polygons that could not be triangulated by themselves.
    pub failed_rings: u32,
    /// Whether the tile went to the whole-tile reference.
    pub whole_tile: bool,
    /// Pieces of segments with too many crossings to split. They follow edges nearby, so points next to them may be
    /// covered otherwise than the loops wind.
    pub led: u32,
}

impl TrimOutput {
    pub(crate) fn clear(&mut self) {
        self.triangles.clear();
        self.full_cells.clear();
        self.layers.clear();
        self.closing.clear();
        self.extra_points.clear();
        self.stats = TrimStats::default();
    }

    /// Renames the vertices of all triangles, but not of full cells. `name` must not change numbers below `first`.
    pub(crate) fn rename(&mut self, first: u32, mut name: impl FnMut(u32) -> u32) {
        // Most tiles have tessellants alone. Finding the largest number costs less than a pass that renames none.
        let vertices = self.triangles.as_flattened();
        let renamed = widest(
            #[inline(always)]
            || vertices.iter().fold(0, |most, &v| most.max(v)),
        ) >= first;
        let triangles = if renamed { self.triangles.as_flattened_mut() } else { &mut [] };
        for v in triangles {
            *v = name(*v);
        }
        let layers = self.layers.iter_mut().flat_map(|(triangle, _)| triangle);
        for v in layers.chain(self.closing.as_flattened_mut()) {
            *v = name(*v);
        }
    }

    /// Position of a vertex, in cell units.
    pub(crate) fn point(&self, tile: &TrimInput<'_>, v: u32) -> DVec2 {
        let first_extra = tile.corner_id(tile.cells.0, tile.cells.1) + 1;
        if v < first_extra { tile.point(v) } else { self.extra_points[(v - first_extra) as usize] }
    }
}
