//! A tolerance, or one camera -> a plan that meets it within limits.

use super::lattice::{DensityMet, LatticeRequest, Lattices, is_exact, places};
use super::limits::{Budget, PlanLimits, Shortfall};
use super::lists::{Span, Stretch, lists, stretches};
use super::output::{EdgePolyline, LINES_OF_TILE, Made, PartPlan, Plan, TileLattice, cells, free_later};
use super::rows::{BLOCK, PlanRows};
use super::targets::{PlanModel, PlanTargets, Target};
use super::tessellants::{NarrowestCells, Tessellants, bare, bare_within};
use crate::control::{Call, Control, Jobs, Rayon, drop_later, map, width};
use crate::frame::tolerance::{BoxTolerances, Tolerance};
use crate::mesh::DrawnTiles;
use crate::model::{PartId, RowId, TileId};
use crate::prepare::Prepared;
use crate::prepare::internals::{EDGES_PER_BOX, PreparedPart};
use crate::view::View;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Plans lattice lines and tessellants for a tolerance in the placed model, within [`PlanLimits::DEFAULT`].
///
/// A part is planned for the largest scale of its instances, so that its triangles meet the tolerance in all of them.
/// There are at most 4096 lines between two creases of a tile (32768 where a circle as large as the part needs 2048),
/// and 262144 segments along an edge. If the tolerance requires more, or has unusable values (see [`Tolerance`]), the
/// plan is coarser and reports it in [`Plan::shortfall`]; [`Plan::require_full`] turns that into an error, unless only
/// noise requires more ([`Shortfall::by_limits`]).
///
/// Cost: about 1 µs per tile and per edge. Runs on [`Rayon`]'s threads.
#[must_use]
pub fn plan(prepared: &Prepared, tolerance: &Tolerance) -> Plan {
    plan_within(prepared, tolerance, &PlanLimits::DEFAULT)
}

/// As [`plan`], within the limits of the caller.
#[must_use]
pub fn plan_within(prepared: &Prepared, tolerance: &Tolerance, limits: &PlanLimits) -> Plan {
    plan_on(&Rayon, prepared, tolerance, limits, &Control::default()).unwrap_or_default()
}

/// Why a plan was not made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The work was [cancelled](Control::cancel).
    #[error("planning was cancelled")]
    Cancelled,
}

/// As [`plan_within`], on the threads of `jobs`, with cancellation: it takes effect after at most 64 tiles or edges on
/// each thread. The plan does not depend on the number of threads. Reports no progress.
///
/// # Errors
/// When cancelled.
pub fn plan_on(
    jobs: &dyn Jobs,
    prepared: &Prepared,
    tolerance: &Tolerance,
    limits: &PlanLimits,
    control: &Control,
) -> Result<Plan, PlanError> {
    let scales = prepared.scene.largest_scales();
    let target = Target::Tolerances(scales.iter().map(|&scale| tolerance.within_part(scale)).collect());
    let model = PlanModel::of_parts(prepared, Arc::clone(&prepared.parts), 0..prepared.parts.len());
    let targets = Arc::new(PlanTargets { model: Arc::new(model), target });
    let held_mib = u32::try_from(prepared.memory().total().div_ceil(1 << 20)).unwrap_or(u32::MAX);
    plan_parts(Call::new(jobs, control), &targets, limits, held_mib).ok_or(PlanError::Cancelled)
}

/// Plans lattice lines and tessellants for one camera, within [`PlanLimits::DEFAULT`].
///
/// Every sub-box of a tile and every strip of an edge has its own tolerance: `deviation_px` over the most pixels that a
/// millimetre covers anywhere in the box, for the instance where that is largest. Cells and segments that lie in
/// several boxes meet the strictest of their tolerances. Wherever a point of the surface is in the image, the triangles
/// are therefore within `deviation_px` of it. The density of an edge depends on its own boxes and on the lattices next
/// to it, and is the same for all its faces.
///
/// Off-screen surface is planned at the depth where the frustum is wide enough to contain it, for shadows and for the
/// next frame. Surface that is nearer than the near plane or behind the camera, and parts without instances, are as
/// coarse as the angle allows.
///
/// A camera inside the model costs no more than one outside: a box nearer than 5 % of half its diagonal is planned at
/// that distance. Where a surface bends, boxes are usually a quarter of a Bézier piece wide, so that such a box is
/// about to leave the image.
///
/// An invalid view (not finite, no direction, no size) gives the coarsest plan, and [`Plan::shortfall`] reports it.
///
/// Cost: that of [`plan`](crate::frame::plan()), plus about 20 ns for each box of each instance.
/// Runs on [`Rayon`]'s threads.
#[must_use]
pub fn plan_for_view(prepared: &Prepared, view: &View) -> Plan {
    plan_for_view_within(prepared, view, &PlanLimits::DEFAULT)
}

