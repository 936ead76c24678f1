//! The rates of all tiles and edges -> the rates, lattices and tessellants that should change. Reads only, so that all
//! threads of a frame can.

use super::culling::{GROUP, GROUPS, InstanceSight, PartBoxes, RANGE, WORDS};
use super::draft::{
    BESIDE_NEW, CellsAt, GroupBand, NewLattice, NewTessellants, RateChanges, SeenRange, SeenTiles, Sights,
    TessellantUpdate, UNSEEN, VisibleTiles, WantedRate, pair,
};
use super::rate::{Rate, Step, Terms, band, growth_of, step, steps_of};
use crate::frame::plan::lattice::{LatticeRequest, Lattices, is_single, places};
use crate::frame::plan::limits::{Budget, PlanLimits};
use crate::frame::plan::output::{EdgePolyline, Plan, cells};
use crate::frame::plan::tessellants::{NarrowestCells, Tessellants, is_bare, turns_more_than_bends};
use crate::frame::tolerance::BoxTolerances;
use crate::frame::tolerance::part_camera::PixelScale;
use crate::math::bits::ones;
use crate::model::{PartId, RowId, SurfaceKind, TileId};
use crate::prepare::Prepared;
use crate::prepare::internals::{BoundingBox, EdgeUse, PreparedFace, PreparedPart, Tile, TileUse};
use smallvec::SmallVec;
use std::sync::Arc;
use std::time::Duration;

/// Options of the plans for frames of views.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PlannerOptions {
    /// Limits on the size of a plan.
    pub limits: PlanLimits,
    /// Budget for the tiles of a frame, as predicted time of a single worker. Changes beyond it wait for the next
    /// frame. New tiles are always built, at a coarse level if the budget is spent. `None` disables it.
    pub budget: Option<Duration>,
    /// Cull back-facing tiles of closed parts. Do not use it where a camera is inside a part, or the near plane cuts
    /// one: there, back-facing tiles are in sight.
    pub cull_back_faces: bool,
}

impl PlannerOptions {
    /// Default limits, no budget, no back-face culling.
    pub const DEFAULT: Self = Self { limits: PlanLimits::DEFAULT, budget: None, cull_back_faces: false };
}

options! {
    PlannerOptions:
    with_limits(limits: PlanLimits);
    with_budget(budget: Option<Duration>);
    with_cull_back_faces(cull_back_faces: bool);
}

/// Split the level of a tile into per-box levels when they differ by more than this factor. Each of them can trigger a
/// rebuild: at 1.6 the trimmed teapot has 5 % fewer triangles, and twice as many tiles are rebuilt.
const APART: f64 = 4.0;
/// Merge the per-box levels back into one when they differ by less than this factor.
const TOGETHER: f64 = 3.0;

/// State of one part. The default is that of one that no view has shown.
#[derive(Default)]
pub(super) struct PartRates {
    /// Shared with the part's other LODs.
    pub(super) boxes: Arc<PartBoxes>,
    pub(super) tiles: Vec<Rate>,
    /// Densities for which each tile keeps its step. (0, 0) for tiles with a step per sub-box, or none yet.
    pub(super) bands: Vec<(f64, f64)>,
    /// What the bands of the tiles of each group have in common.
    pub(super) groups: Vec<GroupBand>,
    pub(super) edges: Vec<Rate>,
    /// The `term` with which each tile and edge was last planned; 0: never.
    pub(super) tile_terms: Vec<u32>,
    pub(super) edge_terms: Vec<u32>,
    pub(super) counts: TileCounts,
    /// Cells of tiles that wait for their first step. Empty without a budget.
    pub(super) estimates: Vec<CellsAt>,
    /// What the views of the current frame show of each tile.
    pub(super) seen: SeenTiles,
    /// Whether the last plan is the first one of the part, and may be taken back.
    pub(super) is_new: bool,
}

impl PartRates {
    /// Whether there is a plan of the part.
    pub(super) fn is_planned(&self) -> bool {
        !self.tiles.is_empty()
    }

