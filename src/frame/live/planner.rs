//! Views, frame after frame -> plans that differ from the last one only where the views require it.
//!
//! Each tile has a step of density with hysteresis ([`rate`](super::rate)), for its bounding box. A tile that is close
//! to the eye or partly off-screen has a step for each of its sub-boxes instead. An edge takes the finest step of its
//! tiles; next to a tile with several steps, it has steps for its own boxes. Off-screen tiles keep their steps.

use super::culling::{InstanceSight, PartBoxes};
use super::options::PlannerOptions;
use super::pages::{PlanChanges, PlanPages};
use super::rate::{Rate, Step, Terms, band, step};
use super::resync::{LineHistory, Turns, owner};
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

/// Off-screen, or culled.
const UNSEEN: PixelScale = PixelScale { most: -1.0, least: -1.0 };

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
    tessellants: Tessellants,
    touched: Touched,
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

/// Stamp of every edge in [`Touched`].
const TOUCHED: u8 = 1;
/// An adjacent lattice changed.
const BESIDE_NEW: u8 = 2;
/// All tessellants are replaced.
const ANEW: u8 = 4;

/// Edges to plan, each once however many tiles request it.
#[derive(Default)]
struct Touched {
    /// By part and edge: 0 if not among `rows`, else [`TOUCHED`] and the reasons.
    stamps: Vec<Vec<u8>>,
    rows: Vec<(usize, RowId)>,
}

impl Touched {
    fn add(&mut self, part: usize, edge: RowId, why: u8) {
        let stamp = &mut self.stamps[part][edge.index()];
        if *stamp == 0 {
            self.rows.push((part, edge));
        }
        *stamp |= TOUCHED | why;
    }

    /// Calls `each` with every edge and its stamp, and empties the set.
    fn drain(&mut self, mut each: impl FnMut(usize, RowId, u8)) {
        for (part, edge) in self.rows.drain(..) {
            let stamp = std::mem::take(&mut self.stamps[part][edge.index()]);
            each(part, edge, stamp);
        }
    }
}

/// A tile whose rate should change.
struct WantedRate {
    /// How many steps finer it should be. Infinite without a step so far, or if never planned with the current terms.
    urgency: f64,
    part: usize,
    tile: usize,
    rate: Rate,
    band: (f64, f64),
    /// The chord tolerance that the views require, in the part's own millimetres.
    chord: f64,
    /// Whether to replace all lines of the tile and of its edges.
    anew: bool,
}

/// The plan of the current frame.
struct PlanDraft<'a> {
    page: &'a mut Plan,
    sights: Vec<Vec<InstanceSight>>,
    wanted: Vec<WantedRate>,
    /// Drawn tiles with a step per sub-box. Their edges are checked box by box in every frame.
    near: Vec<(usize, usize)>,
    changes: PlanChanges,
}