/// As [`plan_for_view`], within the limits of the caller.
#[must_use]
pub fn plan_for_view_within(prepared: &Prepared, view: &View, limits: &PlanLimits) -> Plan {
    plan_for_view_on(&Rayon, prepared, view, limits, &Control::default()).unwrap_or_default()
}

/// As [`plan_for_view_within`], on the threads of `jobs`, with cancellation, as [`plan_on`].
///
/// # Errors
/// When cancelled.
pub fn plan_for_view_on(
    jobs: &dyn Jobs,
    prepared: &Prepared,
    view: &View,
    limits: &PlanLimits,
    control: &Control,
) -> Result<Plan, PlanError> {
    plan_of_view(jobs, &Arc::new(PlanModel::of(prepared)), view, limits, control)
}

/// [`plan_for_view_on`], with a `PlanModel` that the caller keeps between plans.
pub(crate) fn plan_of_view(
    jobs: &dyn Jobs,
    model: &Arc<PlanModel>,
    view: &View,
    limits: &PlanLimits,
    control: &Control,
) -> Result<Plan, PlanError> {
    let target = Target::of_view(view, model.parts.len());
    let targets = Arc::new(PlanTargets { model: Arc::clone(model), target });
    let planned = plan_parts(Call::new(jobs, control), &targets, limits, 0);
    // The cameras, which are not in this thread's cache.
    drop_later(jobs, Arc::into_inner(targets).map(|targets| targets.target).into_iter().collect());
    planned.ok_or(PlanError::Cancelled)
}

/// The coarsest plan of some parts within limits, in their order. `None` once cancelled.
pub(crate) fn coarsest(
    call: Call<'_>,
    prepared: &Prepared,
    rows: &[usize],
    limits: &PlanLimits,
) -> Option<Vec<PartPlan>> {
    let coarsest = Tolerance { chord: f64::INFINITY, angle: f64::INFINITY, max_edge: None };
    let parts = Arc::new(rows.iter().map(|&row| Arc::clone(&prepared.parts[row])).collect());
    let model = Arc::new(PlanModel::of_parts(prepared, parts, rows.iter().copied()));
    let targets = PlanTargets { model, target: Target::Tolerances(vec![coarsest; rows.len()]) };
    Some(plan_parts(call, &Arc::new(targets), limits, 0)?.parts)
}

/// The plan, with the coarsest rows for parts of `prepared` that it has none of, also those after its last.
pub(crate) fn completed(jobs: &dyn Jobs, plan: &Arc<Plan>, prepared: &Prepared, limits: &PlanLimits) -> Arc<Plan> {
    let mut all = Arc::clone(plan);
    if all.parts.len() < prepared.parts.len() {
        Arc::make_mut(&mut all).parts.resize_with(prepared.parts.len(), PartPlan::default);
    }
    let parts = all.parts.iter().zip(&*prepared.parts).enumerate();
    let bare = parts.filter(|(_, (plan, part))| !plan.is_of(part)).map(|(row, _)| row);
    let rows: Vec<usize> = bare.collect();
    if !rows.is_empty() {
        let parts = &mut Arc::make_mut(&mut all).parts;
        let control = Control::default();
        let planned = coarsest(Call::new(jobs, &control), prepared, &rows, limits).unwrap_or_default();
        rows.into_iter().zip(planned).for_each(|(row, plan)| parts[row] = plan);
    }
    all
}

