//! What a planner's jobs look at and make while a plan is made: ranges of tiles, rates that should change, lattices and
//! tessellants for them.

use super::culling::{InstanceSight, RANGE};
use super::pages::PlanChanges;
use super::rate::{Rate, Step};
use crate::frame::plan::lattice::DensityMet;
use crate::frame::plan::output::{EdgePolyline, Plan, TileLattice};
use crate::frame::tolerance::part_camera::PixelScale;
use crate::math::bits::ones;
use crate::model::{PartId, RowId, TileId};
use smallvec::SmallVec;
use std::ops::Range;
use std::sync::Arc;

/// Off-screen, or culled.
pub(super) const UNSEEN: PixelScale = PixelScale { most: -1.0, least: -1.0 };

/// Stamp of every edge in [`Touched`].
pub(super) const TOUCHED: u8 = 1;
/// An adjacent lattice changed.
pub(super) const BESIDE_NEW: u8 = 2;

/// Edges to plan, each once however many tiles request it.
#[derive(Default)]
pub(super) struct Touched {
    /// By part and edge: 0 if not among `rows`, else [`TOUCHED`] and the reasons.
    pub(super) stamps: Vec<Vec<u8>>,
    pub(super) rows: Vec<(usize, RowId)>,
}

impl Touched {
    pub(super) fn add(&mut self, part: usize, edge: RowId, why: u8) {
        let stamp = &mut self.stamps[part][edge.index()];
        if *stamp == 0 {
            self.rows.push((part, edge));
        }
        *stamp |= TOUCHED | why;
    }

    /// Every edge and its stamp; empties the set.
    pub(super) fn take(&mut self) -> Vec<(usize, RowId, u8)> {
        let stamps = &mut self.stamps;
        self.rows.drain(..).map(|(part, e)| (part, e, std::mem::take(&mut stamps[part][e.index()]))).collect()
    }
}

/// Tiles and edges that one call of a job plans.
pub(super) const PLANNED: usize = 32;

/// What the views show of [`RANGE`] tiles of a part.
#[derive(Default)]
pub(super) struct SeenRange {
    /// Whether any of them is drawn.
    pub(super) any: bool,
    /// Those of tiles of groups that are not [`open`](Self::open) may be of an earlier frame.
    pub(super) scales: Vec<PixelScale>,
    /// Groups of which all tiles are drawn, a bit each.
    pub(super) whole: u32,
    /// Groups with drawn tiles whose rates may change, a bit each.
    pub(super) open: u32,
    /// Expected number of triangles of the drawn tiles.
    pub(super) triangles: u64,
}

/// What the views show of the tiles of a part.
#[derive(Default)]
pub(super) struct SeenTiles(pub(super) Vec<SeenRange>);

impl SeenTiles {
    /// Shows none of `tiles` tiles.
    pub(super) fn none(tiles: usize) -> Self {
        let range = |first| SeenRange { scales: vec![UNSEEN; RANGE.min(tiles - first)], ..SeenRange::default() };
        Self((0..tiles).step_by(RANGE).map(range).collect())
    }

    pub(super) fn of(&self, tile: usize) -> PixelScale {
        self.0[tile / RANGE].scales[tile % RANGE]
    }

    /// Whether any tile is drawn.
    pub(super) fn shows_any(&self) -> bool {
        self.0.iter().any(|range| range.any)
    }

    /// The ranges with groups that are open, and these.
    pub(super) fn open(&self) -> impl Iterator<Item = (usize, u32)> {
        self.0.iter().enumerate().filter(|(_, range)| range.open != 0).map(|(k, range)| (k, range.open))
    }

    /// Whether a tile is drawn.
    pub(super) fn shows(&self, tile: usize) -> bool {
        self.of(tile).most >= 0.0
    }
}

/// Visible instances, grouped by part. Only parts with at least one are listed: in a large scene most have none.
pub(super) struct Sights {
    all: Vec<InstanceSight>,
    /// Which of them are of a part, ascending by part.
    parts: Vec<(usize, Range<usize>)>,
}

