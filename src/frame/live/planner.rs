//! Views, frame after frame -> plans that differ from the last one only where the views require it.
//!
//! Each tile has a step of density with hysteresis ([`rate`](super::rate)), for its bounding box. A tile that is close
//! to the eye or partly off-screen has a step for each of its sub-boxes instead. An edge takes the finest step of its
//! tiles; next to a tile with several steps, it has steps for its own boxes. Off-screen tiles keep their steps.

use super::culling::{InstanceSight, PartBoxes};
use super::draft::{
    ANEW, BESIDE_NEW, NewLattice, NewTessellants, PLANNED, PlanDraft, RateChanges, TILES, TessellantUpdate, Touched,
    UNSEEN, VisibleTiles, WantedRate, rows,
};
use super::options::PlannerOptions;
use super::pages::{PlanChanges, PlanPages};
use super::rate::{Rate, Step, Terms, band, step};
use super::resync::{LineHistory, Turns, owner};
use crate::control::{Alone, Jobs, each_mut, map_chunks};
use crate::frame::plan::budget::{Budget, cells, predicted};
use crate::frame::plan::density::FollowLines;
use crate::frame::plan::lattice::{lattice, places};
use crate::frame::plan::limits::Shortfall;
use crate::frame::plan::make::plan_parts;
use crate::frame::plan::output::Plan;
use crate::frame::plan::tessellants::{Tessellants, turns_more_than_bends};
use crate::frame::tolerance::box_tolerance::PartTolerance;
use crate::frame::tolerance::object_tolerance::Tolerance;
use crate::frame::tolerance::part_camera::PixelScale;
use crate::mesh::{SceneInstance, ScenePart};
use crate::model::{PartId, RowId, SurfaceKind, TileId};
use crate::prepare::Prepared;
use crate::prepare::internals::BoundingBox;
use crate::view::View;
use glam::DAffine3;
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

/// Split the level of a tile into per-box levels when they differ by more than this factor. Each of them can trigger a
/// rebuild: at 1.6 the trimmed teapot has 5 % fewer triangles, and twice as many tiles are rebuilt.
const APART: f64 = 4.0;
/// Merge the per-box levels back into one when they differ by less than this factor.
const TOGETHER: f64 = 3.0;

/// State of one part.
struct PartRates {
    boxes: PartBoxes,
    tiles: Vec<Rate>,
    /// Densities for which each tile keeps its step. (0, 0) for tiles with a step per sub-box, or none yet.
    bands: Vec<(f64, f64)>,
    edges: Vec<Rate>,
    /// The `term` with which each tile and edge was last planned; 0: never.
    tile_terms: Vec<u32>,
    edge_terms: Vec<u32>,
    /// Tiles and edges whose lines also depend on history.
    kept: LineHistory,
    /// Number of cells of each tile.
    cells: Vec<u64>,
    /// What the views of the current frame show of each tile.
    seen: Vec<PixelScale>,
}

/// Makes the plans of consecutive frames.
///
/// Deterministic: the same options, views and instances, frame by frame, give the same plans, bit for bit.
pub struct Planner {
    prepared: Arc<Prepared>,
    options: PlannerOptions,
    parts: Vec<PartRates>,
    terms: Terms,
    /// Number of changes of `terms`. Plans made with an earlier one are outdated.
    term: u32,
    turns: Turns,
    pages: PlanPages,
    changes: PlanChanges,
    limited: Limited,
    touched: Touched,
    /// All tiles, by part and range.
    rows: Vec<(usize, Range<usize>)>,
    /// Views and placements of the last plan.
    seen: Vec<View>,
    placed: Vec<(PartId, DAffine3)>,
    /// Whether to plan again even if nothing moves.
    unfinished: bool,
}

/// Tiles and edges that limits make coarser than required.
#[derive(Default)]
struct Limited {
    tiles: BTreeSet<(PartId, TileId)>,
    lines: BTreeSet<(PartId, TileId)>,
    edges: BTreeSet<(PartId, RowId)>,
}

