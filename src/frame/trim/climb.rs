//! The loops of one tile -> triangles, by the first rung of the ladder that succeeds.

use super::chain::Fingerprint;
use super::distinct::{Distinct, by_distinct};
use super::input::{CORNER_CLEARANCE, TrimInput, TrimInputError};
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
        let Self { trace, rings, polygon } = self;
        if tile.cells == (1, 1) {
            trace.run_in_one_cell(tile);
            rings.clear();
            if !trace.in_cell_loops.is_empty() && polygon.triangulate_tile(tile, &mut out.triangles) {
                return TrimOutcome::Certified;
            }
        }
        for reach in [CORNER_CLEARANCE, 0.0] {
            out.clear();
            out.stats.retraced = reach == 0.0;
            match self.by_cells(tile, reach, out) {
                Ok(outcome) => return outcome,
                // Without crossings there is nothing to trace again.
                Err(Refusal::OrderOfCrossings) if tile.cells != (1, 1) => {}
                Err(_) => break,
            }
        }
        out.stats.whole_tile = true;
        reference::triangulate_tile(tile, out)
    }

    fn by_cells(&mut self, tile: &TrimInput<'_>, reach: f64, out: &mut TrimOutput) -> Result<TrimOutcome, Refusal> {
        self.trace.reset(tile, reach);
        self.trace.run(tile);
        let Self { trace, rings, polygon } = self;
        out.stats.crossings = trace.crossings.len() as u32;
        // No certificate is needed: the boundary of the triangles of all loops is the loops. A tile of one cell was
        // tried.
        if tile.cells != (1, 1) && rings.build_one_cell(tile, trace, polygon, out) {
            return Ok(TrimOutcome::Certified);
        }
        rings.build(tile, trace, polygon, out).map_err(|_| Refusal::OrderOfCrossings)?;
        out.stats.failed_rings = rings.failed;
        if rings.failed > 0 || !trace.in_cell_loops.is_empty() {
            cleanup::clean_up(tile, trace, rings, polygon, out).ok_or(Refusal::NotSimple)?;
            certified(tile, out)
        } else if rings.is_closed(trace) {
            Ok(TrimOutcome::Certified)
        } else {
            Err(Refusal::OrderOfCrossings)
        }
    }
}

/// Returns the outcome if the boundary of the triangles and of the full cells is the loops.
///
/// Positive triangles with that boundary cover each point as often as the loops wind around it. Loops that are not
/// simple can pass everything but this, because full cells come from parities and rings from the order of crossings.
fn certified(tile: &TrimInput<'_>, out: &TrimOutput) -> Result<TrimOutcome, Refusal> {
    let mut boundary = Fingerprint::default();
    out.triangles.iter().for_each(|&t| boundary.add_triangle(t));
    for &cell in &out.full_cells {
        let [a, b, c, d] = tile.cell_corners(cell);
        boundary.add_triangle([a, b, c]);
        boundary.add_triangle([a, c, d]);
    }
    // Where loops touch, triangles may use another vertex at the same place.
    let closes = boundary == Fingerprint::of_loops(tile) || out.stats.clusters > 0 && close::is_closed(tile, out);
    if !closes {
        return Err(Refusal::OrderOfCrossings);
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
enum Refusal {
    /// Tracing again with exact ownership of tessellants may help.
    OrderOfCrossings,
    NotSimple,
}
