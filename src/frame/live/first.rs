//! Parts that views show for the first time -> their coarsest plans, and the state of their tiles and edges.

use super::culling::{PartBoxes, RANGE, RangeBoxes};
use super::draft::{CellsAt, GroupBand, SeenTiles};
use super::rate::Rate;
use super::rates::{PartRates, Rates, TileCounts, along};
use crate::control::{Call, Jobs, map};
use crate::frame::plan::make::coarsest;
use crate::frame::plan::output::{PartPlan, cells};
use crate::model::PartId;
use crate::prepare::Prepared;
use crate::prepare::internals::PreparedPart;
use std::sync::Arc;

/// Gives these parts a state, and returns the coarsest plan of each. `None` once cancelled.
///
/// Cost: a few microseconds per tile and per edge, divided among threads.
pub(super) fn begin(call: Call<'_>, rates: &mut Rates, rows: &[usize]) -> Option<Vec<PartPlan>> {
    bound(call.jobs, rates, rows);
    call.goes_on()?;
    let planned = coarsest(call, &rates.prepared, rows, &rates.options.limits)?;
    let (planned, counts) = counted(call.jobs, &rates.prepared, rows, planned);
    call.goes_on()?;
    let Rates { prepared, parts, options, .. } = rates;
    for (&row, counts) in rows.iter().zip(counts) {
        let boxes = Arc::clone(&parts[of_model(prepared, row)].boxes);
        parts[row] = PartRates::first(&prepared.parts[row], boxes, counts, options.budget.is_some());
    }
    Some(planned)
}

impl PartRates {
    /// Of a part with its coarsest plan, whose tiles have so many cells, and tessellants along their loops. Nothing has
    /// a rate yet.
    fn first(part: &PreparedPart, boxes: Arc<PartBoxes>, counts: TileCounts, is_budgeted: bool) -> Self {
        let (tiles, edges) = (part.tiles.len(), part.edges.len());
        Self {
            groups: vec![GroupBand::NONE; boxes.groups()],
            boxes,
            tiles: vec![Rate::Even(None); tiles],
            bands: vec![(0.0, 0.0); tiles],
            edges: vec![Rate::Even(None); edges],
            tile_terms: vec![0; tiles],
            edge_terms: vec![0; edges],
            counts,
            estimates: vec![CellsAt::NEVER; if is_budgeted { tiles } else { 0 }],
            seen: SeenTiles::none(tiles),
            is_new: true,
        }
    }
}

/// The row of the part that has the boxes of one.
fn of_model(prepared: &Prepared, row: usize) -> usize {
    prepared.scene.of_model(PartId::new(row)).index()
}

/// Makes the boxes that these parts need and do not have yet.
fn bound(jobs: &dyn Jobs, rates: &mut Rates, rows: &[usize]) {
    let Rates { prepared, parts, options, .. } = rates;
    let mut bare: Vec<usize> = rows.iter().map(|&row| of_model(prepared, row)).collect();
    bare.sort_unstable();
    bare.dedup();
    bare.retain(|&row| parts[row].boxes.len() < prepared.parts[row].tiles.len());
    let (shared, culls) = (Arc::clone(prepared), options.cull_back_faces);
    let may_cull = map(jobs, bare.clone(), move |row| culls && shared.parts[row].is_closed());
    let ranges = |row: usize| prepared.parts[row].tiles.len().div_ceil(RANGE);
    let of_part = |(&row, may_cull): (&usize, bool)| (0..ranges(row)).map(move |range| (row, range, may_cull));
    let items = bare.iter().zip(may_cull).flat_map(of_part).collect();
    let shared = Arc::clone(prepared);
    let made = map(jobs, items, move |(row, range, may_cull)| RangeBoxes::of(&shared.parts[row], range, may_cull));
    let mut made = made.into_iter();
    for row in bare {
        parts[row].boxes = Arc::new(PartBoxes(made.by_ref().take(ranges(row)).collect()));
    }
}

/// The plans of these parts; and of their tiles the numbers of cells, and of tessellants along their loops.
fn counted(
    jobs: &dyn Jobs,
    prepared: &Arc<Prepared>,
    rows: &[usize],
    plans: Vec<PartPlan>,
) -> (Vec<PartPlan>, Vec<TileCounts>) {
    let of_part = |(part, (&row, plan)): (usize, (&usize, &PartPlan))| {
        let tiles = plan.tiles.len();
        (0..tiles).step_by(RANGE).map(move |from| (part, row, from..tiles.min(from + RANGE)))
    };
    let items = rows.iter().zip(&plans).enumerate().flat_map(of_part).collect();
    let mut counts: Vec<TileCounts> = plans.iter().map(|_| TileCounts::default()).collect();
    let plans = Arc::new(plans);
    let (shared, prepared) = (Arc::clone(&plans), Arc::clone(prepared));
    // On all threads: each lattice is elsewhere in memory, and to look at it takes a miss of the caches.
    let made = map(jobs, items, move |(part, row, tiles)| -> (usize, Vec<(u64, u32)>) {
        let (plan, of) = (&shared[part], &prepared.parts[row]);
        let outline = |tile: usize| -> u32 {
            let loops = &of.tiles[tile].loops;
            let uses = loops.iter().flatten().map(|u| along(&plan.edges[u.edge.index()], u));
            uses.sum::<u32>() + 2 * (loops.len() as u32).saturating_sub(1)
        };
        (part, tiles.map(|tile| (cells(&plan.tiles[tile]), outline(tile))).collect())
    });
    for (part, more) in made {
        more.into_iter().for_each(|(cells, outline)| counts[part].push(cells, outline));
    }
    (Arc::into_inner(plans).expect("the loop has ended"), counts)
}