fn mark<T: Ord>(set: &mut BTreeSet<T>, row: T, is_in: bool) {
    if is_in {
        set.insert(row);
    } else if !set.is_empty() {
        set.remove(&row);
    }
}

impl Planner {
    /// Starts with the coarsest plan. Cost: a few microseconds per tile and per edge.
    #[must_use]
    pub fn new(prepared: Arc<Prepared>, options: &PlannerOptions) -> Self {
        let coarsest = Tolerance { chord: f64::INFINITY, angle: f64::INFINITY, max_edge: None };
        let everywhere = |part: &ScenePart| PartTolerance::everywhere(&coarsest, part.radius);
        let asked: Vec<PartTolerance> = prepared.scene.parts.iter().map(everywhere).collect();
        let plan = plan_parts(&Alone, &prepared, &asked, &options.limits, 0);
        let parts = prepared.parts.iter().zip(&plan.parts).map(|(part, plan)| PartRates {
            boxes: PartBoxes::of(part),
            tiles: vec![Rate::Even(None); part.tiles.len()],
            bands: vec![(0.0, 0.0); part.tiles.len()],
            edges: vec![Rate::Even(None); part.edges.len()],
            tile_terms: vec![0; part.tiles.len()],
            edge_terms: vec![0; part.edges.len()],
            kept: LineHistory::none(part),
            cells: plan.tiles.iter().map(|lattice| cells(lattice)).collect(),
            seen: vec![UNSEEN; part.tiles.len()],
        });
        Self {
            parts: parts.collect(),
            terms: Terms { angle: f64::INFINITY, size: None, coarser: 0 },
            term: 0,
            turns: Turns::of(options.lines),
            pages: PlanPages { last: Arc::new(plan), spare: None, lattices: Vec::new(), edges: Vec::new() },
            changes: PlanChanges::default(),
            limited: Limited::default(),
            touched: Touched {
                stamps: prepared.parts.iter().map(|part| vec![0; part.edges.len()]).collect(),
                rows: Vec::new(),
            },
            rows: rows(&prepared),
            seen: Vec::new(),
            placed: Vec::new(),
            unfinished: true,
            options: *options,
            prepared,
        }
    }

    /// The last plan; before the first call of [`plan`](Self::plan), the coarsest one.
    #[must_use]
    pub fn last(&self) -> &Arc<Plan> {
        &self.pages.last
    }

    /// Differences between the last plan and the one before.
    #[must_use]
    pub fn changes(&self) -> &PlanChanges {
        &self.changes
    }

    /// Makes the plan for these views of `instances`, whose parts index the prepared model. Where several views or
    /// instances show the same place of a part, the strictest tolerance applies.
    ///
    /// All tiles in [`Plan::drawn`] keep the tolerance, up to [`Plan::shortfall`] and [`PlanChanges::deferred`].
    /// Views that are invalid (see [`plan_for_view`](crate::frame::plan_for_view())), or allow no error at all, draw
    /// nothing and do not count; instances of unknown parts are skipped.
    ///
    /// Cost: about 20 ns per tile, instance and view, and a few microseconds per tile and edge that changes. If nothing
    /// moved, one comparison of the arguments with the last ones.
    pub fn plan(&mut self, instances: &[SceneInstance], views: &[View]) -> &Arc<Plan> {
        self.plan_on(&Alone, instances, views)
    }

