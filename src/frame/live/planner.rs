//! Views, frame after frame -> plans that differ from the last one only where the views require it.
//!
//! Each tile has a step of density with hysteresis ([`rate`](super::rate)), for its bounding box. A tile that is close
//! to the eye or partly off-screen has a step for each of its sub-boxes instead. An edge takes the finest step of its
//! tiles; next to a tile with several steps, it has steps for its own boxes. Off-screen tiles keep their steps.

use super::culling::WORDS;
use super::defer;
use super::draft::{
    ChangedRows, LimitStep, NewTessellants, PLANNED, PlanDraft, RateChanges, SeenRange, Sights, TessellantUpdate,
    Touched, VisibleTiles, WantedRate,
};
use super::first;
use super::options::PlannerOptions;
use super::pages::{PlanChanges, PlanPages, renewed};
use super::placed::{PlacedInstances, Shown};
use super::rate::{Rate, Terms, steps_of};
use super::rates::Rates;
use super::resync::Turns;
use crate::control::{Alone, Jobs, chunks, map, map_with};
use crate::frame::plan::budget::Budget;
use crate::frame::plan::lattice::Lattices;
use crate::frame::plan::limits::Shortfall;
use crate::frame::plan::output::{EdgePolyline, PartPlan, Plan, TileLattice};
use crate::frame::plan::tessellants::Tessellants;
use crate::mesh::successors;
use crate::model::{PartId, RowId, TileId};
use crate::prepare::Prepared;
use crate::view::View;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Makes the plans of consecutive frames.
///
/// Deterministic: the same options, views and instances, frame by frame, give the same plans, bit for bit.
pub struct Planner {
    /// Has one owner between steps.
    rates: Arc<Rates>,
    pages: PlanPages,
    changes: PlanChanges,
    limited: Limited,
    touched: Touched,
    changed: ChangedRows,
    /// Views of the last plan, and the version of the instances.
    seen: Vec<View>,
    placed: u64,
    /// Whether to plan again even if nothing moves.
    unfinished: bool,
    /// By how much the last change of common terms that limits caused multiplied the triangles, per step finer.
    growth: f64,
}

/// Tiles and edges that limits make coarser than required.
#[derive(Default)]
struct Limited {
    tiles: BTreeSet<(PartId, TileId)>,
    lines: BTreeSet<(PartId, TileId)>,
    edges: BTreeSet<(PartId, RowId)>,
}

impl Limited {
    /// Renumbers parts as [`Planner::update`] says, and drops those that go.
    fn renumber(&mut self, from: &[Option<PartId>]) {
        fn renumbered<T: Ord + Copy>(
            rows: &BTreeSet<(PartId, T)>,
            new: &BTreeMap<PartId, PartId>,
        ) -> BTreeSet<(PartId, T)> {
            rows.iter().filter_map(|(part, row)| Some((*new.get(part)?, *row))).collect()
        }
        let new = successors(from);
        self.tiles = renumbered(&self.tiles, &new);
        self.lines = renumbered(&self.lines, &new);
        self.edges = renumbered(&self.edges, &new);
    }
}

fn mark<T: Ord>(set: &mut BTreeSet<T>, row: T, is_in: bool) {
    if is_in {
        set.insert(row);
    } else if !set.is_empty() {
        set.remove(&row);
    }
}

impl Planner {
    /// Starts without plans: a part is planned once a view shows it.
    #[must_use]
    pub fn new(prepared: Arc<Prepared>, options: &PlannerOptions) -> Self {
        let rates = Rates {
            prepared: Arc::default(),
            parts: Vec::new(),
            shown: Vec::new(),
            terms: Terms { angle: f64::INFINITY, size: None, coarser: 0 },
            term: 0,
            turns: Turns::of(options.lines),
            options: *options,
        };
        let mut planner = Self {
            rates: Arc::new(rates),
            pages: PlanPages::default(),
            changes: PlanChanges::default(),
            limited: Limited::default(),
            touched: Touched::default(),
            changed: ChangedRows::default(),
            seen: Vec::new(),
            placed: 0,
            unfinished: true,
            growth: 2.0,
        };
        planner.add_parts(prepared);
        planner
    }