    /// Sets the number of cells of a tile, which may be drawn.
    pub(super) fn set_cells(&mut self, tile: usize, cells: u64) {
        self.recount(tile, 2 * cells + u64::from(self.counts.outlines[tile]));
    }

    /// Changes the number of tessellants along the loops of a tile, which may be drawn.
    pub(super) fn lengthen(&mut self, tile: usize, by: i32) {
        let cells = self.counts.cells(tile);
        let outline = &mut self.counts.outlines[tile];
        *outline = outline.saturating_add_signed(by);
        self.set_cells(tile, cells);
    }

    fn recount(&mut self, tile: usize, triangles: u64) {
        let before = std::mem::replace(&mut self.counts.triangles[tile], triangles);
        if self.seen.shows(tile) {
            let range = &mut self.seen.0[tile / RANGE];
            range.triangles = range.triangles + triangles - before;
        }
    }
}

/// What the tiles of a part are made of.
#[derive(Default)]
pub(super) struct TileCounts {
    /// Expected number of triangles of each tile: two in each cell, and those of a polygon with its loops.
    triangles: Vec<u64>,
    /// Of these, a polygon's: the number of tessellants along the loops, and two for each loop but one.
    outlines: Vec<u32>,
}

impl TileCounts {
    /// Adds a tile with this number of cells.
    pub(super) fn push(&mut self, cells: u64, outline: u32) {
        self.triangles.push(2 * cells + u64::from(outline));
        self.outlines.push(outline);
    }

    /// Number of cells of a tile.
    fn cells(&self, tile: usize) -> u64 {
        (self.triangles[tile] - u64::from(self.outlines[tile])) / 2
    }
}

/// The number of tessellants of a polyline along a use of its edge.
pub(super) fn along(line: &EdgePolyline, of: &EdgeUse) -> u32 {
    line.breaks[of.from as usize].abs_diff(line.breaks[of.to as usize])
}

/// The tiles that use an edge, each with how many more tessellants the second of two polylines has there.
pub(super) fn lengthened<'a>(
    part: &'a PreparedPart,
    edge: usize,
    [old, new]: [&'a EdgePolyline; 2],
) -> impl Iterator<Item = (TileId, i32)> + 'a {
    part.edges[edge].uses.iter().map(move |place| {
        let of = place.of(&part.tiles);
        (place.tile, along(new, of).wrapping_sub(along(old, of)).cast_signed())
    })
}

/// State of a planner that its jobs read.
pub(super) struct Rates {
    pub(super) prepared: Arc<Prepared>,
    pub(super) options: PlannerOptions,
    pub(super) parts: Vec<PartRates>,
    /// Parts with a drawn tile in the current frame, ascending.
    pub(super) shown: Vec<usize>,
    pub(super) terms: Terms,
    /// Number of changes of `terms`. Plans made with an earlier one are outdated.
    pub(super) term: u32,
}

impl Rates {
    /// Whether a tile is drawn.
    pub(super) fn shows(&self, (part, tile): (PartId, TileId)) -> bool {
        self.parts[part.index()].seen.shows(tile.index())
    }

    /// Whether a tile with this edge is drawn.
    pub(super) fn shows_edge(&self, (part, edge): (PartId, RowId)) -> bool {
        let edge = &self.prepared.parts[part.index()].edges[edge.index()];
        edge.uses.iter().any(|of| self.shows((part, of.tile)))
    }