/// Plans all parts, each for its own tolerance in part coordinates. `None` once cancelled.
///
/// If the whole does not fit the limits, all densities are lowered by the same factor: no face is favoured. `held_mib`:
/// memory of the prepared model that counts towards the limits, MiB.
fn plan_parts(call: Call<'_>, targets: &Arc<PlanTargets>, limits: &PlanLimits, held_mib: u32) -> Option<Plan> {
    /// Steps of 0.75 until every tile has one cell and no plan is smaller: a factor of 1e-12.
    const LOWEST: u32 = 96;
    let shortfall = Shortfall { held_mib, unusable: targets.is_unusable(), ..Shortfall::none(limits) };
    let parts = targets.model.parts.len();
    let attempt = |steps: u32| -> Result<Plan, PlanRequest<'_>> {
        let mut budget = Budget::of(limits, held_mib);
        if steps == LOWEST {
            budget.left = u64::MAX;
        }
        let density = libm::pow(0.75, f64::from(steps));
        let request = PlanRequest { call, targets, density, cells_per_tile: budget.cells_per_tile };
        let mut shortfall = Shortfall { density, ..shortfall.clone() };
        let parts = request.plan(0..parts, &mut budget, &mut shortfall).ok_or(request)?;
        Ok(Plan { parts, drawn: DrawnTiles::default(), shortfall: shortfall.if_any(), made: Made(true) })
    };
    let request = match attempt(0) {
        Ok(plan) => return Some(plan),
        Err(request) => request,
    };
    let needed = request.triangles();
    // Twice as far each time, until a plan fits: the last one has no limit.
    let (mut fails, mut fits) = (0, 1);
    let mut plan = loop {
        match attempt(fits) {
            Ok(plan) => break plan,
            Err(_) => (fails, fits) = (fits, (2 * fits).min(LOWEST)),
        }
        call.goes_on()?;
    };
    // Then halfway back.
    while fits - fails > 1 {
        let middle = (fails + fits) / 2;
        match attempt(middle) {
            Ok(finer) => (fits, plan) = (middle, finer),
            Err(_) => fails = middle,
        }
    }
    plan.shortfall.iter_mut().for_each(|shortfall| shortfall.needed = needed);
    call.goes_on()?;
    Some(plan)
}

/// What to plan, and where.
#[derive(Clone, Copy)]
struct PlanRequest<'a> {
    call: Call<'a>,
    targets: &'a Arc<PlanTargets>,
    density: f64,
    cells_per_tile: u64,
}