    /// Goes on with a model that has further parts after those known.
    pub fn add_parts(&mut self, prepared: Arc<Prepared>) {
        let known = self.rates.parts.len();
        let from: Vec<_> = (0..prepared.parts.len()).map(|p| (p < known).then_some(PartId::new(p))).collect();
        self.renew(prepared, &from);
    }

    /// Switches to another model. Its part `p` is the one that was `from[p]`, and keeps its levels; a part that was none
    /// is planned once a view shows it. `from` has a row for each part, and names none twice. Limits start again: what
    /// they made coarser is planned as if it were new.
    ///
    /// Cost: one pass over the parts; if the last plan has other owners, a copy of its rows.
    pub fn update(&mut self, prepared: Arc<Prepared>, from: &[Option<PartId>]) {
        let Rates { terms, term, .. } = own(&mut self.rates);
        if terms.coarser > 0 {
            terms.coarser = 0;
            *term += 1;
        }
        self.renew(prepared, from);
    }

    fn renew(&mut self, prepared: Arc<Prepared>, from: &[Option<PartId>]) {
        let rates = own(&mut self.rates);
        rates.parts = renewed(std::mem::take(&mut rates.parts), from);
        rates.shown = (0..rates.parts.len()).filter(|&part| rates.parts[part].seen.shows_any()).collect();
        self.touched.stamps = renewed(std::mem::take(&mut self.touched.stamps), from);
        self.limited.renumber(from);
        rates.prepared = prepared;
        self.pages.update(from);
    }

    /// Begins with the coarsest plan of each part that views may show for the first time. Cost: a few microseconds per
    /// tile and per edge of these, divided among threads.
    fn begin(&mut self, jobs: &dyn Jobs, draft: &mut PlanDraft) {
        let rates = own(&mut self.rates);
        let page = own(&mut draft.page);
        let is_bare = |row: &usize| !page.parts[*row].is_of(&rates.prepared.parts[*row]);
        let rows: Vec<usize> = draft.sights.parts().filter(is_bare).collect();
        if rows.is_empty() {
            return;
        }
        let _span = tracing::trace_span!("begin").entered();
        let planned = first::begin(jobs, rates, &rows);
        for (row, plan) in rows.into_iter().zip(planned) {
            self.touched.stamps[row] = vec![0; plan.edges.len()];
            page.parts[row] = plan;
            draft.changes.parts.push(PartId::new(row));
        }
    }

    /// The last plan. Parts that no view has shown have no rows.
    #[must_use]
    pub fn last(&self) -> &Arc<Plan> {
        &self.pages.last
    }

    /// Differences between the last plan and the one before.
    #[must_use]
    pub fn changes(&self) -> &PlanChanges {
        &self.changes
    }

    /// Estimates the memory of levels and plans, bytes. Cost: one pass over all tiles and edges.
    #[must_use]
    pub fn memory(&self) -> usize {
        /// The counters of an `Arc`, and one more pointer: there are two plans, which share most rows.
        const SHARED: usize = 4 * size_of::<usize>();
        /// Of a tile, besides its rate and lattice: band, term, history, counts, scales, its share of a group.
        const TILE: usize = 54;
        /// Of a tile and all of its LODs: bounding box, cone, its place in a group and its share of that.
        const BOXES: usize = 90;
        /// Of an edge, besides its rate and tessellants: term, history, stamp.
        const EDGE: usize = 8;
        let heap = |is_spilled: bool, bytes: usize| if is_spilled { bytes } else { 0 };
        let tile = |lattice: &Arc<TileLattice>| {
            let lines = [&lattice.us, &lattice.vs].map(|lines| heap(lines.spilled(), 8 * lines.len()));
            TILE + size_of::<Rate>() + SHARED + size_of::<TileLattice>() + lines.iter().sum::<usize>()
        };
        let edge = |line: &Arc<EdgePolyline>| {
            let EdgePolyline { ts, breaks } = &**line;
            let heap = heap(ts.spilled(), 8 * ts.len()) + heap(breaks.spilled(), 4 * breaks.len());
            EDGE + size_of::<Rate>() + SHARED + size_of::<EdgePolyline>() + heap
        };
        let part =
            |plan: &PartPlan| plan.tiles.iter().map(tile).sum::<usize>() + plan.edges.iter().map(edge).sum::<usize>();
        let boxes: BTreeMap<_, _> =
            self.rates.parts.iter().map(|part| (Arc::as_ptr(&part.boxes), BOXES * part.boxes.len())).collect();
        let estimates = self.rates.parts.iter().map(|part| size_of_val(&part.estimates[..]));
        self.pages.last.parts.iter().map(part).chain(boxes.into_values()).chain(estimates).sum()
    }