    /// As [`plan`](Self::plan), on the threads of `jobs`. The plan does not depend on their number.
    pub fn plan_on(&mut self, jobs: &dyn Jobs, instances: &[SceneInstance], views: &[View]) -> &Arc<Plan> {
        let placed = instances.iter().map(|i| (i.part, i.transform));
        let is_still = self.seen == views && self.placed.iter().copied().eq(placed.clone());
        self.turns.pass(is_still);
        if is_still && !self.unfinished && !self.turns.are_left() {
            self.changes = PlanChanges::default();
            return &self.pages.last;
        }
        let _span = tracing::debug_span!("plan").entered();
        self.placed.clear();
        self.placed.extend(placed);
        self.seen.clear();
        self.seen.extend_from_slice(views);
        self.agree_on(views);

        let mut next = self.pages.next();
        let page = Arc::get_mut(&mut next).expect("a page that was just made has one owner");
        let tiles = |i: &SceneInstance| self.parts.get(i.part.index()).map_or(0, |part| part.tiles.len());
        page.drawn.reset(views.len(), &instances.iter().map(tiles).collect::<Vec<_>>());
        let (sights, unusable) = self.sights(instances, views);
        let mut draft =
            PlanDraft { page, sights, wanted: Vec::new(), near: Vec::new(), changes: PlanChanges::default() };
        self.see(jobs, &mut draft);
        loop {
            self.look(jobs, &mut draft);
            self.defer(&mut draft);
            self.apply(jobs, &mut draft);
            self.tessellate(jobs, &mut draft);
            if self.fits() {
                break;
            }
        }
        let mut changes = std::mem::take(&mut draft.changes);
        for list in [&mut changes.tiles, &mut changes.lattices] {
            list.sort_unstable();
            list.dedup();
        }
        changes.edges.sort_unstable();
        changes.edges.dedup();
        page.shortfall = self.shortfall(unusable);
        self.unfinished |= changes.deferred > 0;
        self.pages.turn(next, &changes);
        self.changes = changes;
        &self.pages.last
    }

    /// Sets the terms common to all valid views: the strictest angle and edge length.
    fn agree_on(&mut self, views: &[View]) {
        let valid = || views.iter().filter(|view| view.usable_lens().is_some());
        let strictest = |of: &dyn Fn(&View) -> Option<f64>| valid().filter_map(of).reduce(f64::min);
        let terms = Terms {
            angle: strictest(&|view| Some(view.angle)).unwrap_or(f64::INFINITY),
            size: strictest(&|view| view.size_px.map(|size| size / view.deviation_px)),
            coarser: self.terms.coarser,
        };
        if terms != self.terms || self.term == 0 {
            self.terms = terms;
            self.term += 1;
        }
    }

    /// The instances of each part as the views see them, and whether any view is invalid.
    fn sights(&self, instances: &[SceneInstance], views: &[View]) -> (Vec<Vec<InstanceSight>>, bool) {
        let mut sights: Vec<Vec<InstanceSight>> = vec![Vec::new(); self.parts.len()];
        let mut unusable = false;
        for (v, view) in views.iter().enumerate() {
            let Some(lens) = view.usable_lens() else {
                unusable = true;
                continue;
            };
            for (i, instance) in instances.iter().enumerate() {
                if let Some(sights) = sights.get_mut(instance.part.index()) {
                    let sight = view.sight(lens, instance).weighed(1.0 / view.deviation_px);
                    sights.push(InstanceSight { view: v, instance: i, sight });
                }
            }
        }
        (sights, unusable)
    }