    /// Finds the drawn ones of some tiles, and the groups of them whose rates may change.
    ///
    /// Where a group was drawn as a whole, is so now, and all scales within its box are in the bands of all of its
    /// tiles, these are not looked at one by one: none of them would change.
    pub(super) fn see(&self, tiles: &mut VisibleTiles, sights: &Sights) {
        let VisibleTiles { part, range, seen, sights: with_any, bits } = tiles;
        let SeenRange { any, scales, whole, open, triangles } = seen;
        let PartRates { boxes, groups, counts, .. } = &self.parts[*part];
        let sights = sights.of_part(*part);
        // Groups that any camera sees, and those that one sees in part.
        let (mut in_any, mut in_part) = (0, 0);
        let mut bounds = [UNSEEN; GROUPS];
        let mut touched: SmallVec<[u32; 4]> = SmallVec::with_capacity(sights.len());
        for InstanceSight { sight, .. } in sights {
            let mut groups = 0;
            boxes.groups_seen_by(sight, *range, |group, all| {
                groups |= 1 << group;
                match all {
                    Some(scale) => bounds[group] = bounds[group].max(scale),
                    None => in_part |= 1 << group,
                }
            });
            in_any |= groups;
            touched.push(groups);
        }
        let judged = if boxes.may_cull(*range) { 0 } else { *whole & in_any & !in_part };
        let of_range = &groups[GROUPS * *range..];
        let keep = ones(judged).filter(|&group| self.keeps(&of_range[group], bounds[group]));
        let kept = keep.fold(0, |kept, group| kept | 1 << group);
        if *any {
            let groups = scales.len().div_ceil(GROUP);
            for group in ones(!kept).take_while(|group| *group < groups) {
                boxes.members(*range, group).iter().for_each(|&k| scales[usize::from(k)] = UNSEEN);
            }
        }
        for (s, groups) in touched.into_iter().enumerate() {
            let start = bits.len();
            for group in ones(groups & kept) {
                bits.resize(start + WORDS, 0);
                bits[start..].iter_mut().zip(boxes.word_bits(*range, group)).for_each(|(word, more)| *word |= more);
            }
            for group in ones(groups & !kept) {
                boxes.seen_by(&sights[s], (*range, group), |k, now| {
                    bits.resize(start + WORDS, 0);
                    bits[start + k / 64] |= 1 << (k % 64);
                    scales[k] = scales[k].max(now);
                });
            }
            if bits.len() > start {
                with_any.push(s as u32);
            }
        }
        let is_drawn = |k: &u16| scales[usize::from(*k)].most >= 0.0;
        let others = ones(in_any & !kept).filter(|&group| boxes.members(*range, group).iter().all(is_drawn));
        *whole = others.fold(kept, |whole, group| whole | 1 << group);
        *open = in_any & !kept;
        *any = !with_any.is_empty();
        let of_range = &counts.triangles[RANGE * *range..];
        let drawn = scales.iter().zip(of_range).filter(|(scale, _)| scale.most >= 0.0);
        *triangles = if *any { drawn.map(|(_, triangles)| triangles).sum() } else { 0 };
    }

    /// Whether all tiles of a group keep their rates if their scales are within these.
    fn keeps(&self, band: &GroupBand, PixelScale { most, least }: PixelScale) -> bool {
        band.term == self.term && least >= band.low && most <= band.high && most <= APART * least
    }

    /// Looks at the drawn tiles of some groups of a range.
    pub(super) fn look_at(
        &self,
        p: usize,
        (range, groups): (usize, u32),
        sights: &[InstanceSight],
        wanted: &mut RateChanges,
    ) {
        // An error that many times as large is so many steps more urgent, whatever the tile: clusters stay as they are.
        let priority = || sights.iter().map(|sight| sight.priority).fold(f64::MIN_POSITIVE, f64::max);
        let raised = if self.options.budget.is_some() { steps_of(priority()) } else { 0.0 };
        let part = &self.parts[p];
        for group in ones(groups) {
            let tiles = part.boxes.members(range, group).iter().map(|&k| RANGE * range + usize::from(k));
            let band = self.look_at_tiles(p, tiles, (sights, raised), wanted);
            let row = GROUPS * range + group;
            if part.groups[row] != band {
                wanted.groups.push((p, row, band));
            }
        }
    }

