//! What a plan replaces in the state of a planner -> that state again, if nobody commits the frame.

use super::draft::{CellsAt, WantedRate};
use super::limited::{Limited, mark};
use super::rate::{Rate, Terms};
use super::rates::{PartRates, Rates};
use crate::frame::plan::lattice::DensityMet;
use crate::model::{PartId, RowId, TileId};
use crate::view::View;
use smallvec::SmallVec;
use std::mem::replace;

/// A row as it was before a plan changed it.
enum RowBefore {
    Tile {
        id: (PartId, TileId),
        term: u32,
        /// Whether limits made its cells and its lines coarser.
        limited: [bool; 2],
        rate: Rate,
        band: (f64, f64),
    },
    Edge {
        id: (PartId, RowId),
        rate: Rate,
        /// If its tessellants were planned: its term, and whether limits made it coarser.
        planned: Option<(u32, bool)>,
    },
    Estimate(PartId, TileId, CellsAt),
}

/// State of a plan as a whole.
pub(super) struct Whole {
    pub(super) terms: Terms,
    pub(super) term: u32,
    pub(super) seen: SmallVec<[View; 2]>,
    pub(super) placed: u64,
    pub(super) unfinished: bool,
    pub(super) growth: f64,
    /// Whether the plan was made to its end.
    pub(super) has_turned: bool,
}

/// What the last plan replaced, as long as it may be taken back.
#[derive(Default)]
pub(super) struct Undo {
    pub(super) whole: Option<Whole>,
    /// In the order in which they changed.
    rows: Vec<RowBefore>,
}

impl Undo {
    /// Sets the rate of a tile. `kept`: the limits that it met.
    pub(super) fn set_tile(
        &mut self,
        (rates, limited): (&mut PartRates, &mut Limited),
        (wanted, term): (WantedRate, u32),
        kept: DensityMet,
    ) {
        let (id, t) = ((PartId::new(wanted.part), TileId(wanted.tile as u32)), wanted.tile);
        let before = RowBefore::Tile {
            id,
            term: replace(&mut rates.tile_terms[t], term),
            limited: [mark(&mut limited.tiles, id, !kept.cells), mark(&mut limited.lines, id, !kept.lines)],
            rate: replace(&mut rates.tiles[t], wanted.rate),
            band: replace(&mut rates.bands[t], wanted.band),
        };
        self.note(rates, before);
    }

    /// Sets the rate of an edge. `planned`, if its tessellants were: its term, and whether it met the limits.
    pub(super) fn set_edge(
        &mut self,
        (rates, limited): (&mut PartRates, &mut Limited),
        (id, rate): ((PartId, RowId), Rate),
        planned: Option<(u32, bool)>,
    ) {
        let k = id.1.index();
        let planned =
            planned.map(|(term, kept)| (replace(&mut rates.edge_terms[k], term), mark(&mut limited.edges, id, !kept)));
        let before = RowBefore::Edge { id, rate: replace(&mut rates.edges[k], rate), planned };
        self.note(rates, before);
    }

    /// Sets the cells that a tile would have.
    pub(super) fn set_estimate(&mut self, rates: &mut PartRates, (part, tile): (usize, usize), cells: CellsAt) {
        let before = replace(&mut rates.estimates[tile], cells);
        self.note(rates, RowBefore::Estimate(PartId::new(part), TileId(tile as u32), before));
    }

    /// Notes a row of a part, unless all of the part goes if the plan is taken back.
    fn note(&mut self, rates: &PartRates, before: RowBefore) {
        if !rates.is_new {
            self.rows.push(before);
        }
    }

    /// Keeps what the last plan set.
    pub(super) fn keep(&mut self) {
        /// Rows to keep room for: more than a frame of a moving camera changes.
        const ROOM: usize = 4096;
        self.whole = None;
        self.rows.clear();
        self.rows.shrink_to(ROOM);
    }

    /// Sets all rows as they were.
    pub(super) fn revert(&mut self, rates: &mut Rates, limited: &mut Limited) {
        while let Some(row) = self.rows.pop() {
            match row {
                RowBefore::Tile { id, term, limited: [cells, lines], rate, band } => {
                    mark(&mut limited.tiles, id, cells);
                    mark(&mut limited.lines, id, lines);
                    let (of, t) = (&mut rates.parts[id.0.index()], id.1.index());
                    (of.tile_terms[t], of.tiles[t], of.bands[t]) = (term, rate, band);
                }
                RowBefore::Edge { id, rate, planned } => {
                    let (of, k) = (&mut rates.parts[id.0.index()], id.1.index());
                    of.edges[k] = rate;
                    if let Some((term, was_limited)) = planned {
                        mark(&mut limited.edges, id, was_limited);
                        of.edge_terms[k] = term;
                    }
                }
                RowBefore::Estimate(part, tile, cells) => rates.parts[part.index()].estimates[tile.index()] = cells,
            }
        }
    }
}