impl PlanRequest<'_> {
    /// Upper bound on the triangles, each tile within its limit.
    fn triangles(&self) -> u64 {
        let mut budget = Budget { left: u64::MAX, cells_per_tile: self.cells_per_tile };
        for part in 0..self.targets.model.parts.len() {
            // Keeps the plan of one part at a time in memory. The budget does not run out.
            let _ = self.plan(part..part + 1, &mut budget, &mut Shortfall::none(&PlanLimits::DEFAULT));
        }
        2 * (u64::MAX - budget.left)
    }

    /// Plans some parts; `None` if the budget does not suffice, or once cancelled.
    fn plan(&self, parts: Range<usize>, budget: &mut Budget, shortfall: &mut Shortfall) -> Option<Vec<PartPlan>> {
        let Self { call: Call { jobs, control }, targets, density, cells_per_tile } = *self;
        let spent = SharedBudget { cells: AtomicU64::new(0), left: budget.left, control: control.clone() };
        let first = parts.start;
        let round = Arc::new(Round { targets: Arc::clone(targets), first, density, cells_per_tile, spent });
        let PlanModel { parts: prepared, tiles, edges, .. } = &*targets.model;

        let step = tracing::trace_span!("lattices").entered();
        let (shared, rows) = (Arc::clone(&round), empty(&tiles[parts.clone()]));
        let shared_rows = Arc::clone(&rows);
        let lists_of_tiles = lists(width(jobs), parts.clone(), tiles);
        let made = map(jobs, lists_of_tiles, move |list| shared.lattices(list, &shared_rows));
        (shortfall.tiles, shortfall.lines, shortfall.edges) = Default::default();
        // Where the part itself needs as many lines as there may be, they do not follow noise.
        let mut known = (usize::MAX, [None; 2]);
        let mut too_small = |part: usize, exact: bool| {
            if known.0 != part {
                known = (part, [None; 2]);
            }
            let lines = || targets.of_part(part).around(exact);
            *known.1[usize::from(exact)].get_or_insert_with(lines) >= LINES_OF_TILE as f64
        };
        let mut unusable = false;
        let lattices = finish_rows(made, rows, |part, tile, kept: DensityMet| {
            let id = (PartId::new(part), TileId(tile as u32));
            let of_part = &prepared[part];
            let (row, exact) = (&of_part.tiles[tile], is_exact(of_part.face_of(&of_part.tiles[tile])));
            unusable = unusable || !kept.lines && !row.entangled && too_small(part, exact);
            shortfall.tiles.extend((!kept.cells).then_some(id));
            shortfall.lines.extend((!kept.lines).then_some(id));
        });
        let lattices = match lattices {
            Ok(lattices) => lattices,
            Err(some) => {
                let of_part = |tiles| PartPlan { tiles, ..PartPlan::default() };
                free_later(jobs, some.into_iter().map(of_part).collect());
                return None;
            }
        };
        drop(step);

        let _step = tracing::trace_span!("tessellants").entered();
        let (shared, lattices, rows) = (Arc::clone(&round), Arc::new(lattices), empty(&edges[parts.clone()]));
        let (shared_lattices, shared_rows) = (Arc::clone(&lattices), Arc::clone(&rows));
        let lists_of_edges = lists(width(jobs), parts, edges);
        let made = map(jobs, lists_of_edges, move |list| shared.polylines(list, &shared_lattices, &shared_rows));
        let lines = finish_rows(made, rows, |part, edge, ()| {
            unusable = unusable || too_small(part, false);
            shortfall.edges.push((PartId::new(part), RowId(edge as u32)));
        });
        shortfall.unusable |= unusable;
        let fits = lines.is_ok();
        let (Ok(lines) | Err(lines)) = lines;
        let of_part = |(tiles, edges)| PartPlan { tiles, edges };
        let plans = Arc::into_inner(lattices)?.into_iter().zip(lines).map(of_part).collect();
        if !fits {
            free_later(jobs, plans);
            return None;
        }
        // Not more than are left: no list was refused.
        budget.left -= round.spent.cells.load(Ordering::Relaxed);
        Some(plans)
    }
}

/// Places for the rows of parts that have so many, which threads fill.
fn empty<T>(counts: &[usize]) -> Arc<Vec<PlanRows<T>>> {
    Arc::new(counts.iter().map(|&count| PlanRows::empty(count)).collect())
}

/// Rows that limits made coarser than asked, by part.
type Short<K> = Vec<(usize, usize, K)>;

/// Takes the rows once all lists are made. Calls `short` for each row that limits made coarser.
///
/// # Errors
/// If the budget did not suffice for a list: the rows of others.
fn finish_rows<T, K>(
    made: Vec<Option<Short<K>>>,
    rows: Arc<Vec<PlanRows<T>>>,
    mut short: impl FnMut(usize, usize, K),
) -> Result<Vec<PlanRows<T>>, Vec<PlanRows<T>>> {
    let rows = Arc::into_inner(rows).ok_or_else(Vec::new)?;
    if made.iter().any(Option::is_none) {
        return Err(rows);
    }
    made.into_iter().flatten().flatten().for_each(|(part, row, kept)| short(part, row, kept));
    Ok(rows)
}

/// What the jobs of a plan share.
struct Round {
    targets: Arc<PlanTargets>,
    /// The first part.
    first: usize,
    density: f64,
    cells_per_tile: u64,
    spent: SharedBudget,
}

