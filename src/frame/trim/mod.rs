//! Lattice and trim loops of one tile -> full cells, and triangles of the cells the loops pass through.
//!
//! The vertices are lattice corners and tessellants, nothing else, and every tessellant segment is one edge of one triangle:
//! so neighbouring tiles and faces that share the tessellants share the edges, and no crack can open.
//!
//! Method: each crossing of a segment with a lattice line is replaced, in both cells alike, by the nearer end of the segment.
//! Cell polygons are then runs of tessellants and kept corners. Replacing vertices commutes with taking boundaries, so if
//! every triangle of every cell is strictly positive (exact signs) the triangles cover the kept region exactly once. What
//! fails is merged with a neighbour, then triangulated by a constrained Delaunay triangulation. The scheme descends from
//! Kumar and Manocha, "Efficient Rendering of Trimmed NURBS Surfaces", Computer-Aided Design 27(7), 1995, section 4; the
//! certificate replaces its case analysis.

use std::fmt;

use glam::DVec2;

mod cdt;
/// The whole tile at once by a constrained Delaunay triangulation: slow, proven, and the oracle of the tests.
pub mod reference;

/// A tile's trim input in cell units: lattice lines are the integers `0..=cells.0` and `0..=cells.1`.
///
/// Loops of tessellants, closed implicitly, with the kept side on the left (x to the right, y up): outer loops run
/// counter-clockwise, holes clockwise. All points lie in the closed box of the lattice. What surrounds the tile (its border)
/// is a loop or part of one like any other; nothing is kept that no loop encloses.
///
/// Points with equal coordinates are one vertex of the domain: the output may name any of their ids, and prefers the one whose
/// segment bounds the triangle. Segments between equal points have no length and appear in no triangle.
#[derive(Clone, Copy, Debug)]
pub struct TrimInput<'a> {
    /// Number of cells in x and in y, both at least 1.
    pub cells: (u32, u32),
    /// The tessellants of all loops, one loop after the other.
    pub points: &'a [DVec2],
    /// Where each loop starts in `points`, and `points.len()` at the end: one entry more than there are loops.
    pub loop_starts: &'a [u32],
}

/// The triangulated trim part of a tile.
#[derive(Clone, Default, Debug)]
pub struct TrimOutput {
    /// Counter-clockwise triangles, strictly positive. A vertex id below `points.len()` is that tessellant; the id
    /// `points.len() + j * (cells.0 + 1) + i` is the lattice corner (i, j); ids from `points.len() + (cells.0 + 1) *
    /// (cells.1 + 1)` on count `extra_points`.
    pub triangles: Vec<[u32; 3]>,
    /// Cells (i, j) that no loop touches, wholly kept: the caller splits each along the diagonal it prefers.
    pub full_cells: Vec<[u32; 2]>,
    /// Points where segments cross each other. Empty unless the outcome is [`TrimOutcome::Repaired`].
    pub extra_points: Vec<DVec2>,
    /// What the work consisted of.
    pub stats: TrimStats,
}

/// Which rung of the ladder a tile needed; the later, the more work.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub enum TrimOutcome {
    /// Every cell polygon was triangulated by itself.
    #[default]
    Certified,
    /// Some cell polygons were merged with one neighbour.
    Merged,
    /// Some cells, or the whole tile, needed a constrained Delaunay triangulation. As conforming as the rungs above.
    Cdt,
    /// The loops cross or overlap themselves or each other. The kept region is the points of positive winding number; it is
    /// still covered by positive triangles that match along their inner edges.
    Repaired {
        /// Tessellant segments that do not appear as one edge: split at a crossing or at another loop's vertex.
        split: u32,
        /// Tessellant segments without a kept side, left out wholly or partly.
        unused: u32,
    },
}

/// Counts of one tile; all zero after [`TrimOutcome::Certified`] except the first three.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
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
}

