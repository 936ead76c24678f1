//! Lattice and trim loops of one tile -> full cells, and triangles of the cells the loops pass through.
//!
//! The vertices are lattice corners and tessellants, and every tessellant segment is one edge of one triangle: neighbouring
//! tiles and faces that share the tessellants share the edges, and no crack can open.
//!
//! Method: each crossing of a segment with a lattice line is replaced, in both cells alike, by the nearer end of the segment.
//! Cell polygons are then runs of tessellants and kept corners. Replacing vertices commutes with taking boundaries, so if
//! every triangle of every cell is strictly positive (exact signs) and their boundary is the loops, they cover each point as
//! often as the loops wind around it. What fails is merged with a neighbour, then triangulated by a constrained Delaunay
//! triangulation. The scheme descends from Kumar and Manocha, "Efficient Rendering of Trimmed NURBS Surfaces",
//! Computer-Aided Design 27(7), 1995, section 4; the certificate replaces its case analysis.
//!
//! Loops that cross themselves or each other are triangulated all the same, by winding numbers, and what then is missing for
//! the boundary to be the loops is added in space (`TrimOutput::closing`): the boundary is the loops for every input.

use std::fmt;

use chain::Fingerprint;
use glam::{DVec2, DVec3};

pub(super) mod again;
mod bits;
pub(super) mod cdt;
pub(super) mod chain;
mod cleanup;
mod close;
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
/// Points with equal coordinates are one vertex of the domain. Points with equal places are one vertex of the output's boundary.
#[derive(Clone, Copy, Debug)]
pub struct TrimInput<'a> {
    /// Number of cells in x and in y, both in 1..65535.
    pub cells: (u32, u32),
    /// The tessellants of all loops, one loop after the other.
    pub points: &'a [DVec2],
    /// Where each loop starts in `points`, and `points.len()` at the end: one entry more than there are loops.
    pub loop_starts: &'a [u32],
    /// Where the points are in space; equal bits are the same place. Empty: each has a place of its own.
    pub places: &'a [DVec3],
}

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
    let TrimScratch { ladder, distinct } = scratch;
    by_distinct(input, distinct, out, |tile, out| ladder.climb(tile, out))
}