impl Sights {
    /// Groups `all` by part. Skips instances of parts from `parts` on. `part_of`: the part of an instance.
    pub(super) fn of(mut all: Vec<InstanceSight>, parts: usize, part_of: impl Fn(usize) -> usize) -> Self {
        let part_of = |sight: &InstanceSight| part_of(sight.instance);
        all.retain(|sight| part_of(sight) < parts);
        // Stable: those of a part stay ascending. Each moves few times: they are large.
        all.sort_by_cached_key(part_of);
        let mut end = 0;
        let of_part = |sights: &[InstanceSight]| {
            let first = end;
            end += sights.len();
            (part_of(&sights[0]), first..end)
        };
        let parts = all.chunk_by(|a, b| part_of(a) == part_of(b)).map(of_part).collect();
        Self { all, parts }
    }

    /// Parts with a visible instance, ascending.
    pub(super) fn parts(&self) -> impl Iterator<Item = usize> {
        self.parts.iter().map(|(part, _)| *part)
    }

    /// Those of a part, ascending by (view, instance).
    pub(super) fn of_part(&self, part: usize) -> &[InstanceSight] {
        let row = self.parts.binary_search_by_key(&part, |(part, _)| *part);
        row.map_or(&[], |row| &self.all[self.parts[row].1.clone()])
    }
}

/// What the views show of a range of tiles.
pub(super) struct VisibleTiles {
    pub(super) part: usize,
    pub(super) range: usize,
    pub(super) seen: SeenRange,
    /// The sights of the part that show any of them.
    pub(super) sights: Vec<u32>,
    /// A row of [`WORDS`](super::culling::WORDS) words for each of those: a bit for each drawn tile.
    pub(super) bits: Vec<u64>,
}

/// Result of looking at tiles: what should change.
#[derive(Default)]
pub(super) struct RateChanges {
    /// In lists of up to [`PLANNED`], or in one.
    pub(super) rates: Vec<Vec<WantedRate>>,
    pub(super) near: Vec<(usize, usize)>,
    /// By part and group.
    pub(super) groups: Vec<(usize, usize, GroupBand)>,
    /// Cells that tiles would have.
    pub(super) estimates: Vec<(usize, usize, CellsAt)>,
}

impl RateChanges {
    pub(super) fn want(&mut self, rate: WantedRate) {
        if self.rates.last().is_none_or(|list| list.len() == PLANNED) {
            self.rates.push(Vec::new());
        }
        self.rates.last_mut().expect("pushed above").push(rate);
    }

    /// Puts the rates of a part into one list, ascending by tile, as a budget takes them.
    pub(super) fn sort(&mut self) {
        let mut all: Vec<_> = std::mem::take(&mut self.rates).into_iter().flatten().collect();
        all.sort_unstable_by_key(|wanted| wanted.tile);
        self.rates.extend((!all.is_empty()).then_some(all));
    }
}

/// The cells that a tile would have at a step, and at which terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CellsAt {
    pub(super) term: u32,
    pub(super) step: Step,
    pub(super) cells: f64,
}

impl CellsAt {
    /// Not known.
    pub(super) const NEVER: Self = Self { term: 0, step: None, cells: 0.0 };
}

/// Densities for which all tiles of a group keep their rates, at terms that all were planned with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GroupBand {
    pub(super) term: u32,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl GroupBand {
    /// None. Terms are counted from 1.
    pub(super) const NONE: Self = Self { term: 0, low: 0.0, high: 0.0 };

    /// All. Of a group without tiles.
    pub(super) fn all(term: u32) -> Self {
        Self { term, low: 0.0, high: f64::INFINITY }
    }
}

/// A row for two plans, so that the thread that stores it need not look at it.
pub(super) type Pair<T> = [Arc<T>; 2];

/// A [`Pair`] of a new row.
pub(super) fn pair<T>(row: T) -> Pair<T> {
    let row = Arc::new(row);
    [Arc::clone(&row), row]
}

/// A lattice for a [`WantedRate`].
pub(super) struct NewLattice {
    /// With the number of its cells. `None` if the old one holds.
    pub(super) made: Option<(u64, Pair<TileLattice>)>,
    pub(super) kept: DensityMet,
    /// Edges of the tile to plan, and why.
    pub(super) touches: SmallVec<[(RowId, u8); 6]>,
}

/// Tessellants for a touched edge, or a rate at which the old ones hold.
pub(super) struct NewTessellants {
    pub(super) rate: Rate,
    pub(super) made: Option<TessellantUpdate>,
}

pub(super) struct TessellantUpdate {
    /// `None` if the tessellants equal the old ones.
    pub(super) line: Option<Pair<EdgePolyline>>,
    /// The tiles that use a new line, each with how many more tessellants it has there.
    pub(super) tiles: SmallVec<[(TileId, i32); 4]>,
    pub(super) kept: bool,
}

