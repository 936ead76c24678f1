//! Consecutive plans -> their differences, and a buffer that holds two of them.

use crate::control::{Jobs, chunks, drop_later, map};
use crate::frame::plan::output::{EdgePolyline, PartPlan, Plan, TileLattice, free_later};
use crate::frame::plan::rows::PlanRows;
use crate::model::{PartId, RowId, TileId};
use std::mem::replace;
use std::sync::Arc;

/// Differences between two consecutive plans of a planner.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct PlanChanges {
    /// Tiles to rebuild: their lattice or the tessellants of one of their edges changed. Ascending.
    pub tiles: Vec<(PartId, TileId)>,
    /// Edges whose tessellants changed, as rows of `PreparedPart::edges`. Ascending.
    pub edges: Vec<(PartId, RowId)>,
    /// Parts that have a plan for the first time, because a view shows them. Ascending.
    pub parts: Vec<PartId>,
    /// Number of tiles whose change of level waits because the budget was spent.
    pub deferred: u32,
}

/// The rows of `old` that `from` names, at the places that name them, and new ones at the others.
pub(super) fn renewed<T: Default>(mut old: Vec<T>, from: &[Option<PartId>]) -> Vec<T> {
    from.iter().map(|from| from.map_or_else(T::default, |from| std::mem::take(&mut old[from.index()]))).collect()
}

/// Rows that took the place of others, by part and row, in the order in which they did.
#[derive(Default)]
pub(super) struct NewRows {
    pub(super) lattices: Vec<(usize, usize, Replaced<TileLattice>)>,
    pub(super) edges: Vec<(usize, usize, Replaced<EdgePolyline>)>,
}

/// Rows that a call frees.
const FREED: usize = 64;

/// A new row and the old one, which a frame's thread keeps instead of freeing it: [`PlanPages::next`] does so on all.
type Replaced<T> = [Arc<T>; 2];

/// Copies of the rows of some parts, which share them, made by all threads: each row is elsewhere in memory, and one
/// more owner takes a miss of the caches.
fn copies<T: Send + Sync + 'static>(
    jobs: &dyn Jobs,
    plan: &Arc<Plan>,
    parts: &[PartId],
    rows: fn(&PartPlan) -> &PlanRows<T>,
) -> Vec<PlanRows<T>> {
    /// Blocks that a call copies.
    const COPIED: usize = 8;
    let of_part = |(k, part): (usize, &PartId)| {
        let (part, blocks) = (part.index(), rows(&plan.parts[part.index()]).blocks().len());
        (0..blocks).step_by(COPIED).map(move |from| (k, part, from..blocks.min(from + COPIED)))
    };
    let mut copies: Vec<_> =
        parts.iter().map(|part| PlanRows::with_room(rows(&plan.parts[part.index()]).len())).collect();
    let pieces = parts.iter().enumerate().flat_map(of_part).collect();
    let shared = Arc::clone(plan);
    let made = map(jobs, pieces, move |(k, part, blocks)| (k, rows(&shared.parts[part]).blocks()[blocks].to_vec()));
    for (k, blocks) in made {
        blocks.into_iter().for_each(|block| copies[k].push_block(block));
    }
    copies
}

/// Rows in the reverse order, the old for the new ones. Those of parts without a plan are freed after this returns.
fn reversed<T: Send + Sync + 'static>(
    jobs: &dyn Jobs,
    rows: Vec<(usize, usize, Replaced<T>)>,
    has_plan: impl Fn(usize) -> bool,
) -> Vec<(usize, usize, Replaced<T>)> {
    let (kept, gone): (Vec<_>, Vec<_>) = rows.into_iter().rev().partition(|(part, ..)| has_plan(*part));
    drop_later(jobs, gone);
    kept.into_iter().map(|(part, row, [new, old])| (part, row, [old, new])).collect()
}