/// Triangulates the loops without repeated points by `rung`, and closes what that leaves open.
fn by_distinct(
    input: &TrimInput<'_>,
    distinct: &mut Distinct,
    out: &mut TrimOutput,
    rung: impl FnOnce(&TrimInput<'_>, &mut TrimOutput) -> TrimOutcome,
) -> Result<TrimOutcome, TrimError> {
    out.clear();
    input.validate()?;
    let mut outcome = if distinct.collect(input) {
        let outcome = rung(&distinct.tile(input), out);
        distinct.restore_ids(input, out);
        outcome
    } else {
        rung(input, out)
    };
    // The other rungs have proven that nothing is open; where points were left out that is not all.
    if out.stats.whole_tile || distinct.moves {
        close::close(input, out);
        let is_simple = out.closing.is_empty() && out.layers.is_empty();
        outcome = outcome.max(if is_simple { TrimOutcome::Certified } else { TrimOutcome::Repaired { split: 0 } });
    }
    out.stats.outcome = outcome;
    Ok(outcome)
}

/// Fills the loops without triangulating what they wind around: for tiles that no rung can work on, since it looks at places
/// alone. `out` is overwritten.
pub(super) fn fill_loops(input: &TrimInput<'_>, out: &mut TrimOutput) {
    out.clear();
    close::close(input, out);
    out.stats.outcome = TrimOutcome::Repaired { split: 0 };
}

impl Ladder {
    /// Loops without segments of length zero -> triangles, by the first rung that holds.
    fn climb(&mut self, tile: &TrimInput<'_>, out: &mut TrimOutput) -> TrimOutcome {
        for reach in [reference::CORNER_CLEARANCE, 0.0] {
            out.clear();
            out.stats.retraced = reach == 0.0;
            match self.by_cells(tile, reach, out) {
                Ok(outcome) => return outcome,
                Err(Refused::OrderOfCrossings) => {}
                Err(Refused::NotSimple) => break,
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
        // A slit polygon and its triangles have the loops as their boundary.
        if rings.build_one_cell(tile, trace, slits, polygon, out) {
            return Ok(TrimOutcome::Certified);
        }
        rings.build(tile, trace, polygon, out, |_| false).map_err(|_| Refused::OrderOfCrossings)?;
        out.stats.rings = rings.rings.len() as u32;
        out.stats.failed_rings = rings.failed;
        if rings.failed > 0 || !trace.in_cell_loops.is_empty() {
            cleanup::clean_up(tile, trace, rings, slits, polygon, out).map_err(|_| Refused::NotSimple)?;
            certified(tile, out)
        } else if rings.close(trace) {
            Ok(TrimOutcome::Certified)
        } else {
            Err(Refused::OrderOfCrossings)
        }
    }
}

/// How it went, if the boundary of the triangles and of the full cells is the loops.
///
/// Positive triangles with that boundary cover each point as often as the loops wind around it. Loops that are not simple
/// can pass everything but this, because full cells come from parities and rings from the order of crossings.
fn certified(tile: &TrimInput<'_>, out: &TrimOutput) -> Result<TrimOutcome, Refused> {
    let mut boundary = Fingerprint::default();
    out.triangles.iter().for_each(|&t| boundary.add_triangle(t));
    for &[i, j] in &out.full_cells {
        let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| tile.corner_id(i, j));
        boundary.add_triangle([a, b, c]);
        boundary.add_triangle([a, c, d]);
    }
    // Where loops touch, triangles may name another vertex in the same place.
    let closes = boundary == Fingerprint::of_loops(tile) || out.stats.clusters > 0 && close::is_closed(tile, out);
    if !closes {
        return Err(Refused::OrderOfCrossings);
    }
    Ok(if out.stats.clusters > 0 {
        TrimOutcome::Cdt
    } else if out.stats.merged_rings > 0 {
        TrimOutcome::Merged
    } else {
        TrimOutcome::Certified
    })
}

/// Why a tile could not be triangulated cell by cell.
enum Refused {
    /// Exact ownership may help.
    OrderOfCrossings,
    NotSimple,
}

/// Loops without segments of length zero, and where their points come from.
#[derive(Default)]
struct Distinct {
    points: Vec<DVec2>,
    loop_starts: Vec<u32>,
    /// Index in the input.
    original: Vec<u32>,
    /// Whether the last loops had any.
    repeats: bool,
    /// Whether points were left out that are elsewhere in space than those that stay.
    moves: bool,
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
        self.moves = false;
        if !self.repeats {
            return false;
        }
        let place = |v: u32| input.places.get(v as usize);
        let differ = |v: u32, w: u32| place(v).is_none() || place(v) != place(w);
        self.points.clear();
        self.original.clear();
        self.loop_starts.clear();
        self.loop_starts.push(0);
        for l in input.loops() {
            let start = self.points.len();
            for v in l {
                let p = points[v as usize];
                if self.points[start..].last() == Some(&p) {
                    self.moves |= self.original.last().is_some_and(|&w| differ(v, w));
                } else {
                    self.points.push(p);
                    self.original.push(v);
                }
            }
            while self.points.len() > start && self.points[start] == self.points[self.points.len() - 1] {
                self.points.pop();
                let (left_out, first) = (self.original.pop(), self.original.get(start));
                self.moves |= left_out.zip(first).is_some_and(|(v, &w)| differ(v, w));
            }
            self.loop_starts.push(self.points.len() as u32);
        }
        true
    }

    fn tile<'a>(&'a self, input: &TrimInput<'_>) -> TrimInput<'a> {
        TrimInput { cells: input.cells, points: &self.points, loop_starts: &self.loop_starts, places: &[] }
    }

    fn restore_ids(&self, input: &TrimInput<'_>, out: &mut TrimOutput) {
        let (ours, theirs) = (self.original.len() as u32, input.points.len() as u32);
        out.rename(|v| if v < ours { self.original[v as usize] } else { v - ours + theirs });
    }
}

impl TrimOutput {
    fn clear(&mut self) {
        self.triangles.clear();
        self.full_cells.clear();
        self.layers.clear();
        self.closing.clear();
        self.extra_points.clear();
        self.stats = TrimStats::default();
    }

    /// Empty, with the counts of a tile that was triangulated before.
    pub(super) fn reset(&mut self, stats: TrimStats) {
        self.clear();
        self.stats = stats;
    }

    /// Renames the corners of all triangles, of full cells not.
    pub(super) fn rename(&mut self, mut name: impl FnMut(u32) -> u32) {
        let mut all = |triangle: &mut [u32; 3]| triangle.iter_mut().for_each(|v| *v = name(*v));
        self.triangles.iter_mut().for_each(&mut all);
        self.layers.iter_mut().for_each(|(triangle, _)| all(triangle));
        self.closing.iter_mut().for_each(all);
    }

    /// Where a vertex is, in cell units.
    pub(super) fn point(&self, tile: &TrimInput<'_>, v: u32) -> DVec2 {
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