/// A tile whose rate should change.
pub(super) struct WantedRate {
    /// How many steps finer it should be, and those that its priority stands for. With a budget only.
    pub(super) urgency: f64,
    /// Factor on the number of its cells. With a budget only.
    pub(super) growth: f64,
    pub(super) part: usize,
    pub(super) tile: usize,
    pub(super) rate: Rate,
    pub(super) band: (f64, f64),
    /// The chord tolerance that the views require, in the part's own millimetres.
    pub(super) chord: f64,
}

/// The plan of the current frame.
pub(super) struct PlanDraft {
    /// Has one owner between steps.
    pub(super) page: Arc<Plan>,
    pub(super) sights: Arc<Sights>,
    /// In lists, a call of a job each.
    pub(super) wanted: Vec<Vec<WantedRate>>,
    /// Drawn tiles with a step per sub-box, or next to culled ones that have it. Their edges are checked box by box in
    /// every frame.
    pub(super) near: Vec<(usize, usize)>,
    pub(super) changes: PlanChanges,
}

impl PlanDraft {
    /// A draft that begins as a copy of the last plan with a single owner.
    pub(super) fn new(page: Arc<Plan>, sights: Sights) -> Self {
        let (wanted, near, changes) = (Vec::new(), Vec::new(), PlanChanges::default());
        Self { page, sights: Arc::new(sights), wanted, near, changes }
    }

    /// Adds a list of rates, to the last one if both are short. Long ones are not copied.
    pub(super) fn want(&mut self, mut list: Vec<WantedRate>) {
        match self.wanted.last_mut() {
            Some(last) if last.len() + list.len() <= PLANNED => last.append(&mut list),
            _ => self.wanted.push(list),
        }
    }

    /// The finished plan, and what changed.
    pub(super) fn finish(self, changed: &mut ChangedRows) -> (Arc<Plan>, PlanChanges) {
        let ChangedRows { tiles, edges } = changed;
        (self.page, PlanChanges { tiles: tiles.take(TileId::new), edges: edges.take(RowId::new), ..self.changes })
    }
}

/// What a frame changes. Empty between frames.
#[derive(Default)]
pub(super) struct ChangedRows {
    pub(super) tiles: RowSet,
    pub(super) edges: RowSet,
}

/// Tiles or edges of parts, as bits: a tile is added for each of its edges, and nothing has to be sorted.
#[derive(Default)]
pub(super) struct RowSet {
    /// By part, a bit for each row.
    words: Vec<Vec<u64>>,
    /// Parts that have any.
    parts: Vec<usize>,
}

impl RowSet {
    pub(super) fn add(&mut self, part: usize, row: usize) {
        if self.words.len() <= part {
            self.words.resize(part + 1, Vec::new());
        }
        let words = &mut self.words[part];
        if words.len() <= row / 64 {
            words.resize(row / 64 + 1, 0);
        }
        words[row / 64] |= 1 << (row % 64);
        if self.parts.last() != Some(&part) {
            self.parts.push(part);
        }
    }

    /// All rows by part and `id`, ascending; empties the set.
    fn take<T>(&mut self, id: fn(usize) -> T) -> Vec<(PartId, T)> {
        self.parts.sort_unstable();
        self.parts.dedup();
        let mut rows = Vec::new();
        for part in self.parts.drain(..) {
            for (k, word) in self.words[part].iter_mut().enumerate() {
                rows.extend(ones(std::mem::take(word)).map(|bit| (PartId::new(part), id(64 * k + bit))));
            }
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;
    use std::collections::BTreeSet;

    #[test]
    fn rows_are_taken_once_and_ascending() {
        let (mut draw, mut set) = (SplitMix(3), RowSet::default());
        for count in [0, 1, 5, 300] {
            let mut pick = |most: u64| usize::try_from(draw.below(most)).expect("small");
            let rows: Vec<_> = (0..count).map(|_| (pick(4), pick(200))).collect();
            rows.iter().for_each(|&(part, row)| set.add(part, row));
            let distinct: BTreeSet<_> = rows.into_iter().collect();
            let expected = distinct.into_iter().map(|(part, row)| (PartId::new(part), TileId::new(row)));
            assert!(set.take(TileId::new).into_iter().eq(expected), "{count}");
        }
    }
}
