//! What the trim stage makes: triangles, full cells, and how it came to them.

use super::input::TrimInput;
use glam::DVec2;

/// The triangulated trim part of a tile.
///
/// The boundary of all triangles together (`triangles`, the halves of `full_cells`, `layers` as often as they say, and
/// `closing`) is the sum of the loops' segments, as a chain over places, in which an edge and its reverse cancel. It is so for
/// every input that is not refused.
///
/// A vertex id below `points.len()` is that tessellant; the id `points.len() + j * (cells.0 + 1) + i` is the lattice corner
/// (i, j); ids from `points.len() + (cells.0 + 1) * (cells.1 + 1)` on count `extra_points`.
#[derive(Clone, Default, Debug)]
pub struct TrimOutput {
    /// Counter-clockwise triangles, strictly positive: what the loops wind around a positive number of times.
    pub triangles: Vec<[u32; 3]>,
    /// Cells (i, j) that no loop touches, wholly kept: the caller splits each along the diagonal it prefers.
    pub full_cells: Vec<[u32; 2]>,
    /// Where the loops wind otherwise than once: counter-clockwise triangles and how often each is used more, reversed where
    /// that is negative. Empty unless the outcome is [`TrimOutcome::Repaired`], like the two below.
    pub layers: Vec<([u32; 3], i32)>,
    /// Triangles of any shape without which the boundary would not be the loops.
    pub closing: Vec<[u32; 3]>,
    /// Points where segments cross each other.
    pub extra_points: Vec<DVec2>,
    /// What the work consisted of.
    pub stats: TrimStats,
}

/// Which rung of the ladder a tile needed; the later, the more work.
///
/// Except for [`TrimOutcome::Repaired`], simple loops are covered once, every tessellant segment that no other cancels is an
/// edge of exactly one triangle, in its direction, and all other edges match in pairs. Loops that cross but wind around no point backwards may pass
/// as well: then a point has as many layers as the loops wind around it, and layers may meet in an edge.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub enum TrimOutcome {
    /// Every cell polygon was triangulated by itself.
    #[default]
    Certified,
    /// Some cell polygons were merged with one neighbour.
    Merged,
    /// Some cells, or the whole tile, needed a constrained Delaunay triangulation. As conforming as the rungs above.
    Cdt,
    /// The loops cross or overlap themselves or each other, or points at different places coincide. Each point is covered as
    /// often as the loops wind around it, reversed where that is negative, and triangles that only close are added.
    Repaired {
        /// Tessellant segments that do not appear as one edge: split at a crossing or at another loop's vertex.
        split: u32,
    },
}

/// Counts of one tile. A tile that went to the reference keeps the counts of the attempt before.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
#[non_exhaustive]
pub struct TrimStats {
    /// The rung that was needed, as returned.
    pub outcome: TrimOutcome,
    /// Crossings of tessellant segments with lattice lines.
    pub crossings: u32,
    /// Cell polygons.
    pub rings: u32,
    /// Cell polygons that could not be triangulated by themselves.
    pub failed_rings: u32,
    /// Failed cell polygons that became positive together with one neighbour.
    pub merged_rings: u32,
    /// Constrained Delaunay triangulations of some cells.
    pub clusters: u32,
    /// Times a cluster was refused and grew by its neighbours.
    pub grown: u32,
    /// The tile was traced again with exact ownership, because two curves pass within the snapping distance.
    pub retraced: bool,
    /// The tile went to the whole-tile reference.
    pub whole_tile: bool,
    /// Pieces of segments that cross others more often than is worth splitting: led along edges nearby, so that points near
    /// them may be covered otherwise than the loops wind.
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

    /// Empty, with the counts of a tile that was triangulated before.
    pub(crate) fn reset(&mut self, stats: TrimStats) {
        self.clear();
        self.stats = stats;
    }

    /// Renames the corners of all triangles, of full cells not.
    pub(crate) fn rename(&mut self, mut name: impl FnMut(u32) -> u32) {
        let mut all = |triangle: &mut [u32; 3]| triangle.iter_mut().for_each(|v| *v = name(*v));
        self.triangles.iter_mut().for_each(&mut all);
        self.layers.iter_mut().for_each(|(triangle, _)| all(triangle));
        self.closing.iter_mut().for_each(all);
    }

    /// Where a vertex is, in cell units.
    pub(crate) fn point(&self, tile: &TrimInput<'_>, v: u32) -> DVec2 {
        let (count, width) = (tile.points.len() as u32, tile.cells.0 + 1);
        if v < count {
            return tile.points[v as usize];
        }
        let (i, j) = ((v - count) % width, (v - count) / width);
        if j <= tile.cells.1 {
            return DVec2::new(f64::from(i), f64::from(j));
        }
        self.extra_points[(v - count - width * (tile.cells.1 + 1)) as usize]
    }
}