    /// Finds the drawn tiles.
    fn see(&mut self, jobs: &dyn Jobs, draft: &mut PlanDraft<'_>) {
        let mut rows: Vec<VisibleTiles<'_>> = Vec::with_capacity(self.rows.len());
        let mut boxes: Vec<&PartBoxes> = Vec::with_capacity(self.parts.len());
        for (part, rates) in self.parts.iter_mut().enumerate() {
            boxes.push(&rates.boxes);
            let chunks = rates.seen.chunks_mut(TILES).enumerate();
            rows.extend(chunks.map(|(k, seen)| VisibleTiles { part, first: k * TILES, seen, drawn: Vec::new() }));
        }
        let (sights, cull) = (&draft.sights, self.options.cull_back_faces);
        each_mut(jobs, &mut rows, |_, VisibleTiles { part, first, seen, drawn }| {
            seen.fill(UNSEEN);
            let words = seen.len().div_ceil(64);
            drawn.resize(words * sights[*part].len(), 0);
            for (InstanceSight { sight, .. }, drawn) in sights[*part].iter().zip(drawn.chunks_mut(words)) {
                boxes[*part].seen_by(sight, cull, *first..*first + seen.len(), |t, now| {
                    let k = t - *first;
                    drawn[k / 64] |= 1 << (k % 64);
                    seen[k] = PixelScale { most: seen[k].most.max(now.most), least: seen[k].least.max(now.least) };
                });
            }
        });
        for VisibleTiles { part, first, seen, drawn } in rows {
            let words = seen.len().div_ceil(64);
            for (InstanceSight { view, instance, .. }, drawn) in sights[part].iter().zip(drawn.chunks(words)) {
                draft.page.drawn.set_words(*view, *instance, first / 64, drawn);
            }
        }
    }

    /// Finds the drawn tiles whose rate should change.
    fn look(&mut self, jobs: &dyn Jobs, draft: &mut PlanDraft<'_>) {
        let sights = &draft.sights;
        let found = map_chunks(jobs, &self.rows, 1, |rows| {
            let mut wanted = RateChanges::default();
            for (part, tiles) in rows {
                self.look_at(*part, tiles.clone(), &sights[*part], &mut wanted);
            }
            wanted
        });
        for RateChanges { rates, near, due } in found {
            draft.wanted.extend(rates);
            draft.near.extend(near);
            due.into_iter().for_each(|(p, t)| self.parts[p].kept.due[t] = true);
        }
    }

    fn look_at(&self, p: usize, tiles: Range<usize>, sights: &[InstanceSight], wanted: &mut RateChanges) {
        let PartRates { tiles: rates, bands, tile_terms, kept, seen, .. } = &self.parts[p];
        let part = &self.prepared.parts[p];
        for t in tiles {
            let PixelScale { most, least } = seen[t];
            if most < 0.0 {
                continue;
            }
            let due = kept.is_due(&self.turns, part, (p, t), |tile| seen[tile].most >= 0.0);
            if due {
                wanted.due.push((p, t));
            }
            let planned = tile_terms[t] == self.term;
            let (low, high) = bands[t];
            if planned && !due && most >= low && most <= high && most <= APART * least {
                continue;
            }
            let before = &rates[t];
            let even = most <= least * if matches!(before, Rate::Even(_)) { APART } else { TOGETHER };
            let (rate, band) = if even {
                let step = step(most, before.step(0));
                (Rate::Even(step), band(step))
            } else {
                wanted.near.push((p, t));
                let face = &part.faces[part.face_of(&part.tiles[t])];
                // A plane has one cell at any density. Its edges may bend, but they have their own boxes.
                let flat = face.kind == SurfaceKind::Plane && self.terms.size.is_none();
                let boxes = || places(face, &part.tiles[t]).filter(|_| !flat);
                if planned && !due && before.is_each() && holds(boxes(), before, sights) {
                    continue;
                }
                (Rate::Each(each(boxes(), before, sights)), (0.0, 0.0))
            };
            if !planned || due || rate != *before {
                let finer = |to: &Rate, from: &Rate| match (to.finest(), from.finest()) {
                    (Some(to), Some(from)) => f64::from(to) - f64::from(from),
                    _ => f64::INFINITY,
                };
                let urgency = match planned {
                    true if rate == *before => 0.0,
                    true => finer(&rate, before),
                    false => f64::INFINITY,
                };
                let chord = 1.0 / most;
                wanted.rates.push(WantedRate { urgency, part: p, tile: t, rate, band, chord, anew: due });
            }
        }
    }

