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

    /// Appends the parts of `new` to the last plan.
    pub(super) fn add_parts(&mut self, new: Plan) {
        Arc::make_mut(&mut self.last).parts.extend(new.parts);
        self.spare = None;
    }

    pub(super) fn turn(&mut self, next: Arc<Plan>, changes: &PlanChanges) {
        self.lattices.clone_from(&changes.lattices);
        self.edges.clone_from(&changes.edges);
        self.spare = Some(std::mem::replace(&mut self.last, next));
    }
}