    /// Looks at the drawn ones of some tiles. Returns the scales at which all of them keep their rates.
    fn look_at_tiles(
        &self,
        p: usize,
        tiles: impl Iterator<Item = usize>,
        (sights, raised): (&[InstanceSight], f64),
        wanted: &mut RateChanges,
    ) -> GroupBand {
        let PartRates { tiles: rates, bands, tile_terms, seen, .. } = &self.parts[p];
        let part = &self.prepared.parts[p];
        let (mut of_all, mut all_keep) = (GroupBand::all(self.term), true);
        for t in tiles {
            let PixelScale { most, least } = seen.of(t);
            if most < 0.0 {
                all_keep = false;
                continue;
            }
            let checks_edges = self.is_next_to_culled(p, t);
            if checks_edges {
                wanted.near.push((p, t));
            }
            let planned = tile_terms[t] == self.term;
            let (low, high) = bands[t];
            if planned && most >= low && most <= high && most <= APART * least {
                (of_all.low, of_all.high) = (of_all.low.max(low), of_all.high.min(high));
                continue;
            }
            all_keep = false;
            let before = &rates[t];
            let even = most <= least * if matches!(before, Rate::Even(_)) { APART } else { TOGETHER };
            let (rate, band) = if even {
                let step = step(most, before.step(0));
                (Rate::Even(step), band(step))
            } else {
                wanted.near.extend((!checks_edges).then_some((p, t)));
                let face = part.face_of(&part.tiles[t]);
                // The edges of tiles with one cell at any density may bend, but they have their own boxes.
                let single = is_single(face, self.terms.size);
                let boxes = || places(face, &part.tiles[t]).filter(|_| !single);
                if planned && before.is_each() && holds(boxes(), before, sights) {
                    continue;
                }
                (Rate::Each(each(boxes(), before, sights)), (0.0, 0.0))
            };
            if !planned || rate != *before {
                let (urgency, growth) = match self.options.budget {
                    Some(_) => self.urgency((p, t), planned, &rate, wanted),
                    None => (0.0, 1.0),
                };
                let (urgency, chord) = (urgency + raised, 1.0 / most);
                wanted.want(WantedRate { urgency, growth, part: p, tile: t, rate, band, chord });
            }
        }
        if all_keep { of_all } else { GroupBand::NONE }
    }

    /// Whether a drawn tile shares an edge with a culled one that has a step per sub-box: then that edge has too, and
    /// no other tile has it checked.
    fn is_next_to_culled(&self, p: usize, t: usize) -> bool {
        let PartRates { boxes, tiles: rates, edges, seen, .. } = &self.parts[p];
        let part = &self.prepared.parts[p];
        let is_open = |place: &TileUse| rates[place.tile.index()].is_each() && !seen.shows(place.tile.index());
        // Of tiles that are off-screen, the picture has no edges.
        boxes.may_cull(t / RANGE)
            && part.tiles[t].loops.iter().flatten().map(|u| u.edge.index()).any(|edge| {
                // Most edges are next to tiles with one step.
                edges[edge].is_each() && part.edges[edge].uses.iter().any(is_open)
            })
    }

    /// How many steps finer a tile should be, and the factor on its cells.
    ///
    /// Steps say it, except for tiles that have none yet, or one of other terms. Of those the cells say it. They are
    /// counted once, however long the tile is deferred.
    fn urgency(&self, (p, t): (usize, usize), planned: bool, rate: &Rate, wanted: &mut RateChanges) -> (f64, f64) {
        let PartRates { tiles: rates, counts, estimates, .. } = &self.parts[p];
        if let (true, Some(to), Some(from)) = (planned, rate.finest(), rates[t].finest()) {
            let steps = f64::from(to) - f64::from(from);
            return (steps, growth_of(steps));
        }
        let mut known = estimates[t];
        if known.term != self.term || known.step.is_some() != rate.finest().is_some() {
            let part = &self.prepared.parts[p];
            let (tile, face) = (&part.tiles[t], part.face_of(&part.tiles[t]));
            let need = self.terms.need(rate, self.prepared.scene.parts[p].radius);
            let (made, _) = Lattices::default().lattice(&self.request((face, tile), &need));
            known = CellsAt { term: self.term, step: rate.finest(), cells: cells(&made) as f64 };
            wanted.estimates.push((p, t, known));
        }
        let more = match (rate.finest(), known.step) {
            (Some(to), Some(at)) => growth_of(f64::from(to) - f64::from(at)),
            _ => 1.0,
        };
        let growth = known.cells * more / counts.cells(t) as f64;
        // What has no step of these terms comes before what is only refined for its edges' sake.
        (steps_of(growth).max(1.0), growth)
    }

