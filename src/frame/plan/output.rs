//! The plan of a frame: lattice lines per tile, tessellants per edge. It is the only state that both sides of an edge
//! share.

use super::limits::Shortfall;
use super::rows::PlanRows;
use crate::control::{Jobs, drop_later, map, width};
use crate::mesh::DrawnTiles;
use crate::prepare::internals::PreparedPart;
use smallvec::SmallVec;

/// Maximum number of lines of one tile in one direction between two creases, and of segments of an edge between two
/// breaks. Tiles are cut so that real tolerances need tens: more only follow noise in derivatives.
pub(crate) const MAX_LINES: usize = 4096;
/// The same at tolerances at which a circle as large as the part needs half of [`MAX_LINES`]; in tiles of splines, only
/// if the length of edges needs them. Also the maximum number of lines of one tile in one direction, over all stretches
/// between creases.
pub(crate) const LINES_OF_TILE: usize = 32768;

/// [`MAX_LINES`] or [`LINES_OF_TILE`], whichever holds where a circle as large as the part needs so many lines.
pub(crate) fn most_lines(around: f64) -> usize {
    if around < 0.5 * MAX_LINES as f64 { MAX_LINES } else { LINES_OF_TILE }
}

/// Lattice lines of one tile, in the parameters of its face's patches; first and last are the tile's border.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TileLattice {
    /// u-lines, strictly increasing.
    pub us: SmallVec<[f64; 2]>,
    /// v-lines, strictly increasing.
    pub vs: SmallVec<[f64; 2]>,
    /// The strictest chord tolerance anywhere in the tile, in the part's own millimetres.
    pub chord: f64,
    /// The loosest one; infinite where a part of the tile is behind every camera.
    pub loosest: f64,
}

impl TileLattice {
    /// Number of cells in u and in v.
    #[must_use]
    pub fn cells(&self) -> (u32, u32) {
        let count = |lines: &[f64]| u32::try_from(lines.len().saturating_sub(1)).unwrap_or(u32::MAX);
        (count(&self.us), count(&self.vs))
    }
}

/// Whether all gaps between lines are as long, up to rounding.
pub(crate) fn is_even(lines: &[f64]) -> bool {
    /// Share of the way from the first to the last line.
    const ROUNDING: f64 = 1e-9;
    let last = lines.len() - 1;
    let (from, width) = (lines[0], lines[last] - lines[0]);
    let gap = width / last as f64;
    (1..).zip(&lines[1..last]).all(|(k, line)| (line - from - gap * f64::from(k)).abs() <= ROUNDING * width)
}

/// Converts a parameter to cells: the integer part is the index of the line below, the fraction is linear to the next
/// line. Clamped to the range of `lines`.
#[must_use]
pub fn cell_coordinate(lines: &[f64], x: f64) -> f64 {
    let last = lines.len() - 1;
    if x <= lines[0] {
        return 0.0;
    }
    if x >= lines[last] {
        return last as f64;
    }
    let k = lines.partition_point(|&l| l <= x) - 1;
    k as f64 + (x - lines[k]) / (lines[k + 1] - lines[k])
}

/// [`cell_coordinate`] of parameters that are near the ones before: walks along the lines instead of searching.
pub(crate) struct CellWalk<'a> {
    lines: &'a [f64],
    /// The line below the last parameter, as a row and as a coordinate, and the parameters of that line and the next.
    at: usize,
    below: f64,
    ends: [f64; 2],
    /// The first line, and the width from there to the last.
    first: f64,
    width: f64,
}

impl<'a> CellWalk<'a> {
    pub(crate) fn new(lines: &'a [f64]) -> Self {
        Self::from_line(lines, 0)
    }

    /// Starts near the parameter at `share` of the way from the first to the last line.
    pub(crate) fn from_share(lines: &'a [f64], share: f32) -> Self {
        Self::from_line(lines, ((f64::from(share) * (lines.len() - 1) as f64) as usize).min(lines.len() - 2))
    }

    fn from_line(lines: &'a [f64], at: usize) -> Self {
        let (ends, first) = ([lines[at], lines[at + 1]], lines[0]);
        Self { lines, at, below: f64::from(at as u32), ends, first, width: lines[lines.len() - 1] - first }
    }

    /// Returns the same number as [`cell_coordinate`].
    #[inline(always)]
    pub(crate) fn cell(&mut self, x: f64) -> f64 {
        let Self { lines, at, below, ends, .. } = self;
        if !(ends[0] <= x && x < ends[1]) {
            let last = lines.len() - 1;
            if x <= lines[0] {
                return 0.0;
            }
            if x >= lines[last] {
                return last as f64;
            }
            // At most one of the loops runs. NaN runs neither.
            while x >= ends[1] {
                *at += 1;
                *below += 1.0;
                *ends = [ends[1], lines[*at + 1]];
            }
            while x < ends[0] {
                *at -= 1;
                *below -= 1.0;
                *ends = [lines[*at], ends[0]];
            }
        }
        *below + (x - ends[0]) / (ends[1] - ends[0])
    }

    /// [`Self::cell`] of the parameter at `share` of the way from the first to the last line.
    #[inline(always)]
    pub(crate) fn at_share(&mut self, share: f64) -> f64 {
        self.cell(self.first + share * self.width)
    }
}

/// Tessellants of one edge.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EdgePolyline {
    /// Parameters, strictly increasing; contains all breaks.
    pub ts: SmallVec<[f64; 2]>,
    /// Index of each break in `ts`.
    pub breaks: SmallVec<[u32; 4]>,
}