    /// Whether the last plan is the one for these views, if no instance moved since, and nothing is left to refine.
    #[must_use]
    pub fn has_settled_on(&self, views: &[View]) -> bool {
        self.seen == views && !self.rates.turns.are_left() && !self.unfinished
    }

    /// Makes the plan for these views of the instances, which are the same in every call but for their changes, and
    /// whose parts index the prepared model. Where several views or instances show the same place of a part, the
    /// strictest tolerance applies.
    ///
    /// All tiles in [`Plan::drawn`] keep the tolerance, up to [`Plan::shortfall`] and [`PlanChanges::deferred`].
    /// Views that are invalid (see [`plan_for_view`](crate::frame::plan_for_view())), or allow no error at all, draw
    /// nothing and do not count; instances of unknown parts are skipped.
    ///
    /// Cost: a test per group of 16 tiles of an instance that a view may show; about 20 ns per tile of groups that are
    /// partly in the picture or near a change of level; a few microseconds per tile and edge that changes. If nothing
    /// moved, one comparison of the views with the last ones. Runs on the caller's thread.
    pub fn plan(&mut self, placed: &mut PlacedInstances, views: &[View]) -> &Arc<Plan> {
        let shown = placed.shown_by(views, self.rates.options.cull_back_faces);
        self.plan_on(&Alone, placed, (views, shown))
    }

    /// As [`plan`](Self::plan), on the threads of `jobs`, for views and what they may show. The plan does not depend on
    /// the number of threads.
    pub(crate) fn plan_on(
        &mut self,
        jobs: &dyn Jobs,
        placed: &PlacedInstances,
        (views, shown): (&[View], Shown),
    ) -> &Arc<Plan> {
        let has_moved = self.placed != placed.version();
        own(&mut self.rates).turns.pass(self.seen == views && !has_moved);
        if !has_moved && self.has_settled_on(views) {
            self.changes = PlanChanges::default();
            return &self.pages.last;
        }
        let _span = tracing::debug_span!("plan").entered();
        self.placed = placed.version();
        self.seen.clear();
        self.seen.extend_from_slice(views);
        self.agree_on(views);

        let unusable = shown.views < views.len();
        let part_of = |instance: usize| placed.instances()[instance].part.index();
        let sights = Sights::of(shown.sights, self.rates.parts.len(), part_of);
        let mut draft = PlanDraft::new(self.pages.next(jobs), sights);
        self.begin(jobs, &mut draft);
        let mut step = LimitStep::default();
        loop {
            own(&mut draft.page).drawn.reset(views.len());
            self.see(jobs, &mut draft);
            self.look(jobs, &mut draft);
            self.defer(jobs, &mut draft);
            self.apply(jobs, &mut draft);
            self.tessellate(jobs, &mut draft);
            self.unfinished = draft.changes.deferred > 0;
            if self.fits(&mut step) {
                break;
            }
        }
        own(&mut draft.page).shortfall = self.shortfall(unusable);
        let (page, changes) = draft.finish(&mut self.changed);
        self.pages.turn(page, &changes);
        self.changes = changes;
        &self.pages.last
    }

    /// Sets the terms common to all valid views: the strictest angle and edge length.
    fn agree_on(&mut self, views: &[View]) {
        let valid = || views.iter().filter(|view| view.usable_lens().is_some());
        let strictest = |of: &dyn Fn(&View) -> Option<f64>| valid().filter_map(of).reduce(f64::min);
        let rates = own(&mut self.rates);
        let terms = Terms {
            angle: strictest(&|view| Some(view.angle)).unwrap_or(f64::INFINITY),
            size: strictest(&|view| view.size_px.map(|size| size / view.deviation_px)),
            coarser: rates.terms.coarser,
        };
        if terms != rates.terms || rates.term == 0 {
            rates.terms = terms;
            rates.term += 1;
        }
    }

