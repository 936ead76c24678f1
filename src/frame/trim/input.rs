//! Input of the trim stage: the loops of one tile in cell units.

use glam::{DVec2, DVec3};

/// Index that stands for no vertex, crossing, ring or cell.
pub(crate) const NONE: u32 = u32::MAX;

/// Lattice corners nearer to a segment than this, in cells, are not used as vertices. It bounds the worst angle between
/// a corner and a segment next to it; any positive value is correct.
pub(crate) const CORNER_CLEARANCE: f64 = 1e-3;

/// A tile's trim input in cell units: lattice lines are the integers `0..=cells.0` and `0..=cells.1`.
///
/// Loops of tessellants are closed implicitly and have the kept side on the left (x to the right, y up): outer loops
/// run counter-clockwise, holes clockwise. All points lie in the closed box of the lattice. The tile's border has to be
/// part of the loops too: only what loops enclose is kept.
///
/// Points with equal coordinates are one vertex of the domain. Points with equal places are one vertex of the output's
/// boundary.
#[derive(Clone, Copy, Debug)]
pub struct TrimInput<'a> {
    /// Number of cells in x and in y, both in 1..65535.
    pub cells: (u32, u32),
    /// The tessellants of all loops, one loop after the other.
    pub points: &'a [DVec2],
    /// Where each loop starts in `points`, and `points.len()` at the end: one entry more than there are loops.
    pub loop_starts: &'a [u32],
    /// Positions of the points in space; equal bits are the same place. If empty, each point has its own place.
    pub places: &'a [DVec3],
}

/// Why an input is refused.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrimInputError {
    /// A coordinate is not finite, or the point lies outside the lattice's box.
    #[error("tessellant {index} at {point} is not inside the lattice of {} x {} cells", .cells.0, .cells.1)]
    PointOutside {
        /// Index into `points`.
        index: u32,
        /// The point, in cell units.
        point: DVec2,
        /// The box is (0, 0) to these numbers.
        cells: (u32, u32),
    },
    /// `loop_starts` does not partition `points`.
    #[error("entry {index} of loop_starts does not fit the tessellants")]
    LoopStarts {
        /// First offending entry of `loop_starts`; its length when it is empty or ends early.
        index: usize,
    },
    /// The lattice has no cells or 65535 or more in a row, or the vertex ids do not fit 31 bits.
    #[error("{points} tessellants on {} x {} cells: the lattice is empty or too large", .cells.0, .cells.1)]
    Size {
        /// Number of tessellants.
        points: usize,
        /// Number of cells in x and in y.
        cells: (u32, u32),
    },
}

impl TrimInput<'_> {
    /// Checks the contract of [`TrimInput`]. No later stage checks again.
    pub(crate) fn validate(&self) -> Result<(), TrimInputError> {
        let (nu, nv) = self.cells;
        let vertices = (u64::from(nu) + 1) * (u64::from(nv) + 1) + self.points.len() as u64;
        let cells = 1..u32::from(u16::MAX);
        if !cells.contains(&nu) || !cells.contains(&nv) || vertices >= 1 << 31 {
            return Err(TrimInputError::Size { points: self.points.len(), cells: self.cells });
        }
        let mut last = 0;
        for (index, &start) in self.loop_starts.iter().enumerate() {
            if start < last || (index == 0 && start != 0) {
                return Err(TrimInputError::LoopStarts { index });
            }
            last = start;
        }
        if last as usize != self.points.len() || self.loop_starts.is_empty() {
            return Err(TrimInputError::LoopStarts { index: self.loop_starts.len() });
        }
        let upper = DVec2::new(f64::from(nu), f64::from(nv));
        // Written so that NaN fails.
        let inside = |p: &DVec2| (p.x >= 0.0) & (p.y >= 0.0) & (p.x <= upper.x) & (p.y <= upper.y);
        // Nearly always all points are inside. No early exit, so that the loop is vectorised.
        if self.points.iter().fold(true, |all, p| all & inside(p)) {
            return Ok(());
        }
        let Some(index) = self.points.iter().position(|p| !inside(p)) else { return Ok(()) };
        Err(TrimInputError::PointOutside { index: index as u32, point: self.points[index], cells: self.cells })
    }

    /// The tessellant ids of each loop.
    pub(crate) fn loops(&self) -> impl Iterator<Item = std::ops::Range<u32>> + '_ {
        self.loop_starts.windows(2).map(|w| w[0]..w[1])
    }

    /// The first tessellant of a loop, and the end of its tessellants.
    #[inline(always)]
    pub(crate) fn ends(&self, loop_index: u32) -> [u32; 2] {
        [0, 1].map(|k| self.loop_starts[(loop_index + k) as usize])
    }

    /// The tessellant after `v` in its loop.
    #[inline(always)]
    pub(crate) fn next(&self, loop_index: u32, v: u32) -> u32 {
        next_in(&self.ends(loop_index), v)
    }

    /// The directed segments (from, to), loop after loop.
    pub(crate) fn segments(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.loop_starts.windows(2).flat_map(|ends| (ends[0]..ends[1]).map(move |v| (v, next_in(ends, v))))
    }

    /// The id of lattice corner (i, j).
    pub(crate) fn corner_id(&self, i: u32, j: u32) -> u32 {
        self.points.len() as u32 + j * (self.cells.0 + 1) + i
    }

    /// Column and row of a cell.
    pub(crate) fn cell(&self, index: u32) -> [u32; 2] {
        [index % self.cells.0, index / self.cells.0]
    }

    /// The ids of the corners of cell (i, j), counter-clockwise from the lowest.
    pub(crate) fn cell_corners(&self, [i, j]: [u32; 2]) -> [u32; 4] {
        [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| self.corner_id(i, j))
    }

    /// Position of a tessellant or a lattice corner, in cell units.
    pub(crate) fn point(&self, v: u32) -> DVec2 {
        let (count, width) = (self.points.len() as u32, self.cells.0 + 1);
        if v < count {
            return self.points[v as usize];
        }
        DVec2::new(f64::from((v - count) % width), f64::from((v - count) / width))
    }
}

/// The tessellant after `v` in a loop that starts at `ends[0]` and ends before `ends[1]`.
fn next_in(ends: &[u32], v: u32) -> u32 {
    if v + 1 == ends[1] { ends[0] } else { v + 1 }
}