    /// Defers the changes that exceed the budget, the least urgent ones.
    ///
    /// A deferred tile keeps its rate. The rates of edges follow from those of tiles, so the plan is always closed.
    fn defer(&self, draft: &mut PlanDraft<'_>) {
        draft.changes.deferred = 0;
        let Some(budget) = self.options.budget else { return };
        draft.wanted.sort_by(|a, b| b.urgency.total_cmp(&a.urgency).then((a.part, a.tile).cmp(&(b.part, b.tile))));
        let mut left = budget.as_secs_f64() * 1e9;
        let mut made: BTreeSet<(usize, usize)> = BTreeSet::new();
        let kept = draft.wanted.iter().take_while(|wanted| {
            let part = &self.prepared.parts[wanted.part];
            let uses = part.tiles[wanted.tile].loops.iter().flatten();
            let beside = uses.flat_map(|u| part.edges[u.edge.index()].uses.iter().map(|place| place.tile.index()));
            for tile in beside.chain([wanted.tile]) {
                if made.insert((wanted.part, tile)) {
                    let growth =
                        if tile == wanted.tile { (0.5 * wanted.urgency).clamp(-20.0, 20.0).exp2() } else { 1.0 };
                    left -= predicted(&draft.page.parts[wanted.part], &part.tiles[tile], tile, growth);
                }
            }
            left > 0.0
        });
        // Always at least one, or a small budget would never make progress.
        let kept = kept.count().max(1).min(draft.wanted.len());
        draft.changes.deferred = (draft.wanted.len() - kept) as u32;
        draft.wanted.truncate(kept);
    }

    /// Plans the lattices of the tiles that change, and marks their edges.
    fn apply(&mut self, jobs: &dyn Jobs, draft: &mut PlanDraft<'_>) {
        let page = &*draft.page;
        let made = map_chunks(jobs, &draft.wanted, PLANNED, |wanted| -> Vec<NewLattice> {
            wanted.iter().map(|wanted| self.new_lattice(wanted, page)).collect()
        });
        let touched = &mut self.touched;
        for (wanted, NewLattice { made, kept, follows }) in draft.wanted.drain(..).zip(made.into_iter().flatten()) {
            let WantedRate { part: p, tile: t, rate, band, anew, .. } = wanted;
            let (part, rates) = (&self.prepared.parts[p], &mut self.parts[p]);
            let id = (PartId::new(p), TileId(t as u32));
            (rates.kept.tiles[t], rates.kept.due[t]) = (follows, false);
            mark(&mut self.limited.tiles, id, !kept.cells);
            mark(&mut self.limited.lines, id, !kept.lines);
            let why = if made.is_some() { BESIDE_NEW } else { 0 };
            if let Some(made) = made {
                rates.cells[t] = cells(&made);
                draft.page.parts[p].tiles[t] = made;
                draft.changes.lattices.push(id);
                draft.changes.tiles.push(id);
            }
            (rates.tiles[t], rates.bands[t], rates.tile_terms[t]) = (rate, band, self.term);
            let seen = &rates.seen;
            let with_it = |e: RowId| anew && owner(&part.edges[e.index()], |t| seen[t].most >= 0.0) == Some(t);
            for u in part.tiles[t].loops.iter().flatten() {
                touched.add(p, u.edge, why | if with_it(u.edge) { ANEW } else { 0 });
            }
        }
        for (p, t) in draft.near.drain(..) {
            let uses = self.prepared.parts[p].tiles[t].loops.iter().flatten();
            uses.for_each(|u| touched.add(p, u.edge, 0));
        }
    }