impl Planner {
    /// Starts with the coarsest plan. Cost: a few microseconds per tile and per edge.
    #[must_use]
    pub fn new(prepared: Arc<Prepared>, options: &PlannerOptions) -> Self {
        let coarsest = Tolerance { chord: f64::INFINITY, angle: f64::INFINITY, max_edge: None };
        let everywhere = |part: &ScenePart| PartTolerance::everywhere(&coarsest, part.radius);
        let asked: Vec<PartTolerance> = prepared.scene.parts.iter().map(everywhere).collect();
        let plan = plan_parts(&prepared, &asked, &options.limits, 0);
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
            tessellants: Tessellants::default(),
            touched: Touched {
                stamps: prepared.parts.iter().map(|part| vec![0; part.edges.len()]).collect(),
                rows: Vec::new(),
            },
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
        loop {
            for part in 0..self.parts.len() {
                self.look(part, &mut draft);
            }
            self.defer(&mut draft);
            self.apply(&mut draft);
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

    /// Finds the drawn tiles of a part, and those of them whose rate should change.
    fn look(&mut self, p: usize, draft: &mut PlanDraft<'_>) {
        let PartRates { boxes, tiles, bands, tile_terms, kept, seen, .. } = &mut self.parts[p];
        seen.fill(UNSEEN);
        for InstanceSight { view, instance, sight } in &draft.sights[p] {
            boxes.seen_by(sight, self.options.cull_back_faces, |t, now| {
                draft.page.drawn.insert(*view, *instance, TileId(t as u32));
                seen[t] = PixelScale { most: seen[t].most.max(now.most), least: seen[t].least.max(now.least) };
            });
        }
        let part = &self.prepared.parts[p];
        for (t, &PixelScale { most, least }) in seen.iter().enumerate() {
            if most < 0.0 {
                continue;
            }
            let due = kept.is_due(&self.turns, part, (p, t), |tile| seen[tile].most >= 0.0);
            let planned = tile_terms[t] == self.term;
            let (low, high) = bands[t];
            if planned && !due && most >= low && most <= high && most <= APART * least {
                continue;
            }
            let before = &tiles[t];
            let even = most <= least * if matches!(before, Rate::Even(_)) { APART } else { TOGETHER };
            let (rate, band) = if even {
                let step = step(most, before.step(0));
                (Rate::Even(step), band(step))
            } else {
                draft.near.push((p, t));
                let face = &part.faces[part.face_of(&part.tiles[t])];
                // A plane has one cell at any density. Its edges may bend, but they have their own boxes.
                let flat = face.kind == SurfaceKind::Plane && self.terms.size.is_none();
                let boxes = || places(face, &part.tiles[t]).filter(|_| !flat);
                if planned && !due && before.is_each() && holds(boxes(), before, &draft.sights[p]) {
                    continue;
                }
                (Rate::Each(each(boxes(), before, &draft.sights[p])), (0.0, 0.0))
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
                draft.wanted.push(WantedRate { urgency, part: p, tile: t, rate, band, chord: 1.0 / most, anew: due });
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

    /// Plans the lattices of the tiles that change, then the tessellants of their edges.
    fn apply(&mut self, draft: &mut PlanDraft<'_>) {
        let cells_per_tile = Budget::of(&self.options.limits, 0).cells_per_tile;
        let mut touched = std::mem::take(&mut self.touched);
        for WantedRate { part: p, tile: t, rate, band, chord, anew, .. } in draft.wanted.drain(..) {
            let (part, rates) = (&self.prepared.parts[p], &mut self.parts[p]);
            let (tile, id) = (&part.tiles[t], (PartId::new(p), TileId(t as u32)));
            let face = &part.faces[part.face_of(tile)];
            let need = self.terms.need(&rate, places(face, tile).len(), self.prepared.scene.parts[p].radius);
            let old = &mut draft.page.parts[p].tiles[t];
            let before = self.turns.follow(&**old, anew || rates.tile_terms[t] != self.term);
            (rates.kept.tiles[t], rates.kept.due[t]) = (before.is_some(), false);
            let (mut made, kept) =
                lattice(face, tile, &need, 1.0, cells_per_tile, before.as_ref().map(|b| b as &dyn FollowLines));
            let is_plane = face.kind == SurfaceKind::Plane;
            // A plane's lattice does not depend on the chord, but the chord decides whether a face without triangles is
            // thin or lost.
            made.chord = Terms::settled(if is_plane { chord } else { made.chord });
            mark(&mut self.limited.tiles, id, !kept.cells);
            mark(&mut self.limited.lines, id, !kept.lines);
            // Triangles measured against a stricter chord still hold. On a plane nothing is measured, so any finite
            // chord will do.
            let holds = old.chord <= made.chord || is_plane && old.chord.is_finite();
            let as_before = old.us == made.us && old.vs == made.vs && holds;
            if !as_before {
                rates.cells[t] = cells(&made);
                *old = Arc::new(made);
                draft.changes.lattices.push(id);
                draft.changes.tiles.push(id);
            }
            (rates.tiles[t], rates.bands[t], rates.tile_terms[t]) = (rate, band, self.term);
            let seen = &rates.seen;
            let with_it = |e: RowId| anew && owner(&part.edges[e.index()], |t| seen[t].most >= 0.0) == Some(t);
            for u in tile.loops.iter().flatten() {
                touched.add(p, u.edge, if as_before { 0 } else { BESIDE_NEW } | if with_it(u.edge) { ANEW } else { 0 });
            }
        }
        for (p, t) in draft.near.drain(..) {
            let uses = self.prepared.parts[p].tiles[t].loops.iter().flatten();
            uses.for_each(|u| touched.add(p, u.edge, 0));
        }
        touched.drain(|p, e, why| self.tessellate_edge((p, e), why & BESIDE_NEW > 0, why & ANEW > 0, draft));
        self.touched = touched;
    }

    fn tessellate_edge(&mut self, (p, e): (usize, RowId), beside_new: bool, anew: bool, draft: &mut PlanDraft<'_>) {
        let (part, rates) = (&self.prepared.parts[p], &mut self.parts[p]);
        let (edge, k) = (&part.edges[e.index()], e.index());
        let beside = || edge.uses.iter().map(|place| &rates.tiles[place.tile.index()]);
        let planned = !beside_new && !anew && rates.edge_terms[k] == self.term;
        let page = &mut draft.page.parts[p];
        let single = |tile: TileId| page.tiles[tile.0 as usize].cells() == (1, 1);
        if planned && edge.straight && self.terms.size.is_none() && edge.uses.iter().all(|place| single(place.tile)) {
            return;
        }
        let rate = if beside().any(Rate::is_each) {
            let (places, before) = (edge.bounds.places.iter(), &rates.edges[k]);
            if planned && before.is_each() && holds(places.clone(), before, &draft.sights[p]) {
                return;
            }
            Rate::Each(each(places, before, &draft.sights[p]))
        } else {
            Rate::Even(beside().map(Rate::finest).max().flatten())
        };
        if planned && rates.edges[k] == rate {
            return;
        }
        let need = self.terms.need(&rate, edge.bounds.places.len(), self.prepared.scene.parts[p].radius);
        // If the angle alone decides, as for pins and holes at any distance, another chord gives the same tessellants.
        if let (true, Rate::Even(now), Rate::Even(before)) =
            (planned && need.tolerance.max_edge.is_none(), &rate, &rates.edges[k])
        {
            let finer = Rate::Even(*now.max(before));
            let finer = self.terms.need(&finer, 0, self.prepared.scene.parts[p].radius);
            if turns_more_than_bends(edge, &finer.tolerance) {
                rates.edges[k] = rate;
                return;
            }
        }
        let before = self.turns.follow(&*page.edges[k], anew || rates.edge_terms[k] != self.term);
        rates.kept.edges[k] = before.is_some();
        let (line, kept) =
            self.tessellants.polyline(edge, &page.tiles, &need, 1.0, before.as_ref().map(|b| b as &dyn FollowLines));
        mark(&mut self.limited.edges, (PartId::new(p), e), !kept);
        (rates.edges[k], rates.edge_terms[k]) = (rate, self.term);
        if *page.edges[k] != line {
            page.edges[k] = Arc::new(line);
            draft.changes.edges.push((PartId::new(p), e));
            draft.changes.tiles.extend(edge.uses.iter().map(|place| (PartId::new(p), place.tile)));
        }
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