    /// Finds the drawn tiles.
    fn see(&mut self, jobs: &dyn Jobs, draft: &mut PlanDraft) {
        let _span = tracing::trace_span!("see").entered();
        let mut ranges: Vec<VisibleTiles> = Vec::new();
        let Rates { parts, shown, .. } = own(&mut self.rates);
        // Most parts of a large scene are neither in the picture nor were in it.
        shown.extend(draft.sights.parts());
        shown.sort_unstable();
        shown.dedup();
        for &part in &*shown {
            let of_range = |(range, seen): (usize, &mut SeenRange)| {
                let seen = std::mem::take(seen);
                VisibleTiles { part, range, seen, sights: Vec::new(), bits: Vec::new() }
            };
            ranges.extend(parts[part].seen.0.iter_mut().enumerate().map(of_range));
        }
        let (rates, sights) = (Arc::clone(&self.rates), Arc::clone(&draft.sights));
        let mut ranges = map(jobs, ranges, move |mut range| {
            rates.see(&mut range, &sights);
            range
        });
        let Rates { parts, shown, .. } = own(&mut self.rates);
        for VisibleTiles { part, range, seen, .. } in &mut ranges {
            parts[*part].seen.0[*range] = std::mem::take(seen);
        }
        shown.retain(|&part| parts[part].seen.shows_any());
        let sights = &draft.sights;
        let rows = ranges.iter().flat_map(|tiles| {
            let of_sight = tiles.sights.iter().zip(tiles.bits.chunks_exact(WORDS));
            of_sight.map(|(&s, bits)| (&sights.of_part(tiles.part)[s as usize], tiles.range, bits))
        });
        let mut rows: Vec<_> = rows.map(|(sight, range, bits)| (sight.view, sight.instance, range, bits)).collect();
        rows.sort_unstable_by_key(|&(view, instance, range, _)| (view, instance, range));
        let drawn = &mut own(&mut draft.page).drawn;
        rows.into_iter().for_each(|(view, instance, range, bits)| drawn.push(view, instance, range * WORDS, bits));
    }

    /// Finds the drawn tiles whose rate should change.
    fn look(&mut self, jobs: &dyn Jobs, draft: &mut PlanDraft) {
        let _span = tracing::trace_span!("look").entered();
        let (rates, sights) = (Arc::clone(&self.rates), Arc::clone(&draft.sights));
        let rows = rates.shown.iter().flat_map(|&p| rates.parts[p].seen.open().map(move |groups| (p, groups)));
        let rows: Vec<(usize, (usize, u32))> = rows.collect();
        let found = map(jobs, rows, move |(part, groups)| {
            let mut wanted = RateChanges::default();
            rates.look_at(part, groups, sights.of_part(part), &mut wanted);
            wanted
        });
        let parts = &mut own(&mut self.rates).parts;
        for RateChanges { rates, near, due, groups, estimates } in found {
            rates.into_iter().for_each(|list| draft.want(list));
            draft.near.extend(near);
            groups.into_iter().for_each(|(p, group, band)| parts[p].groups[group] = band);
            estimates.into_iter().for_each(|(p, t, estimate)| parts[p].estimates[t] = estimate);
            due.into_iter().for_each(|(p, t)| parts[p].kept.due[t] = true);
        }
    }

    /// Defers the changes that exceed the budget.
    fn defer(&self, jobs: &dyn Jobs, draft: &mut PlanDraft) {
        let Some(budget) = self.rates.options.budget else { return };
        let _span = tracing::trace_span!("defer").entered();
        let wanted: Vec<WantedRate> = std::mem::take(&mut draft.wanted).into_iter().flatten().collect();
        let count = wanted.len();
        let now = defer::within(budget, wanted, &self.rates.prepared, &draft.page);
        draft.changes.deferred = (count - now.len()) as u32;
        draft.wanted = chunks(jobs, now, PLANNED);
    }

