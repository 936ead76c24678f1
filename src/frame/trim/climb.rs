//! The loops of one tile -> triangles, by the first rung of the ladder that holds.

use super::chain::Fingerprint;
use super::distinct::{Distinct, by_distinct};
use super::input::{CORNER_CLEARANCE, TrimInput, TrimInputError};
use super::output::{TrimOutcome, TrimOutput};
use super::{cleanup, close, reference, rings, slits, trace, triangulate};

/// Work space of [`trim_tile`]; holds capacity only, no result depends on what it was used for before.
#[derive(Default)]
pub struct TrimScratch {
    pub(crate) ladder: Rungs,
    pub(crate) distinct: Distinct,
}

/// Work space of the rungs that work cell by cell.
#[derive(Default)]
pub(crate) struct Rungs {
    pub(crate) trace: trace::Trace,
    pub(crate) rings: rings::Rings,
    pub(crate) slits: slits::Slits,
    pub(crate) polygon: triangulate::EarPolygon,
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
) -> Result<TrimOutcome, TrimInputError> {
    let TrimScratch { ladder, distinct } = scratch;
    by_distinct(input, distinct, out, |tile, out| ladder.climb(tile, out))
}

/// Fills the loops without triangulating what they wind around: for tiles that no rung can work on, since it looks at places
/// alone. `out` is overwritten.
pub(crate) fn fill_loops(input: &TrimInput<'_>, out: &mut TrimOutput) {
    out.clear();
    close::close(input, out);
    out.stats.outcome = TrimOutcome::Repaired { split: 0 };
}

impl Rungs {
    /// Loops without segments of length zero -> triangles, by the first rung that holds.
    fn climb(&mut self, tile: &TrimInput<'_>, out: &mut TrimOutput) -> TrimOutcome {
        for reach in [CORNER_CLEARANCE, 0.0] {
            out.clear();
            out.stats.retraced = reach == 0.0;
            match self.by_cells(tile, reach, out) {
                Ok(outcome) => return outcome,
                Err(Refusal::OrderOfCrossings) => {}
                Err(Refusal::NotSimple) => break,
            }
        }
        out.stats.whole_tile = true;
        reference::triangulate_tile(tile, out)
    }

    fn by_cells(&mut self, tile: &TrimInput<'_>, reach: f64, out: &mut TrimOutput) -> Result<TrimOutcome, Refusal> {
        self.trace.reset(tile, reach);
        self.trace.run(tile, |_, _| None);
        self.by_traced_cells(tile, out)
    }

    /// The same where the loops were traced.
    pub(crate) fn by_traced_cells(
        &mut self,
        tile: &TrimInput<'_>,
        out: &mut TrimOutput,
    ) -> Result<TrimOutcome, Refusal> {
        let Self { trace, rings, slits, polygon, .. } = self;
        out.stats.crossings = trace.crossings.len() as u32;
        // A slit polygon and its triangles have the loops as their boundary.
        if rings.build_one_cell(tile, trace, slits, polygon, out) {
            return Ok(TrimOutcome::Certified);
        }
        rings.build(tile, trace, polygon, out, |_| false).map_err(|_| Refusal::OrderOfCrossings)?;
        out.stats.rings = rings.rings.len() as u32;
        out.stats.failed_rings = rings.failed;
        if rings.failed > 0 || !trace.in_cell_loops.is_empty() {
            cleanup::clean_up(tile, trace, rings, slits, polygon, out).map_err(|_| Refusal::NotSimple)?;
            certified(tile, out)
        } else if rings.close(trace) {
            Ok(TrimOutcome::Certified)
        } else {
            Err(Refusal::OrderOfCrossings)
        }
    }
}

/// How it went, if the boundary of the triangles and of the full cells is the loops.
///
/// Positive triangles with that boundary cover each point as often as the loops wind around it. Loops that are not simple
/// can pass everything but this, because full cells come from parities and rings from the order of crossings.
pub(crate) fn certified(tile: &TrimInput<'_>, out: &TrimOutput) -> Result<TrimOutcome, Refusal> {
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
pub(crate) enum Refusal {
    /// Exact ownership may help.
    OrderOfCrossings,
    NotSimple,
}