/// Plans a stretch by `row`, which returns the cells or tessellants and what limits made coarser, too: that goes to
/// `short`, and the blocks to the rows of the part. `None` once there are too many.
fn fill<T, K>(
    (part, rows): &Stretch,
    (of_part, budget): (&PlanRows<T>, &SharedBudget),
    short: &mut Short<K>,
    mut row: impl FnMut(usize) -> (T, u64, Option<K>),
) -> Option<()> {
    for from in rows.clone().step_by(BLOCK) {
        let to = rows.end.min(from + BLOCK);
        let (mut block, mut cells) = (Vec::with_capacity(to - from), 0_u64);
        for k in from..to {
            let (made, more, kept) = row(k);
            cells = cells.saturating_add(more);
            block.push(Arc::new(made));
            short.extend(kept.map(|kept| (*part, k, kept)));
        }
        budget.add(cells)?;
        // No other list has this block.
        of_part.fill(from, block);
    }
    Some(())
}

impl Round {
    /// The lattices of some tiles.
    fn lattices(&self, list: Span, rows: &[PlanRows<TileLattice>]) -> Option<Short<DensityMet>> {
        let (mut need, mut lattices) = <(BoxTolerances, Lattices)>::default();
        let mut short = Vec::new();
        let PlanModel { parts, tiles, .. } = &*self.targets.model;
        for stretch in stretches(list, tiles) {
            let (part, target) = (&parts[stretch.0], self.targets.of_part(stretch.0));
            fill(&stretch, (&rows[stretch.0 - self.first], &self.spent), &mut short, |row| {
                let tile = &part.tiles[row];
                let face = part.face_of(tile);
                target.over(places(face, tile), &mut need);
                let (factor, most_cells) = (self.density, self.cells_per_tile);
                let request = LatticeRequest { face, tile, need: &need, factor, most_cells };
                let (lattice, kept) = lattices.lattice(&request);
                let cells = cells(&lattice);
                (lattice, cells, (!kept.cells || !kept.lines).then_some(kept))
            })?;
        }
        Some(short)
    }

    /// The tessellants of some edges, beside the lattices of their parts.
    fn polylines(
        &self,
        list: Span,
        lattices: &[PlanRows<TileLattice>],
        rows: &[PlanRows<EdgePolyline>],
    ) -> Option<Short<()>> {
        let (mut need, mut tessellants) = <(BoxTolerances, Tessellants)>::default();
        let mut short = Vec::new();
        let model = &*self.targets.model;
        for stretch in stretches(list, &model.edges) {
            let of_plan = stretch.0 - self.first;
            let tiles = &lattices[of_plan];
            let PreparedPart { edges, edge_boxes, .. } = &*model.parts[stretch.0];
            let target = self.targets.of_part(stretch.0);
            let (mut strictest, mut cells) = (None, NarrowestCells::of(tiles));
            fill(&stretch, (&rows[of_plan], &self.spent), &mut short, |row| {
                let edge = &edges[row];
                // Most edges are one segment at the tolerance where their block is nearest, too.
                if row % EDGES_PER_BOX == 0 {
                    strictest = target.strictest(&edge_boxes[row / EDGES_PER_BOX]);
                }
                let bare = if target.limits_length() { None } else { bare(edge, tiles) };
                let bare = bare.or_else(|| bare_within(edge, &mut cells, strictest.as_ref()?, self.density));
                let (line, kept) = bare.map(|line| (line, true)).unwrap_or_else(|| {
                    target.over(edge.bounds.places(), &mut need);
                    tessellants.polyline(edge, &mut cells, &need, self.density)
                });
                let tessellants = line.ts.len() as u64;
                (line, tessellants, (!kept).then_some(()))
            })?;
        }
        Some(short)
    }
}

/// Cells and tessellants planned so far by all threads, and how many there may be.
///
/// A thread adds a block of rows at a time. With a sum for each row, 16 threads waited for each other's cache line: the
/// 25 000 edges of a model took them 2.7 ms, and 4.8 ms one thread (decision 069).
struct SharedBudget {
    cells: AtomicU64,
    left: u64,
    control: Control,
}

