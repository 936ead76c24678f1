//! The loops of one tile -> triangles, by the first rung of the ladder that succeeds.

use super::distinct::{Distinct, by_distinct};
use super::input::{TrimInput, TrimInputError};
use super::output::{TrimOutcome, TrimOutput};
use super::{cleanup, close, reference, rings, trace, triangulate};

/// Reusable buffers of [`trim_tile`]. Results do not depend on earlier calls.
#[derive(Default)]
pub struct TrimScratch {
    pub(crate) ladder: Rungs,
    pub(crate) distinct: Distinct,
}

/// Buffers of the rungs that work cell by cell.
#[derive(Default)]
pub(crate) struct Rungs {
    pub(crate) trace: trace::Trace,
    pub(crate) rings: rings::Rings,
    pub(crate) polygon: triangulate::Polygon,
}

/// Triangulates the trimmed part of one tile.
///
/// Overwrites `out`, which is empty on an error. Deterministic: the output depends on the input alone, not on
/// `scratch`.
///
/// # Errors
/// Input outside the contract of [`TrimInput`]. Loops that cross are repaired, not refused.
pub fn trim_tile(
    input: &TrimInput<'_>,
    scratch: &mut TrimScratch,
    out: &mut TrimOutput,
) -> Result<TrimOutcome, TrimInputError> {
    let TrimScratch { ladder, distinct } = scratch;
    by_distinct(input, distinct, out, |tile, out| ladder.climb(tile, out))
}

/// Fills the loops without triangulating what they wind around. It needs no valid cell coordinates, and so works where
/// every rung fails. Overwrites `out`.
pub(crate) fn fill_loops(input: &TrimInput<'_>, out: &mut TrimOutput) {
    out.clear();
    close::close(input, out);
    out.stats.outcome = TrimOutcome::Repaired { split: 0 };
}

impl Rungs {
    /// Triangulates loops without segments of length zero, by the first rung that succeeds.
    fn climb(&mut self, tile: &TrimInput<'_>, out: &mut TrimOutput) -> TrimOutcome {
        let by_cells = if tile.cells == (1, 1) { self.in_one_cell(tile, out) } else { self.by_cells(tile, out) };
        by_cells.unwrap_or_else(|| {
            out.stats.whole_tile = true;
            reference::triangulate_tile(tile, out)
        })
    }

    /// A tile of one cell. `None` if its loops are not simple.
    fn in_one_cell(&mut self, tile: &TrimInput<'_>, out: &mut TrimOutput) -> Option<TrimOutcome> {
        self.trace.run_in_one_cell(tile);
        self.rings.clear();
        // No certificate is needed: the boundary of the triangles of all loops is the loops.
        let is_done = self.trace.in_cell_loops.is_empty() || self.polygon.triangulate_tile(tile, &mut out.triangles);
        is_done.then_some(TrimOutcome::Certified)
    }

    /// `None` if the tile cannot be triangulated cell by cell.
    fn by_cells(&mut self, tile: &TrimInput<'_>, out: &mut TrimOutput) -> Option<TrimOutcome> {
        self.trace.reset(tile);
        self.trace.run(tile);
        let Self { trace, rings, polygon } = self;
        rings.build(tile, trace, polygon, out)?;
        out.stats.failed_rings = rings.failed;
        if !rings.is_closed(trace) {
            return None;
        }
        if rings.failed == 0 && trace.in_cell_loops.is_empty() {
            return Some(TrimOutcome::Certified);
        }
        cleanup::clean_up(tile, trace, rings, polygon, out)
    }
}