/// Input that no rung can work on.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum TrimError {
    /// A coordinate is not finite, or the point lies outside the lattice's box.
    PointOutside {
        /// Index into `points`.
        index: u32,
        /// The point, in cell units.
        point: DVec2,
        /// The box is (0, 0) to these numbers.
        cells: (u32, u32),
    },
    /// `loop_starts` does not partition `points`.
    LoopStarts {
        /// First offending entry of `loop_starts`; its length when it is empty or ends early.
        index: usize,
    },
    /// The lattice has no cells, or the vertex ids do not fit 31 bits.
    Size {
        /// Number of tessellants.
        points: usize,
        /// Number of cells in x and in y.
        cells: (u32, u32),
    },
}

impl fmt::Display for TrimError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PointOutside { index, point, cells } => {
                write!(f, "tessellant {index} at {point} is not inside the lattice of {} x {} cells", cells.0, cells.1)
            }
            Self::LoopStarts { index } => write!(f, "entry {index} of the loop starts does not fit the tessellants"),
            Self::Size { points, cells } => {
                write!(f, "{points} tessellants on {} x {} cells: no cells, or too many vertices", cells.0, cells.1)
            }
        }
    }
}

impl std::error::Error for TrimError {}

/// Work space of [`trim_tile`]; holds capacity only, no result depends on what it was used for before.
#[derive(Default)]
pub struct TrimScratch {
    _capacity: (),
}

/// Triangulates the trimmed part of one tile.
///
/// `out` is overwritten; on an error it is empty. Deterministic: the same input gives the same output, whatever `scratch`
/// has seen.
///
/// # Errors
/// Only input outside the contract of [`TrimInput`] is refused; loops that cross are repaired.
pub fn trim_tile(
    input: &TrimInput<'_>,
    scratch: &mut TrimScratch,
    out: &mut TrimOutput,
) -> Result<TrimOutcome, TrimError> {
    scratch._capacity = ();
    reference::trim_tile_reference(input, out)
}

impl TrimOutput {
    fn clear(&mut self) {
        self.triangles.clear();
        self.full_cells.clear();
        self.extra_points.clear();
        self.stats = TrimStats::default();
    }
}

impl TrimInput<'_> {
    /// Refuses what the stages cannot work on. After this no stage checks again.
    fn validate(&self) -> Result<(), TrimError> {
        let (nu, nv) = self.cells;
        let vertices = (u64::from(nu) + 1) * (u64::from(nv) + 1) + self.points.len() as u64;
        if nu == 0 || nv == 0 || vertices >= 1 << 31 {
            return Err(TrimError::Size { points: self.points.len(), cells: self.cells });
        }
        let mut last = 0;
        for (index, &start) in self.loop_starts.iter().enumerate() {
            if start < last || (index == 0 && start != 0) {
                return Err(TrimError::LoopStarts { index });
            }
            last = start;
        }
        if last as usize != self.points.len() || self.loop_starts.is_empty() {
            return Err(TrimError::LoopStarts { index: self.loop_starts.len() });
        }
        let upper = DVec2::new(f64::from(nu), f64::from(nv));
        // Written so that a NaN fails.
        let inside = |p: &DVec2| p.x >= 0.0 && p.y >= 0.0 && p.x <= upper.x && p.y <= upper.y;
        match self.points.iter().position(|p| !inside(p)) {
            None => Ok(()),
            Some(index) => {
                Err(TrimError::PointOutside { index: index as u32, point: self.points[index], cells: self.cells })
            }
        }
    }

    /// The tessellant ids of each loop.
    fn loops(&self) -> impl Iterator<Item = std::ops::Range<u32>> + '_ {
        self.loop_starts.windows(2).map(|w| w[0]..w[1])
    }

    /// The directed segments (from, to), loop after loop.
    fn segments(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.loops().flat_map(|l| l.clone().map(move |v| (v, if v + 1 == l.end { l.start } else { v + 1 })))
    }

    /// The id of lattice corner (i, j).
    fn corner_id(&self, i: u32, j: u32) -> u32 {
        self.points.len() as u32 + j * (self.cells.0 + 1) + i
    }
}