    fn request<'a>(&self, (face, tile): (&'a PreparedFace, &'a Tile), need: &'a BoxTolerances) -> LatticeRequest<'a> {
        let most_cells = Budget::of(&self.options.limits, 0).cells_per_tile;
        LatticeRequest { face, tile, need, factor: 1.0, most_cells }
    }

    /// The lattice of a tile at the rate that it should have, and the edges that follow.
    pub(super) fn new_lattice(&self, wanted: &WantedRate, page: &Plan, lattices: &mut Lattices) -> NewLattice {
        let WantedRate { part: p, tile: t, rate, chord, .. } = wanted;
        let part = &self.prepared.parts[*p];
        let (tile, old) = (&part.tiles[*t], &page.parts[*p].tiles[*t]);
        let face = part.face_of(tile);
        let need = self.terms.need(rate, self.prepared.scene.parts[*p].radius);
        let (mut made, kept) = lattices.lattice(&self.request((face, tile), &need));
        let is_plane = face.kind == SurfaceKind::Plane;
        // A plane's lattice does not depend on the chord, but the chord decides whether a face without triangles is
        // thin or lost.
        made.chord = Terms::settled(if is_plane { *chord } else { made.chord });
        made.loosest = Terms::settled(made.loosest);
        // Triangles measured against a stricter chord still hold. On a plane nothing is measured, so any finite
        // chord will do.
        let holds = old.chord <= made.chord && old.loosest <= made.loosest || is_plane && old.chord.is_finite();
        let as_before = old.us == made.us && old.vs == made.vs && holds;
        let why = if as_before { 0 } else { BESIDE_NEW };
        let touches = tile.loops.iter().flatten().map(|u| (u.edge, why)).collect();
        NewLattice { made: (!as_before).then(|| (cells(&made), pair(made))), kept, touches }
    }

    /// `None` if the old tessellants hold at the old rate.
    pub(super) fn new_tessellants(
        &self,
        (p, e): (usize, RowId),
        why: u8,
        (page, sights): (&Plan, &[InstanceSight]),
        tessellants: &mut Tessellants,
    ) -> Option<NewTessellants> {
        let (part, rates) = (&self.prepared.parts[p], &self.parts[p]);
        let (edge, k) = (&part.edges[e.index()], e.index());
        let beside = || edge.uses.iter().map(|place| &rates.tiles[place.tile.index()]);
        let planned = why & BESIDE_NEW == 0 && rates.edge_terms[k] == self.term;
        let page = &page.parts[p];
        if planned && self.terms.size.is_none() && is_bare(edge, &page.tiles) {
            return None;
        }
        let rate = if beside().any(Rate::is_each) {
            let (places, before) = (edge.bounds.places(), &rates.edges[k]);
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
        let need = self.terms.need(&rate, radius);
        // If the angle alone decides, as for pins and holes at any distance, another chord gives the same tessellants.
        if let (true, Rate::Even(now), Rate::Even(before)) =
            (planned && need.tolerance.max_edge.is_none(), &rate, &rates.edges[k])
        {
            let finer = self.terms.need(&Rate::Even(*now.max(before)), radius);
            if turns_more_than_bends(edge, &finer.tolerance) {
                return Some(NewTessellants { rate, made: None });
            }
        }
        let (line, kept) = tessellants.polyline(edge, &mut NarrowestCells::of(&page.tiles), &need, 1.0);
        if *page.edges[k] == line {
            let made = TessellantUpdate { line: None, tiles: SmallVec::new(), kept };
            return Some(NewTessellants { rate, made: Some(made) });
        }
        let tiles = lengthened(part, k, [&page.edges[k], &line]).collect();
        Some(NewTessellants { rate, made: Some(TessellantUpdate { line: Some(pair(line)), tiles, kept }) })
    }

    /// Expected number of triangles of the drawn tiles.
    pub(super) fn triangles_drawn(&self) -> u64 {
        self.shown.iter().flat_map(|&part| &self.parts[part].seen.0).map(|range| range.triangles).sum()
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
