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

pub(super) mod again;
mod bits;
pub(super) mod cdt;
mod cleanup;
mod record;
pub use record::{TracedCrossing, TrimRecord};
/// The whole tile at once by a constrained Delaunay triangulation: slow, proven, and the oracle of the tests.
pub mod reference;
mod rings;
mod slits;
mod trace;
mod triangulate;
pub(super) mod weave;

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
    /// Number of cells in x and in y, both in 1..65535.
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
///
/// Except for [`TrimOutcome::Repaired`], simple loops are covered once, every tessellant segment is an edge of exactly one
/// triangle, in its direction, and all other edges match in pairs. Loops that cross but wind around no point backwards may pass
/// as well: then a point has as many layers as the loops wind around it, with the loops as boundary, and layers may meet in an
/// edge.
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
    /// still covered once by positive triangles that match along their inner edges. Not so with [`TrimStats::given_up`].
    Repaired {
        /// Tessellant segments that do not appear as one edge: split at a crossing or at another loop's vertex.
        split: u32,
        /// Tessellant segments without a kept side, left out wholly or partly.
        unused: u32,
    },
}

/// Counts of one tile. A tile that went to the reference keeps the counts of the attempt before.
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
    /// The loops cross more often than they are split: what is kept is not the region of positive winding number.
    pub given_up: bool,
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
    /// The lattice has no cells or 65535 or more in a row, or the vertex ids do not fit 31 bits.
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
                write!(f, "{points} tessellants on {} x {} cells: no cells, or too many", cells.0, cells.1)
            }
        }
    }
}

impl std::error::Error for TrimError {}

/// Work space of [`trim_tile`]; holds capacity only, no result depends on what it was used for before.
#[derive(Default)]
pub struct TrimScratch {
    ladder: Ladder,
    distinct: Distinct,
}

/// Work space of the rungs that work cell by cell.
#[derive(Default)]
struct Ladder {
    trace: trace::Trace,
    rings: rings::Rings,
    slits: slits::Slits,
    polygon: triangulate::Polygon,
    again: again::AgainScratch,
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
    out.clear();
    input.validate()?;
    let TrimScratch { ladder, distinct } = scratch;
    let outcome = if distinct.collect(input) {
        let outcome = ladder.climb(&distinct.tile(input), out);
        distinct.restore_ids(input, &mut out.triangles);
        outcome
    } else {
        ladder.climb(input, out)
    };
    out.stats.outcome = outcome;
    Ok(outcome)
}

impl Ladder {
    /// Loops without segments of length zero -> triangles, by the first rung that holds.
    fn climb(&mut self, tile: &TrimInput<'_>, out: &mut TrimOutput) -> TrimOutcome {
        // The two segments of a loop of two tessellants cancel as a chain, and would vanish.
        if tile.loops().all(|l| l.len() != 2) {
            for reach in [reference::CORNER_CLEARANCE, 0.0] {
                out.clear();
                out.stats.retraced = reach == 0.0;
                match self.by_cells(tile, reach, out) {
                    Ok(outcome) => return outcome,
                    Err(Refused::OrderOfCrossings) => {}
                    Err(Refused::NotSimple) => break,
                }
            }
        }
        out.stats.whole_tile = true;
        reference::triangulate_tile(tile, out)
    }

    fn by_cells(&mut self, tile: &TrimInput<'_>, reach: f64, out: &mut TrimOutput) -> Result<TrimOutcome, Refused> {
        self.trace.reset(tile, reach);
        self.trace.run(tile, None);
        self.by_traced_cells(tile, out)
    }

    /// The same where the loops were traced.
    fn by_traced_cells(&mut self, tile: &TrimInput<'_>, out: &mut TrimOutput) -> Result<TrimOutcome, Refused> {
        let Self { trace, rings, slits, polygon, .. } = self;
        out.stats.crossings = trace.crossings.len() as u32;
        let mut area = 0.0;
        if rings.build_one_cell(tile, trace, slits, polygon, out) {
            area += rings.double_area;
        } else {
            rings.build(tile, trace, polygon, out, |_| false).map_err(|_| Refused::OrderOfCrossings)?;
            out.stats.rings = rings.rings.len() as u32;
            out.stats.failed_rings = rings.failed;
            area += rings.double_area;
            if rings.failed > 0 || !trace.in_cell_loops.is_empty() {
                cleanup::clean_up(tile, trace, rings, slits, polygon, out).map_err(|_| Refused::NotSimple)?;
                area = out.double_area(tile);
            }
        }
        self.certified(tile, area, &out.stats)
    }