    fn new_lattice(&self, wanted: &WantedRate, page: &Plan) -> NewLattice {
        let WantedRate { part: p, tile: t, rate, chord, anew, .. } = wanted;
        let (part, rates) = (&self.prepared.parts[*p], &self.parts[*p]);
        let (tile, old) = (&part.tiles[*t], &page.parts[*p].tiles[*t]);
        let face = &part.faces[part.face_of(tile)];
        let need = self.terms.need(rate, places(face, tile).len(), self.prepared.scene.parts[*p].radius);
        let before = self.turns.follow(&**old, *anew || rates.tile_terms[*t] != self.term);
        let cells_per_tile = Budget::of(&self.options.limits, 0).cells_per_tile;
        let (mut made, kept) =
            lattice(face, tile, &need, 1.0, cells_per_tile, before.as_ref().map(|b| b as &dyn FollowLines));
        let is_plane = face.kind == SurfaceKind::Plane;
        // A plane's lattice does not depend on the chord, but the chord decides whether a face without triangles is
        // thin or lost.
        made.chord = Terms::settled(if is_plane { *chord } else { made.chord });
        // Triangles measured against a stricter chord still hold. On a plane nothing is measured, so any finite
        // chord will do.
        let holds = old.chord <= made.chord || is_plane && old.chord.is_finite();
        let as_before = old.us == made.us && old.vs == made.vs && holds;
        NewLattice { made: (!as_before).then(|| Arc::new(made)), kept, follows: before.is_some() }
    }

    /// Plans the tessellants of the marked edges.
    fn tessellate(&mut self, jobs: &dyn Jobs, draft: &mut PlanDraft<'_>) {
        let touched = self.touched.take();
        let (page, sights) = (&*draft.page, &draft.sights);
        let made = map_chunks(jobs, &touched, PLANNED, |edges| -> Vec<Option<NewTessellants>> {
            let mut tessellants = Tessellants::default();
            let of_edge = |&(p, e, why): &(usize, RowId, u8)| {
                self.new_tessellants((p, e), why, (page, &sights[p]), &mut tessellants)
            };
            edges.iter().map(of_edge).collect()
        });
        for ((p, e, _), new) in touched.into_iter().zip(made.into_iter().flatten()) {
            let Some(NewTessellants { rate, made }) = new else { continue };
            let (rates, k) = (&mut self.parts[p], e.index());
            rates.edges[k] = rate;
            let Some(TessellantUpdate { line, kept, follows }) = made else { continue };
            (rates.kept.edges[k], rates.edge_terms[k]) = (follows, self.term);
            let id = PartId::new(p);
            mark(&mut self.limited.edges, (id, e), !kept);
            if let Some(line) = line {
                draft.page.parts[p].edges[k] = line;
                draft.changes.edges.push((id, e));
                let uses = &self.prepared.parts[p].edges[k].uses;
                draft.changes.tiles.extend(uses.iter().map(|place| (id, place.tile)));
            }
        }
    }

    /// `None` if the old tessellants hold at the old rate.
    fn new_tessellants(
        &self,
        (p, e): (usize, RowId),
        why: u8,
        (page, sights): (&Plan, &[InstanceSight]),
        tessellants: &mut Tessellants,
    ) -> Option<NewTessellants> {
        let (part, rates) = (&self.prepared.parts[p], &self.parts[p]);
        let (edge, k) = (&part.edges[e.index()], e.index());
        let beside = || edge.uses.iter().map(|place| &rates.tiles[place.tile.index()]);
        let anew = why & ANEW > 0;
        let planned = why & BESIDE_NEW == 0 && !anew && rates.edge_terms[k] == self.term;
        let page = &page.parts[p];
        let single = |tile: TileId| page.tiles[tile.0 as usize].cells() == (1, 1);
        if planned && edge.straight && self.terms.size.is_none() && edge.uses.iter().all(|place| single(place.tile)) {
            return None;
        }
        let rate = if beside().any(Rate::is_each) {
            let (places, before) = (edge.bounds.places.iter(), &rates.edges[k]);
            if planned && before.is_each() && holds(places.clone(), before, sights) {
                return None;
            }
            Rate::Each(each(places, before, sights))
        } else {
            Rate::Even(beside().map(Rate::finest).max().flatten())
        };
        if planned && rates.edges[k] == rate {
            return None;
        }
        let radius = self.prepared.scene.parts[p].radius;
        let need = self.terms.need(&rate, edge.bounds.places.len(), radius);
        // If the angle alone decides, as for pins and holes at any distance, another chord gives the same tessellants.
        if let (true, Rate::Even(now), Rate::Even(before)) =
            (planned && need.tolerance.max_edge.is_none(), &rate, &rates.edges[k])
        {
            let finer = self.terms.need(&Rate::Even(*now.max(before)), 0, radius);
            if turns_more_than_bends(edge, &finer.tolerance) {
                return Some(NewTessellants { rate, made: None });
            }
        }
        let before = self.turns.follow(&*page.edges[k], anew || rates.edge_terms[k] != self.term);
        let (line, kept) =
            tessellants.polyline(edge, &page.tiles, &need, 1.0, before.as_ref().map(|b| b as &dyn FollowLines));
        let line = (*page.edges[k] != line).then(|| Arc::new(line));
        Some(NewTessellants { rate, made: Some(TessellantUpdate { line, kept, follows: before.is_some() }) })
    }