impl SharedBudget {
    /// `None` once there are too many, or the caller cancelled. The sum decides, so it does not matter who notices.
    fn add(&self, cells: u64) -> Option<()> {
        if self.control.is_cancelled() {
            return None;
        }
        let before = self.cells.fetch_add(cells, Ordering::Relaxed);
        (before.checked_add(cells)? <= self.left).then_some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{Alone, assert_each_cancels};
    use crate::model::{Frame3, Loop, PartBuilder, ShellKind, Surface, shapes};
    use crate::prepare::{PrepareOptions, prepare};
    use glam::DVec2;
    use std::f64::consts::TAU;

    #[test]
    fn plans_are_cancelled_wherever_they_look() {
        let prepared = prepare(shapes::all(), &PrepareOptions::DEFAULT).expect("within the limits");
        let tolerance = Tolerance { chord: 0.01, angle: 0.5, max_edge: None };
        for limits in [PlanLimits::DEFAULT, PlanLimits::DEFAULT.with_triangles(1000)] {
            assert_each_cancels("shapes", 1000, |control| {
                plan_on(&Alone, &prepared, &tolerance, &limits, control) == Err(PlanError::Cancelled)
            });
        }
    }

    #[test]
    fn boxes_of_edges_contain_their_strips() {
        let mut polygon = PartBuilder::new("polygon");
        let shell = polygon.plain_shell(ShellKind::Open);
        let corner = |k: u32| (DVec2::from_angle(TAU * f64::from(k) / 200.0) * 10.0).extend(0.0);
        let wire = Loop::Edges(polygon.polygon(&(0..200).map(corner).collect::<Vec<_>>()));
        polygon.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![wire], false);
        let models = [polygon.finish().expect("a sound part").into(), shapes::all()];
        let [polygon, shapes] =
            models.map(|model| prepare(model, &PrepareOptions::DEFAULT).expect("within the limits"));
        assert!(polygon.parts[0].edge_boxes.len() > 3);
        for part in polygon.parts.iter().chain(&*shapes.parts) {
            assert_eq!(part.edge_boxes.len(), part.edges.len().div_ceil(EDGES_PER_BOX));
            for (edges, all) in part.edges.chunks(EDGES_PER_BOX).zip(&part.edge_boxes) {
                let mut places = edges.iter().flat_map(|edge| edge.bounds.places());
                assert!(places.all(|place| all.with(place) == *all), "{all:?}");
            }
        }
    }

    #[test]
    fn parts_have_all_rows_whatever_the_lists() {
        let counts = [0, 5, 0, 700, 64, 0, 1, 65, 0];
        let row = |part, row| Arc::new((part, row));
        for (threads, left) in [(1, u64::MAX), (2, u64::MAX), (3, u64::MAX), (1, 500), (3, 500)] {
            let budget = SharedBudget { cells: AtomicU64::new(0), left, control: Control::default() };
            let (lists, rows) = (lists(threads, 0..counts.len(), &counts), empty(&counts));
            assert!((lists.len() == 1) == (threads == 1));
            let make = |list| {
                let mut short = Vec::new();
                assert!(stretches(Range::clone(list), &counts).count() > 0);
                for stretch in stretches(Range::clone(list), &counts) {
                    let row = |row| ((stretch.0, row), 1, (row % 100 == 7).then_some(()));
                    fill(&stretch, (&rows[stretch.0], &budget), &mut short, row)?;
                }
                Some(short)
            };
            let made: Vec<_> = lists.iter().map(make).collect();
            let (kept, mut short) = (rows.iter().flatten().map(Arc::downgrade).collect::<Vec<_>>(), Vec::new());
            let rows = finish_rows(made, rows, |part, row, ()| short.push((part, row)));
            if left == 500 {
                let some = rows.expect_err("too many rows");
                assert!(short.is_empty() && some.iter().flatten().count() == kept.len() && kept.len() >= 448);
                // Nothing else has them.
                drop(some);
                assert!(kept.iter().all(|row| row.strong_count() == 0));
                continue;
            }
            let all = |(part, &count): (usize, &usize)| (0..count).map(|k| row(part, k)).collect();
            assert_eq!(rows, Ok(counts.iter().enumerate().map(all).collect::<Vec<PlanRows<_>>>()));
            let of_long = [7, 107, 207, 307, 407, 507, 607].map(|row| (3, row));
            assert_eq!(short, [&of_long[..], &[(4, 7), (7, 7)]].concat());
        }
    }
}