    /// How it went, if twice the area of the triangles is that of the loops.
    fn certified(&self, tile: &TrimInput<'_>, area: f64, stats: &TrimStats) -> Result<TrimOutcome, Refused> {
        // Positive triangles of the right total area cover the region once. Loops that are not simple can pass everything
        // but this, because full cells come from parities and rings from the order of crossings.
        let cells = f64::from(tile.cells.0) * f64::from(tile.cells.1);
        if (area - self.trace.double_area).abs() > AREA_TOLERANCE * cells {
            return Err(Refused::OrderOfCrossings);
        }
        Ok(if stats.clusters > 0 {
            TrimOutcome::Cdt
        } else if stats.merged_rings > 0 {
            TrimOutcome::Merged
        } else {
            TrimOutcome::Certified
        })
    }
}

/// Why a tile could not be triangulated cell by cell.
enum Refused {
    /// Exact ownership may help.
    OrderOfCrossings,
    NotSimple,
}

/// Largest difference between twice the triangles' area and twice the loops', as a share of the tile. Rounding stays below
/// 1e-12; a wrongly covered cell of the largest lattice is 1e-9.
const AREA_TOLERANCE: f64 = 1e-10;

/// Loops without segments of length zero, and where their points come from.
#[derive(Default)]
struct Distinct {
    points: Vec<DVec2>,
    loop_starts: Vec<u32>,
    /// Index in the input.
    original: Vec<u32>,
    /// Whether the last loops had any.
    repeats: bool,
}

impl Distinct {
    /// Copies the loops without repeated points, unless no point is repeated: then returns false.
    fn collect(&mut self, input: &TrimInput<'_>) -> bool {
        let points = input.points;
        let repeats = |l: std::ops::Range<u32>| {
            let l = &points[l.start as usize..l.end as usize];
            l.windows(2).any(|w| w[0] == w[1]) || (!l.is_empty() && l[0] == l[l.len() - 1])
        };
        self.repeats = input.loops().any(repeats);
        if !self.repeats {
            return false;
        }
        self.points.clear();
        self.original.clear();
        self.loop_starts.clear();
        self.loop_starts.push(0);
        for l in input.loops() {
            let start = self.points.len();
            for v in l {
                let p = points[v as usize];
                if self.points[start..].last() != Some(&p) {
                    self.points.push(p);
                    self.original.push(v);
                }
            }
            while self.points.len() > start && self.points[start] == self.points[self.points.len() - 1] {
                self.points.pop();
                self.original.pop();
            }
            self.loop_starts.push(self.points.len() as u32);
        }
        true
    }

    fn tile<'a>(&'a self, input: &TrimInput<'_>) -> TrimInput<'a> {
        TrimInput { cells: input.cells, points: &self.points, loop_starts: &self.loop_starts }
    }

    fn restore_ids(&self, input: &TrimInput<'_>, triangles: &mut [[u32; 3]]) {
        let (ours, theirs) = (self.original.len() as u32, input.points.len() as u32);
        for v in triangles.iter_mut().flatten() {
            *v = if *v < ours { self.original[*v as usize] } else { *v - ours + theirs };
        }
    }
}

impl TrimOutput {
    fn clear(&mut self) {
        self.triangles.clear();
        self.full_cells.clear();
        self.extra_points.clear();
        self.stats = TrimStats::default();
    }

    /// Empty, with the counts of a tile that was triangulated before.
    pub(super) fn reset(&mut self, stats: TrimStats) {
        self.clear();
        self.stats = stats;
    }

    /// Twice the area of triangles and full cells. There are no extra points yet.
    fn double_area(&self, tile: &TrimInput<'_>) -> f64 {
        let (count, width) = (tile.points.len() as u32, tile.cells.0 + 1);
        let position = |v: u32| {
            if v < count {
                tile.points[v as usize]
            } else {
                DVec2::new(f64::from((v - count) % width), f64::from((v - count) / width))
            }
        };
        let turn = |t: &[u32; 3]| {
            let [a, b, c] = t.map(position);
            (b - a).perp_dot(c - a)
        };
        self.triangles.iter().map(turn).sum::<f64>() + 2.0 * self.full_cells.len() as f64
    }
}

impl TrimInput<'_> {
    /// Refuses what the stages cannot work on. After this no stage checks again.
    fn validate(&self) -> Result<(), TrimError> {
        let (nu, nv) = self.cells;
        let vertices = (u64::from(nu) + 1) * (u64::from(nv) + 1) + self.points.len() as u64;
        let cells = 1..u32::from(u16::MAX);
        if !cells.contains(&nu) || !cells.contains(&nv) || vertices >= 1 << 31 {
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
