//! Consecutive plans -> their differences, and a buffer that holds two of them.

use crate::frame::plan::output::Plan;
use crate::model::{PartId, RowId, TileId};
use std::sync::Arc;

/// Differences between two consecutive plans of a planner.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct PlanChanges {
    /// Tiles to rebuild: their lattice or the tessellants of one of their edges changed. Ascending.
    pub tiles: Vec<(PartId, TileId)>,
    /// Edges whose tessellants changed, as rows of `PreparedPart::edges`. Ascending.
    pub edges: Vec<(PartId, RowId)>,
    /// Tiles whose lattice changed, a subset of `tiles`. Ascending.
    pub lattices: Vec<(PartId, TileId)>,
    /// Number of tiles whose change of level waits because the budget was spent.
    pub deferred: u32,
}

/// The rows of `old` that `from` names, at the places that name them, and those of `new` at the others, in order.
pub(super) fn renewed<T>(old: Vec<T>, from: &[Option<PartId>], new: Vec<T>) -> Vec<T> {
    let mut old: Vec<Option<T>> = old.into_iter().map(Some).collect();
    let mut new = new.into_iter();
    let mut row = |from: &Option<PartId>| from.map_or_else(|| new.next(), |from| old[from.index()].take());
    from.iter().map(|part| row(part).expect("a row for each part, and none named twice")).collect()
}

/// Double-buffered plans. The older one is updated and reused, so that a frame costs as much as it changes.
#[derive(Default)]
pub(super) struct PlanPages {
    pub(super) last: Arc<Plan>,
    pub(super) spare: Option<Arc<Plan>>,
    /// Differences between the two.
    pub(super) lattices: Vec<(PartId, TileId)>,
    pub(super) edges: Vec<(PartId, RowId)>,
}

impl PlanPages {
    /// A copy of the last plan with a single owner. Reuses the spare one unless someone still holds it.
    pub(super) fn next(&mut self) -> Arc<Plan> {
        let mut spare = self.spare.take();
        let Some(page) = spare.as_mut().and_then(Arc::get_mut) else { return Arc::new(Plan::clone(&self.last)) };
        for &(part, tile) in &self.lattices {
            let (part, tile) = (part.index(), tile.0 as usize);
            page.parts[part].tiles[tile] = Arc::clone(&self.last.parts[part].tiles[tile]);
        }
        for &(part, edge) in &self.edges {
            let (part, edge) = (part.index(), edge.index());
            page.parts[part].edges[edge] = Arc::clone(&self.last.parts[part].edges[edge]);
        }
        spare.unwrap_or_default()
    }

    /// Goes on with other parts: those of the last plan that `from` names, at the rows that name them, and `new` in the
    /// other rows, in order.
    pub(super) fn update(&mut self, from: &[Option<PartId>], new: Plan) {
        let last = Arc::make_mut(&mut self.last);
        last.parts = renewed(std::mem::take(&mut last.parts), from, new.parts);
        self.spare = None;
    }

    pub(super) fn turn(&mut self, next: Arc<Plan>, changes: &PlanChanges) {
        self.lattices.clone_from(&changes.lattices);
        self.edges.clone_from(&changes.edges);
        self.spare = Some(std::mem::replace(&mut self.last, next));
    }
}