    /// Plans the lattices of the tiles that change, and marks their edges.
    fn apply(&mut self, jobs: &dyn Jobs, draft: &mut PlanDraft) {
        let _span = tracing::trace_span!("lattices").entered();
        let (rates, page) = (Arc::clone(&self.rates), Arc::clone(&draft.page));
        let (wanted, mut spaces) = (std::mem::take(&mut draft.wanted), Vec::<Lattices>::new());
        let made = map_with(jobs, &mut spaces, wanted, move |lattices, wanted| -> Vec<_> {
            let made = |wanted: WantedRate| (rates.new_lattice(&wanted, &page, lattices), wanted);
            wanted.into_iter().map(made).collect()
        });
        let Self { rates, pages, touched, limited, changed, .. } = self;
        let Rates { prepared, parts, term, .. } = own(rates);
        let page = own(&mut draft.page);
        for (new, wanted) in made.into_iter().flatten() {
            let WantedRate { part: p, tile: t, rate, band, .. } = wanted;
            let rates = &mut parts[p];
            let id = (PartId::new(p), TileId(t as u32));
            (rates.kept.tiles[t], rates.kept.due[t]) = (new.follows, false);
            mark(&mut limited.tiles, id, !new.kept.cells);
            mark(&mut limited.lines, id, !new.kept.lines);
            if let Some((cells, [made, again])) = new.made {
                rates.set_cells(t, cells);
                let old = std::mem::replace(&mut page.parts[p].tiles[t], made);
                pages.new.lattices.push((p, t, [again, old]));
                changed.lattices.add(p, t);
                changed.tiles.add(p, t);
            }
            (rates.tiles[t], rates.bands[t], rates.tile_terms[t]) = (rate, band, *term);
            new.touches.into_iter().for_each(|(edge, why)| touched.add(p, edge, why));
        }
        for (p, t) in draft.near.drain(..) {
            let uses = prepared.parts[p].tiles[t].loops.iter().flatten();
            uses.for_each(|u| touched.add(p, u.edge, 0));
        }
    }

    /// Plans the tessellants of the marked edges.
    fn tessellate(&mut self, jobs: &dyn Jobs, draft: &mut PlanDraft) {
        let _span = tracing::trace_span!("tessellants").entered();
        let (rates, page, sights) = (Arc::clone(&self.rates), Arc::clone(&draft.page), Arc::clone(&draft.sights));
        let touched = chunks(jobs, self.touched.take(), PLANNED);
        let made = map(jobs, touched, move |edges| -> Vec<_> {
            let mut tessellants = Tessellants::default();
            let of_edge = |(p, e, why): (usize, RowId, u8)| {
                ((p, e), rates.new_tessellants((p, e), why, (&page, sights.of_part(p)), &mut tessellants))
            };
            edges.into_iter().map(of_edge).collect()
        });
        let Self { rates, pages, limited, changed, .. } = self;
        let Rates { parts, term, .. } = own(rates);
        let page = own(&mut draft.page);
        for ((p, e), new) in made.into_iter().flatten() {
            let Some(NewTessellants { rate, made }) = new else { continue };
            let (rates, k) = (&mut parts[p], e.index());
            rates.edges[k] = rate;
            let Some(TessellantUpdate { line, tiles, kept, follows }) = made else { continue };
            (rates.kept.edges[k], rates.edge_terms[k]) = (follows, *term);
            let id = PartId::new(p);
            mark(&mut limited.edges, (id, e), !kept);
            if let Some([line, again]) = line {
                let old = std::mem::replace(&mut page.parts[p].edges[k], line);
                pages.new.edges.push((p, k, [again, old]));
                changed.edges.add(p, k);
                for (tile, longer) in tiles {
                    changed.tiles.add(p, tile.index());
                    rates.lengthen(tile.index(), longer);
                }
            }
        }
    }

