//! Limits on drawn triangles -> common terms that meet them, and what became coarser than required.

use super::rate::steps_of;
use super::rates::Rates;
use crate::frame::plan::limits::{Budget, Shortfall};
use crate::mesh::successors;
use crate::model::{PartId, RowId, TileId};
use std::collections::{BTreeMap, BTreeSet};

/// Tiles and edges that were coarser than required when they were last planned.
#[derive(Default)]
pub(super) struct Limited {
    pub(super) tiles: BTreeSet<(PartId, TileId)>,
    pub(super) lines: BTreeSet<(PartId, TileId)>,
    pub(super) edges: BTreeSet<(PartId, RowId)>,
}

impl Limited {
    /// Renumbers parts as [`Planner::update`](super::planner::Planner::update) says, and drops those that go.
    pub(super) fn renumber(&mut self, from: &[Option<PartId>]) {
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

    /// Forgets the tiles and edges of these parts, which ascend.
    pub(super) fn forget(&mut self, parts: &[PartId]) {
        let stays = |part: PartId| parts.binary_search(&part).is_err();
        self.tiles.retain(|(part, _)| stays(*part));
        self.lines.retain(|(part, _)| stays(*part));
        self.edges.retain(|(part, _)| stays(*part));
    }

    /// The drawn tiles and edges that limits make coarser. `unusable`: whether a view is invalid.
    pub(super) fn shortfall(&self, rates: &Rates, unusable: bool) -> Option<Shortfall> {
        let Self { tiles, lines, edges } = self;
        let Rates { options, terms, .. } = rates;
        let density = 1.0 / terms.coarsened();
        let mut shortfall = Shortfall { unusable, density, ..Shortfall::none(&options.limits) };
        if terms.coarser > 0 {
            shortfall.needed = (rates.triangles_drawn() as f64 * terms.coarsened().powi(2)) as u64;
        }
        // Tiles out of sight keep their limits, which this frame does not meet.
        shortfall.tiles = tiles.iter().copied().filter(|id| rates.shows(*id)).collect();
        shortfall.lines = lines.iter().copied().filter(|id| rates.shows(*id)).collect();
        shortfall.edges = edges.iter().copied().filter(|id| rates.shows_edge(*id)).collect();
        shortfall.if_any()
    }
}

/// What limits last did to the common terms, within one plan.
#[derive(Default)]
pub(super) struct LimitStep {
    /// By how many steps they became coarser; below 0 if finer, 0 if they have not changed.
    coarser: i16,
    /// Whether a finer step did not fit. None follows: so plans end.
    turned: bool,
    /// The triangles drawn before it.
    triangles: u64,
}

impl Rates {
    /// Whether the drawn tiles are within the limits, and one step finer would not be. If not, takes the terms one step
    /// nearer to that.
    ///
    /// What a step finer costs is known from the last one. Where it turns out to cost more, the plan goes back, and
    /// does not try again.
    ///
    /// `growth`: by how much the last change that limits caused multiplied the triangles, per step finer.
    pub(super) fn fits(&mut self, last: &mut LimitStep, growth: &mut f64, is_unfinished: bool) -> bool {
        /// Steps after which everything is as coarse as its shape allows: lines are 4096 times as sparse, and a tile
        /// has no more of them.
        const COARSEST: i16 = 48;
        /// Share of the limit to keep free, so that views that move do not change the terms to and fro.
        const SPARE: f64 = 0.1;
        let triangles = self.triangles_drawn();
        let allowed = Budget::of(&self.options.limits, 0).left.saturating_mul(2);
        let Self { terms, term, .. } = self;
        let LimitStep { coarser: before, turned, triangles: were } = *last;
        if before != 0 && were.min(triangles) > 0 {
            *growth = libm::pow(triangles as f64 / were as f64, -1.0 / f64::from(before)).max(1.0);
        }
        let is_over = triangles > allowed && terms.coarser < COARSEST;
        let turned = turned || is_over && before < 0;
        let has_room = triangles as f64 * *growth <= (1.0 - SPARE) * allowed as f64;
        // Several steps at once may have been too many. What waits for the budget is not counted yet.
        let may_refine = terms.coarser > 0 && has_room && before != 1 && !turned && !is_unfinished;
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
}

/// Puts a row into a set, or takes it out. Returns whether it was in.
pub(super) fn mark<T: Ord>(set: &mut BTreeSet<T>, row: T, is_in: bool) -> bool {
    // Nearly always empty.
    if is_in { !set.insert(row) } else { !set.is_empty() && set.remove(&row) }
}
