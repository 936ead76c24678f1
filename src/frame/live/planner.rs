//! Views, frame after frame -> plans that differ from the last one only where the views require it.
//!
//! Each tile has a step of density with hysteresis ([`rate`](super::rate)), for its bounding box. A tile that is close
//! to the eye or partly off-screen has a step for each of its sub-boxes instead. An edge takes the finest step of its
//! tiles; next to a tile with several steps, it has steps for its own boxes. Off-screen tiles keep their steps.

use super::culling::WORDS;
use super::defer;
use super::draft::{
    ChangedRows, NewTessellants, PLANNED, PlanDraft, RateChanges, SeenRange, Sights, TessellantUpdate, Touched,
    VisibleTiles, WantedRate,
};
use super::first;
use super::limited::{LimitStep, Limited};
use super::pages::{NewRows, PlanChanges, PlanPages, renewed};
use super::placed::{PlacedInstances, Shown};
use super::rate::{Rate, Terms};
use super::rates::{PartRates, PlannerOptions, Rates, lengthened};
use super::undo::{Undo, Whole};
use crate::control::{Alone, Call, Control, Jobs, chunks, map, map_with};
use crate::frame::plan::lattice::Lattices;
use crate::frame::plan::output::{EdgePolyline, PartPlan, Plan, TileLattice, cells};
use crate::frame::plan::tessellants::Tessellants;
use crate::model::{PartId, RowId};
use crate::prepare::Prepared;
use crate::view::View;
use smallvec::SmallVec;
use std::collections::BTreeMap;
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
    undo: Undo,
    touched: Touched,
    changed: ChangedRows,
    /// Views of the last plan, and the version of the instances.
    seen: SmallVec<[View; 2]>,
    placed: u64,
    /// Whether to plan again even if nothing moves.
    unfinished: bool,
    /// By how much the last change of common terms that limits caused multiplied the triangles, per step finer.
    growth: f64,
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
            options: *options,
        };
        let mut planner = Self {
            rates: Arc::new(rates),
            pages: PlanPages::default(),
            changes: PlanChanges::default(),
            limited: Limited::default(),
            undo: Undo::default(),
            touched: Touched::default(),
            changed: ChangedRows::default(),
            seen: SmallVec::new(),
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

    /// Switches to another model. Its part `p` is the one that was `from[p]`, and keeps its levels; a part that was
    /// none is planned once a view shows it. `from` has a row for each part, and names none twice. Limits start again:
    /// what they made coarser is planned as if it were new.
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
    fn begin(&mut self, call: Call<'_>, draft: &mut PlanDraft) -> Option<()> {
        let rates = own(&mut self.rates);
        let page = own(&mut draft.page);
        let is_bare = |row: &usize| !page.parts[*row].is_of(&rates.prepared.parts[*row]);
        let rows: Vec<usize> = draft.sights.parts().filter(is_bare).collect();
        if rows.is_empty() {
            return Some(());
        }
        let _span = tracing::trace_span!("begin").entered();
        let planned = first::begin(call, rates, &rows)?;
        for (row, plan) in rows.into_iter().zip(planned) {
            self.touched.stamps[row] = vec![0; plan.edges.len()];
            page.parts[row] = plan;
            draft.changes.parts.push(PartId::new(row));
        }
        Some(())
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
        /// Of a tile, besides its rate and lattice: band, term, counts, scales, its share of a group.
        const TILE: usize = 52;
        /// Of a tile and all of its LODs: bounding box, cone, its place in a group and its share of that.
        const BOXES: usize = 90;
        /// Of an edge, besides its rate and tessellants: term, stamp.
        const EDGE: usize = 7;
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
        self.seen[..] == *views && !self.unfinished
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
        let control = Control::default();
        self.plan_on(Call::new(&Alone, &control), placed, (views, shown));
        self.keep();
        &self.pages.last
    }

    /// As [`plan`](Self::plan), on the threads of a call, for views and what they may show. The plan does not depend on
    /// the number of threads. [`keep`](Self::keep) or [`revert`](Self::revert) comes before the next one.
    ///
    /// `None` once the call is cancelled: the plan is reverted.
    pub(crate) fn plan_on(
        &mut self,
        call: Call<'_>,
        placed: &PlacedInstances,
        (views, shown): (&[View], Shown),
    ) -> Option<&Arc<Plan>> {
        self.undo.whole = Some(self.whole());
        let has_moved = self.placed != placed.version();
        if !has_moved && self.has_settled_on(views) {
            self.changes = PlanChanges::default();
            return Some(&self.pages.last);
        }
        let _span = tracing::debug_span!("plan").entered();
        self.placed = placed.version();
        self.seen = SmallVec::from_slice(views);
        self.agree_on(views);

        let unusable = shown.views < views.len();
        let part_of = |instance: usize| placed.instances()[instance].part.index();
        let sights = Sights::of(shown.sights, self.rates.parts.len(), part_of);
        let mut draft = PlanDraft::new(self.pages.next(call.jobs), sights);
        if self.fill(call, &mut draft, views.len()).is_none() {
            self.touched.take();
            let (page, changes) = draft.finish(&mut self.changed);
            self.changes = PlanChanges::default();
            self.take_back(call.jobs, &changes.parts, Some(page));
            return None;
        }
        own(&mut draft.page).shortfall = self.limited.shortfall(&self.rates, unusable);
        let (page, changes) = draft.finish(&mut self.changed);
        self.pages.turn(page, &changes);
        self.undo.whole.iter_mut().for_each(|whole| whole.has_turned = true);
        self.changes = changes;
        Some(&self.pages.last)
    }

    /// Plans for so many views. `None` once cancelled: the draft has some of the changes then.
    fn fill(&mut self, call: Call<'_>, draft: &mut PlanDraft, views: usize) -> Option<()> {
        call.goes_on()?;
        self.begin(call, draft)?;
        let mut step = LimitStep::default();
        loop {
            own(&mut draft.page).drawn.reset(views);
            self.see(call, draft)?;
            self.look(call, draft)?;
            self.defer(call, draft)?;
            self.apply(call, draft)?;
            self.tessellate(call, draft)?;
            self.unfinished = draft.changes.deferred > 0;
            if own(&mut self.rates).fits(&mut step, &mut self.growth, self.unfinished) {
                return Some(());
            }
        }
    }

    /// Makes the last plan history: it can no longer be reverted.
    pub(crate) fn keep(&mut self) {
        let parts = &mut own(&mut self.rates).parts;
        self.changes.parts.iter().for_each(|part| parts[part.index()].is_new = false);
        self.undo.keep();
    }

    /// Takes the last plan back, unless it is kept: later ones do not depend on it. Cost: less than that of the plan.
    pub(crate) fn revert(&mut self, jobs: &dyn Jobs) {
        let changes = std::mem::take(&mut self.changes);
        let has_turned = self.undo.whole.as_ref().is_some_and(|whole| whole.has_turned);
        let page = has_turned.then(|| self.pages.turn_back());
        self.take_back(jobs, &changes.parts, page);
    }

    /// Takes back a plan, which planned these parts first. `page`: its page, which is not the last one.
    fn take_back(&mut self, jobs: &dyn Jobs, parts: &[PartId], page: Option<Arc<Plan>>) {
        let Some(whole) = self.undo.whole.take() else { return };
        let _span = tracing::trace_span!("take back").entered();
        let rates = own(&mut self.rates);
        for part in parts.iter().map(|part| part.index()) {
            // Boxes do not depend on what views show.
            let boxes = std::mem::take(&mut rates.parts[part].boxes);
            rates.parts[part] = PartRates { boxes, ..PartRates::default() };
            self.touched.stamps[part] = Vec::new();
        }
        if !parts.is_empty() {
            self.limited.forget(parts);
        }
        self.undo.revert(rates, &mut self.limited);
        if let Some(page) = page {
            let Rates { prepared, parts: of, .. } = rates;
            let NewRows { lattices, edges } = &self.pages.new;
            for (p, t, [_, old]) in lattices.iter().rev() {
                if of[*p].is_planned() {
                    of[*p].set_cells(*t, cells(old));
                }
            }
            for (p, k, [new, old]) in edges.iter().rev() {
                if of[*p].is_planned() {
                    let longer = lengthened(&prepared.parts[*p], *k, [new, old]);
                    longer.for_each(|(tile, by)| of[*p].lengthen(tile.index(), by));
                }
            }
            self.pages.take_back(jobs, parts, page);
        }
        let rates = own(&mut self.rates);
        (rates.terms, rates.term) = (whole.terms, whole.term);
        (self.seen, self.placed) = (whole.seen, whole.placed);
        (self.unfinished, self.growth) = (whole.unfinished, whole.growth);
    }

    /// The state of the last plan as a whole.
    fn whole(&self) -> Whole {
        let Rates { terms, term, .. } = *self.rates;
        let Self { placed, unfinished, growth, .. } = *self;
        Whole { terms, term, seen: self.seen.clone(), placed, unfinished, growth, has_turned: false }
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
    fn see(&mut self, call: Call<'_>, draft: &mut PlanDraft) -> Option<()> {
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
        let (rates, sights, control) = (Arc::clone(&self.rates), Arc::clone(&draft.sights), call.control.clone());
        let mut ranges = map(call.jobs, ranges, move |mut range| {
            if !control.is_cancelled() {
                rates.see(&mut range, &sights);
            }
            range
        });
        let Rates { parts, shown, .. } = own(&mut self.rates);
        for VisibleTiles { part, range, seen, .. } in &mut ranges {
            parts[*part].seen.0[*range] = std::mem::take(seen);
        }
        shown.retain(|&part| parts[part].seen.shows_any());
        call.goes_on()?;
        let sights = &draft.sights;
        let rows = ranges.iter().flat_map(|tiles| {
            let of_sight = tiles.sights.iter().zip(tiles.bits.chunks_exact(WORDS));
            of_sight.map(|(&s, bits)| (&sights.of_part(tiles.part)[s as usize], tiles.range, bits))
        });
        let mut rows: Vec<_> = rows.map(|(sight, range, bits)| (sight.view, sight.instance, range, bits)).collect();
        rows.sort_unstable_by_key(|&(view, instance, range, _)| (view, instance, range));
        let drawn = &mut own(&mut draft.page).drawn;
        rows.into_iter().for_each(|(view, instance, range, bits)| drawn.push(view, instance, range * WORDS, bits));
        Some(())
    }

    /// Finds the drawn tiles whose rate should change.
    fn look(&mut self, call: Call<'_>, draft: &mut PlanDraft) -> Option<()> {
        let _span = tracing::trace_span!("look").entered();
        let (rates, sights, control) = (Arc::clone(&self.rates), Arc::clone(&draft.sights), call.control.clone());
        let rows = rates.shown.iter().flat_map(|&p| rates.parts[p].seen.open().map(move |groups| (p, groups)));
        let rows: Vec<(usize, (usize, u32))> = rows.collect();
        let found = map(call.jobs, rows, move |(part, groups)| {
            let mut wanted = RateChanges::default();
            if control.is_cancelled() {
                return wanted;
            }
            rates.look_at(part, groups, sights.of_part(part), &mut wanted);
            if rates.options.budget.is_some() {
                wanted.sort();
            }
            wanted
        });
        let (parts, undo) = (&mut own(&mut self.rates).parts, &mut self.undo);
        for RateChanges { rates, near, groups, estimates } in call.until_cancelled(found) {
            rates.into_iter().for_each(|list| draft.want(list));
            draft.near.extend(near);
            groups.into_iter().for_each(|(p, group, band)| parts[p].groups[group] = band);
            estimates.into_iter().for_each(|(p, t, estimate)| undo.set_estimate(&mut parts[p], (p, t), estimate));
        }
        call.goes_on()
    }

    /// Defers the changes that exceed the budget.
    fn defer(&self, call: Call<'_>, draft: &mut PlanDraft) -> Option<()> {
        let Some(budget) = self.rates.options.budget else { return Some(()) };
        let _span = tracing::trace_span!("defer").entered();
        let wanted = std::mem::take(&mut draft.wanted);
        let (now, deferred) = defer::within(call, budget, wanted, (&self.rates.prepared, &draft.page))?;
        draft.changes.deferred = deferred as u32;
        draft.wanted = chunks(call.jobs, now, PLANNED);
        Some(())
    }

    /// Plans the lattices of the tiles that change, and marks their edges.
    fn apply(&mut self, call: Call<'_>, draft: &mut PlanDraft) -> Option<()> {
        let _span = tracing::trace_span!("lattices").entered();
        let (rates, page, control) = (Arc::clone(&self.rates), Arc::clone(&draft.page), call.control.clone());
        let (wanted, mut spaces) = (std::mem::take(&mut draft.wanted), Vec::<Lattices>::new());
        let made = map_with(call.jobs, &mut spaces, wanted, move |lattices, wanted| -> Vec<_> {
            let mut made = |wanted: WantedRate| (rates.new_lattice(&wanted, &page, lattices), wanted);
            wanted.into_iter().map_while(|wanted| (!control.is_cancelled()).then(|| made(wanted))).collect()
        });
        let Self { rates, pages, touched, limited, undo, changed, .. } = self;
        let Rates { prepared, parts, term, .. } = own(rates);
        let page = own(&mut draft.page);
        for (new, wanted) in call.until_cancelled(made).flatten() {
            let (p, t) = (wanted.part, wanted.tile);
            let rates = &mut parts[p];
            if let Some((cells, [made, again])) = new.made {
                rates.set_cells(t, cells);
                let old = std::mem::replace(&mut page.parts[p].tiles[t], made);
                pages.new.lattices.push((p, t, [again, old]));
                changed.tiles.add(p, t);
            }
            undo.set_tile((rates, limited), (wanted, *term), new.kept);
            new.touches.into_iter().for_each(|(edge, why)| touched.add(p, edge, why));
        }
        for (p, t) in draft.near.drain(..) {
            let uses = prepared.parts[p].tiles[t].loops.iter().flatten();
            uses.for_each(|u| touched.add(p, u.edge, 0));
        }
        call.goes_on()
    }

    /// Plans the tessellants of the marked edges.
    fn tessellate(&mut self, call: Call<'_>, draft: &mut PlanDraft) -> Option<()> {
        let _span = tracing::trace_span!("tessellants").entered();
        let (rates, page, sights) = (Arc::clone(&self.rates), Arc::clone(&draft.page), Arc::clone(&draft.sights));
        let (touched, control) = (chunks(call.jobs, self.touched.take(), PLANNED), call.control.clone());
        let made = map(call.jobs, touched, move |edges| -> Vec<_> {
            let mut tessellants = Tessellants::default();
            let mut of_edge = |(p, e, why): (usize, RowId, u8)| {
                ((p, e), rates.new_tessellants((p, e), why, (&page, sights.of_part(p)), &mut tessellants))
            };
            edges.into_iter().map_while(|edge| (!control.is_cancelled()).then(|| of_edge(edge))).collect()
        });
        let Self { rates, pages, limited, undo, changed, .. } = self;
        let Rates { parts, term, .. } = own(rates);
        let page = own(&mut draft.page);
        for ((p, e), new) in call.until_cancelled(made).flatten() {
            let Some(NewTessellants { rate, made }) = new else { continue };
            let (rates, k) = (&mut parts[p], e.index());
            let planned = made.as_ref().map(|made| (*term, made.kept));
            undo.set_edge((rates, limited), ((PartId::new(p), e), rate), planned);
            let Some(TessellantUpdate { line: Some([line, again]), tiles, .. }) = made else { continue };
            let old = std::mem::replace(&mut page.parts[p].edges[k], line);
            pages.new.edges.push((p, k, [again, old]));
            changed.edges.add(p, k);
            for (tile, longer) in tiles {
                changed.tiles.add(p, tile.index());
                rates.lengthen(tile.index(), longer);
            }
        }
        call.goes_on()
    }
}

/// What no job reads between steps.
fn own<T>(shared: &mut Arc<T>) -> &mut T {
    Arc::get_mut(shared).expect("one owner between steps")
}

#[cfg(test)]
mod tests;