    /// Whether the drawn tiles are within the limits, and one step finer would not be. If not, takes the terms one step
    /// nearer to that.
    ///
    /// What a step finer costs is known from the last one. Where it turns out to cost more, the plan goes back, and does
    /// not try again.
    fn fits(&mut self, last: &mut LimitStep) -> bool {
        /// Steps after which everything is as coarse as its shape allows: lines are 4096 times as sparse, and a tile has
        /// no more of them.
        const COARSEST: i16 = 48;
        /// Share of the limit to keep free, so that views that move do not change the terms to and fro.
        const SPARE: f64 = 0.1;
        let triangles = self.rates.triangles_drawn();
        let allowed = Budget::of(&self.rates.options.limits, 0).left.saturating_mul(2);
        let Rates { terms, term, .. } = own(&mut self.rates);
        let LimitStep { coarser: before, turned, triangles: were } = *last;
        if before != 0 && were.min(triangles) > 0 {
            self.growth = libm::pow(triangles as f64 / were as f64, -1.0 / f64::from(before)).max(1.0);
        }
        let is_over = triangles > allowed && terms.coarser < COARSEST;
        let turned = turned || is_over && before < 0;
        let has_room = triangles as f64 * self.growth <= (1.0 - SPARE) * allowed as f64;
        // Several steps at once may have been too many. What waits for the budget is not counted yet.
        let may_refine = terms.coarser > 0 && has_room && before != 1 && !turned && !self.unfinished;
        if !is_over && !may_refine {
            return true;
        }
        // What cells need that fall like densities do.
        let needed = steps_of(triangles as f64 / allowed.max(1) as f64).ceil().clamp(1.0, f64::from(COARSEST)) as i16;
        let coarser = if !is_over {
            -1
        } else if before < 0 {
            // Back to where it fitted.
            1
        } else if before > 0 && 10 * triangles > 9 * were {
            // The last steps changed next to nothing.
            needed.max(2 * before)
        } else {
            needed
        };
        let coarser = coarser.min(COARSEST - terms.coarser);
        terms.coarser += coarser;
        *term += 1;
        *last = LimitStep { coarser, turned, triangles };
        false
    }

    fn shortfall(&self, unusable: bool) -> Option<Shortfall> {
        let Limited { tiles, lines, edges } = &self.limited;
        let Rates { options, terms, .. } = &*self.rates;
        let density = 1.0 / terms.coarsened();
        let mut shortfall = Shortfall { unusable, density, ..Shortfall::none(&options.limits) };
        if terms.coarser > 0 {
            shortfall.needed = (self.rates.triangles_drawn() as f64 * terms.coarsened().powi(2)) as u64;
        }
        // Tiles out of sight keep their limits, which this frame does not meet.
        shortfall.tiles = tiles.iter().copied().filter(|id| self.rates.shows(*id)).collect();
        shortfall.lines = lines.iter().copied().filter(|id| self.rates.shows(*id)).collect();
        shortfall.edges = edges.iter().copied().filter(|id| self.rates.shows_edge(*id)).collect();
        shortfall.if_any()
    }
}