/// Double-buffered plans. The older one is updated and reused, so that a frame costs as much as it changes.
#[derive(Default)]
pub(super) struct PlanPages {
    pub(super) last: Arc<Plan>,
    pub(super) spare: Option<Arc<Plan>>,
    /// Differences between the two: parts that are new, and rows.
    pub(super) parts: Vec<PartId>,
    pub(super) new: NewRows,
}

impl PlanPages {
    /// A copy of the last plan with a single owner. Reuses the spare one unless someone still holds it, as they do
    /// after a cancelled frame.
    pub(super) fn next(&mut self, jobs: &dyn Jobs) -> Arc<Plan> {
        let NewRows { lattices, edges } = std::mem::take(&mut self.new);
        let mut spare = self.spare.take();
        let copy = |parts: &[PartId]| {
            let tiles = copies(jobs, &self.last, parts, |part| &part.tiles);
            let lines = copies(jobs, &self.last, parts, |part| &part.edges);
            tiles.into_iter().zip(lines).map(|(tiles, edges)| PartPlan { tiles, edges }).collect::<Vec<_>>()
        };
        let Some(page) = spare.as_mut().and_then(Arc::get_mut) else {
            let all: Vec<PartId> = (0..self.last.parts.len()).map(PartId::new).collect();
            let Plan { drawn, shortfall, made, .. } = &*self.last;
            let (parts, drawn, shortfall) = (copy(&all), drawn.clone(), shortfall.clone());
            return Arc::new(Plan { parts, drawn, shortfall, made: *made });
        };
        for (part, copy) in self.parts.iter().zip(copy(&self.parts)) {
            page.parts[part.index()] = copy;
        }
        let replaced =
            lattices.into_iter().map(|(p, row, [new, old])| [replace(&mut page.parts[p].tiles[row], new), old]);
        let tiles = chunks(jobs, replaced.collect(), FREED).into_iter().map(|rows| (rows, Vec::new()));
        let replaced = edges.into_iter().map(|(p, row, [new, old])| [replace(&mut page.parts[p].edges[row], new), old]);
        let edges = chunks(jobs, replaced.collect(), FREED).into_iter().map(|rows| (Vec::new(), rows));
        // On all threads: each row is elsewhere in memory, and to free it takes a miss of the caches.
        map(jobs, tiles.chain(edges).collect(), drop);
        spare.unwrap_or_default()
    }

    /// Goes on with other parts: those of the last plan that `from` names, at the rows that name them. The others have
    /// no plan yet.
    pub(super) fn update(&mut self, from: &[Option<PartId>]) {
        let last = Arc::make_mut(&mut self.last);
        last.parts = renewed(std::mem::take(&mut last.parts), from);
        self.spare = None;
    }

    pub(super) fn turn(&mut self, next: Arc<Plan>, changes: &PlanChanges) {
        self.parts.clone_from(&changes.parts);
        self.spare = Some(replace(&mut self.last, next));
    }

    /// Undoes the last [`turn`](Self::turn). Returns the page that it made the last one.
    pub(super) fn turn_back(&mut self) -> Arc<Plan> {
        let before = self.spare.take().expect("the page before");
        replace(&mut self.last, before)
    }

    /// Makes `page` the spare one. It differs from the last one by the new rows, and has a plan for each of these
    /// parts.
    pub(super) fn take_back(&mut self, jobs: &dyn Jobs, parts: &[PartId], mut page: Arc<Plan>) {
        let NewRows { lattices, edges } = std::mem::take(&mut self.new);
        let has_plan = |part: usize| !self.last.parts[part].tiles.is_empty();
        self.new = NewRows { lattices: reversed(jobs, lattices, has_plan), edges: reversed(jobs, edges, has_plan) };
        self.parts = parts.to_vec();
        // Whoever still holds the page frees it.
        if let (Some(page), false) = (Arc::get_mut(&mut page), parts.is_empty()) {
            free_later(jobs, parts.iter().map(|part| std::mem::take(&mut page.parts[part.index()])).collect());
        }
        self.spare = Some(page);
    }
}