    /// Whether the drawn tiles are within the limits. If not, makes the terms one step coarser.
    fn fits(&mut self) -> bool {
        /// Steps after which everything is as coarse as angles allow, or nearly.
        const COARSEST: i16 = 128;
        let of_part = |part: &PartRates| -> u64 {
            let drawn = part.cells.iter().zip(&part.seen).filter(|(_, seen)| seen.most >= 0.0);
            drawn.map(|(cells, _)| cells).sum()
        };
        let spent: u64 = self.parts.iter().map(of_part).sum();
        let allowed = Budget::of(&self.options.limits, 0).left;
        self.unfinished = false;
        if spent > allowed && self.terms.coarser < COARSEST {
            self.terms.coarser += 1;
            self.term += 1;
            return false;
        }
        // One step finer may double the cells. At more than a quarter of the limit, steps could alternate forever.
        if self.terms.coarser > 0 && spent < allowed / 4 {
            self.terms.coarser -= 1;
            self.term += 1;
            self.unfinished = true;
        }
        true
    }

    fn shortfall(&self, unusable: bool) -> Option<Shortfall> {
        let Limited { tiles, lines, edges } = &self.limited;
        let mut shortfall = Shortfall::none(&self.options.limits);
        shortfall.unusable = unusable;
        shortfall.density = 1.0 / self.terms.coarsened();
        if self.terms.coarser > 0 {
            let drawn: u64 = self
                .parts
                .iter()
                .flat_map(|part| part.cells.iter().zip(&part.seen))
                .filter(|(_, s)| s.most >= 0.0)
                .map(|(c, _)| c)
                .sum();
            shortfall.needed = (2.0 * drawn as f64 * self.terms.coarsened().powi(2)) as u64;
        }
        shortfall.tiles = tiles.iter().copied().collect();
        shortfall.lines = lines.iter().copied().collect();
        shortfall.edges = edges.iter().copied().collect();
        shortfall.if_any()
    }
}

/// The step of each box, with hysteresis.
fn each<'a>(places: impl Iterator<Item = &'a BoundingBox>, before: &Rate, sights: &[InstanceSight]) -> Box<[Step]> {
    places.enumerate().map(|(k, place)| step(densest(place, sights), before.step(k))).collect()
}

/// Whether all boxes keep their steps.
fn holds<'a>(places: impl Iterator<Item = &'a BoundingBox>, before: &Rate, sights: &[InstanceSight]) -> bool {
    places.enumerate().all(|(k, place)| step(densest(place, sights), before.step(k)) == before.step(k))
}

fn densest(place: &BoundingBox, sights: &[InstanceSight]) -> f64 {
    sights.iter().map(|s| s.sight.pixels_per_length(place)).fold(0.0, f64::max)
}