/// The plan of one part. A [`Planner`](crate::frame::live::planner::Planner) leaves those of parts empty that no view
/// has shown.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PartPlan {
    /// One per tile.
    pub tiles: PlanRows<TileLattice>,
    /// One per prepared edge (empty for edges that no tile uses).
    pub edges: PlanRows<EdgePolyline>,
}

impl PartPlan {
    /// Whether it has the rows of this part.
    pub(crate) fn is_of(&self, part: &PreparedPart) -> bool {
        (self.tiles.len(), self.edges.len()) == (part.tiles.len(), part.edges.len())
    }

    /// Number of blocks of its rows.
    fn blocks(&self) -> usize {
        self.tiles.blocks().len() + self.edges.blocks().len()
    }

    /// Takes the last `blocks` blocks; it has as many.
    fn take_last(&mut self, blocks: usize) -> Self {
        let edges = self.edges.take_last(blocks);
        let tiles = self.tiles.take_last(blocks - edges.blocks().len());
        Self { tiles, edges }
    }
}

/// Frees plans on all threads: each has an allocation per tile and per edge.
pub(crate) fn free(jobs: &dyn Jobs, plans: Vec<PartPlan>) {
    /// Pieces per thread.
    const SHARE: usize = 2;
    let _span = tracing::trace_span!("free").entered();
    let blocks: usize = plans.iter().map(PartPlan::blocks).sum();
    let size = FEWEST.max(blocks.div_ceil(SHARE * width(jobs)));
    map(jobs, in_pieces(plans, size), drop);
}

/// As [`free`], after this returns.
pub(crate) fn free_later(jobs: &dyn Jobs, plans: Vec<PartPlan>) {
    drop_later(jobs, in_pieces(plans, FEWEST));
}

/// Fewest blocks of rows of a piece.
const FEWEST: usize = 16;

/// Plans in pieces of so many blocks, which take about as long to free. The last one may have fewer.
fn in_pieces(plans: Vec<PartPlan>, size: usize) -> Vec<Vec<PartPlan>> {
    let (mut pieces, mut piece, mut room) = (Vec::new(), Vec::new(), size);
    for mut plan in plans {
        let mut blocks = plan.blocks();
        while blocks >= room {
            piece.push(plan.take_last(room));
            pieces.push(std::mem::take(&mut piece));
            (blocks, room) = (blocks - room, size);
        }
        piece.push(plan);
        room -= blocks;
    }
    pieces.push(piece);
    pieces
}

/// The plan of a frame: everything that workers receive.
///
/// With `serde`, a plan can be stored and meshed again elsewhere, bit for bit
/// ([`Session::frame`](crate::parallel::Session::frame), which checks one that was read). The format must store `f64`
/// exactly, with infinity: CBOR and the like, not JSON.
///
/// Provisional: it changes together with [`Session`](crate::parallel::Session).
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Plan {
    /// One per part.
    #[doc(hidden)]
    pub parts: Vec<PartPlan>,
    /// The tiles that frames of views draw. [`DrawnTiles::default`] in other plans, which draw everything.
    pub drawn: DrawnTiles,
    /// What is coarser than the tolerance requires; `None` if nothing is.
    pub shortfall: Option<Shortfall>,
    /// Whether the planner made the rows, and nobody stored and read them since.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) made: Made,
}

/// Plans with the same rows are equal, whoever made them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Made(pub(crate) bool);

impl PartialEq for Made {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Plan {
    /// Returns the plan, unless limits made it coarser than the tolerance requires.
    ///
    /// # Errors
    /// [`Plan::shortfall`], if it is caused [by limits](Shortfall::by_limits).
    pub fn require_full(self) -> Result<Self, Shortfall> {
        match self.shortfall {
            Some(shortfall) if shortfall.by_limits() => Err(shortfall),
            shortfall => Ok(Self { shortfall, ..self }),
        }
    }
}

/// Number of cells of a lattice.
pub(crate) fn cells(lattice: &TileLattice) -> u64 {
    let (nu, nv) = lattice.cells();
    u64::from(nu) * u64::from(nv)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn pieces_have_all_rows_and_as_many_blocks() {
        let lattice = || Arc::new(TileLattice { us: SmallVec::new(), vs: SmallVec::new(), chord: 1.0, loosest: 1.0 });
        let line = || Arc::new(EdgePolyline { ts: SmallVec::new(), breaks: SmallVec::new() });
        let rows = [(0_usize, 0_usize), (1, 0), (0, 65), (200, 500), (64, 64), (0, 0), (1, 1)];
        for count in 0..=rows.len() {
            let part = |&(tiles, edges): &(usize, usize)| PartPlan {
                tiles: (0..tiles).map(|_| lattice()).collect(),
                edges: (0..edges).map(|_| line()).collect(),
            };
            let parts: Vec<PartPlan> = rows[..count].iter().map(part).collect();
            let blocks: usize = parts.iter().map(PartPlan::blocks).sum();
            for size in [1, 2, 5, 100] {
                let pieces = in_pieces(parts.clone(), size);
                let of_pieces = pieces.iter().map(|piece| piece.iter().map(PartPlan::blocks).sum::<usize>());
                let sizes: Vec<usize> = of_pieces.collect();
                assert_eq!(sizes.iter().sum::<usize>(), blocks);
                let (last, full) = sizes.split_last().expect("at least one piece");
                assert!(*last <= size && full.iter().all(|blocks| *blocks == size), "{size}: {sizes:?}");
                let sum = |of: fn(&PartPlan) -> usize| pieces.iter().flatten().map(of).sum::<usize>();
                assert_eq!(sum(|part| part.tiles.len()), rows[..count].iter().map(|(tiles, _)| tiles).sum::<usize>());
                assert_eq!(sum(|part| part.edges.len()), rows[..count].iter().map(|(_, edges)| edges).sum::<usize>());
            }
        }
    }
}