/// What no job reads between steps.
fn own<T>(shared: &mut Arc<T>) -> &mut T {
    Arc::get_mut(shared).expect("one owner between steps")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::live::draft::GroupBand;
    use crate::frame::plan::limits::PlanLimits;
    use crate::frame::plan::make::completed;
    use crate::model::{ModelBuilder, shapes};
    use crate::prepare::{PrepareOptions, prepare};
    use crate::view::{Camera, CameraPath, Picture};
    use glam::{DAffine3, DVec3};
    use std::time::Duration;

    /// Shapes, each placed along a row that leads away from the origin.
    fn rows() -> Arc<Prepared> {
        let mut model = ModelBuilder::new("rows");
        for (row, name) in (0..).zip(["box", "torus", "washer", "flower", "wave", "sphere"]) {
            let part = model.part(shapes::by_name(name).expect("a shape").parts.swap_remove(0));
            for place in 0..5 {
                let place = DVec3::new(60.0 * f64::from(row), 90.0 * f64::from(place), 0.0);
                model.place(part, DAffine3::from_translation(place));
            }
        }
        Arc::new(prepare(model.finish().expect("a model"), &PrepareOptions::DEFAULT).expect("within the limits"))
    }

    /// The groups that are looked at in a flight of views, and all that are seen. Each plan is compared with one in
    /// which no group is judged.
    fn compare(prepared: &Arc<Prepared>, options: &PlannerOptions, flight: &[Vec<View>]) -> [u32; 2] {
        let new = || Planner::new(Arc::clone(prepared), options);
        let (mut grouped, mut single) = (new(), new());
        let mut placed = PlacedInstances::of(prepared);
        let mut looked = [0; 2];
        for (k, views) in flight.iter().enumerate() {
            if k % 9 == 0 {
                let row = k % placed.instances().len();
                let lifted = DAffine3::from_translation(DVec3::Z) * placed.instances()[row].transform;
                placed.move_to(row, lifted);
            }
            grouped.plan(&mut placed, views);
            for part in &mut own(&mut single.rates).parts {
                part.groups.fill(GroupBand::NONE);
            }
            single.plan(&mut placed, views);
            assert_eq!(grouped.changes(), single.changes(), "frame {k}");
            assert!(grouped.last() == single.last(), "frame {k}");
            for (looked, planner) in looked.iter_mut().zip([&grouped, &single]) {
                let ranges = planner.rates.parts.iter().flat_map(|part| &part.seen.0);
                *looked += ranges.map(|range| range.open.count_ones()).sum::<u32>();
            }
        }
        looked
    }

    #[test]
    fn groups_decide_as_their_tiles_do() {
        const PICTURE: Picture = Picture { size: (800, 600), deviation_px: 0.5, size_px: None, angle: 0.5 };
        let prepared = rows();
        let around = CameraPath::Orbit.views(prepared.bounds.expect("a placed model"), 400, &PICTURE);
        let along = (0..200).map(|k| {
            let eye = DVec3::new(150.0, 2.5 * f64::from(k) - 100.0, 40.0);
            let camera = Camera { eye, ..around[0].camera };
            View { camera: Camera { forward: DVec3::new(0.3, 1.0, -0.1).normalize(), ..camera }, ..around[0] }
        });
        // Every other frame has a second view, in which another part of the scene is large.
        let second = |k: usize| around[(7 * k + 100) % around.len()];
        let views = around.iter().copied().chain(along).enumerate();
        let flight: Vec<Vec<View>> = views.map(|(k, view)| [view, second(k)][..1 + k % 2].to_vec()).collect();
        let [open, all] = compare(&prepared, &PlannerOptions::DEFAULT, &flight);
        assert!(all > 1000 && 2 * open < all, "{open} of {all} groups were looked at");

        // Changes that wait, terms that limits make coarser, and tiles that the camera's side decides on.
        let options = PlannerOptions::DEFAULT;
        compare(&prepared, &options.with_budget(Some(Duration::from_micros(20))), &flight[..200]);
        compare(&prepared, &options.with_limits(PlanLimits::DEFAULT.with_triangles(2000)), &flight[..200]);
        compare(&prepared, &options.with_cull_back_faces(true), &flight[..200]);
    }

    #[test]
    fn parts_are_planned_once_a_view_shows_them() {
        const PICTURE: Picture = Picture { size: (800, 600), deviation_px: 0.5, size_px: None, angle: 0.5 };
        let prepared = rows();
        let all = CameraPath::Orbit.views(prepared.bounds.expect("a placed model"), 1, &PICTURE)[0];
        // Along the first row of parts, away from the others.
        let camera =
            Camera { eye: DVec3::new(0.0, -40.0, 0.0), forward: DVec3::new(-0.3, 1.0, 0.0).normalize(), ..all.camera };
        let few = View { camera, ..all };
        let mut placed = PlacedInstances::of(&prepared);
        let mut planner = Planner::new(Arc::clone(&prepared), &PlannerOptions::DEFAULT);
        let mut known = Vec::new();
        for (view, are_all) in [(few, false), (few, false), (all, true), (few, true)] {
            planner.plan(&mut placed, &[view]);
            let new = &planner.changes().parts;
            assert!(new.iter().all(|part| !known.contains(part)), "{new:?}, {known:?}");
            known.extend(new);
            let plan = Arc::clone(planner.last());
            for (row, (plan, part)) in plan.parts.iter().zip(&prepared.parts).enumerate() {
                assert!(plan.is_of(part) || plan.tiles.is_empty() && plan.edges.is_empty());
                assert_eq!(plan.is_of(part), known.contains(&PartId::new(row)), "part {row}");
            }
            assert!(!known.is_empty() && (known.len() == prepared.parts.len()) == are_all, "{known:?}");
            let whole = completed(&Alone, &plan, &prepared, &PlanLimits::DEFAULT);
            assert!(whole.parts.iter().zip(&prepared.parts).all(|(plan, part)| plan.is_of(part)));
            assert!(known.iter().all(|part| whole.parts[part.index()] == plan.parts[part.index()]));
            assert_eq!(Arc::ptr_eq(&whole, &plan), are_all);
        }
    }
}
