//! The tolerance of each part -> a plan within limits.

use super::budget::{Budget, cells};
use super::lattice::{lattice, places};
use super::limits::{PlanLimits, Shortfall};
use super::output::{PartPlan, Plan};
use super::tessellants::{Tessellants, bare};
use crate::frame::tolerance::box_tolerance::{BoxTolerances, PartTolerance};
use crate::frame::tolerance::object_tolerance::Tolerance;
use crate::mesh::{DrawnTiles, ScenePart};
use crate::model::{PartId, RowId, TileId};
use crate::prepare::Prepared;
use crate::prepare::internals::{PreparedPart, of_prepared};
use std::sync::Arc;

/// Plans lattice lines and tessellants for a tolerance in the placed model, within [`PlanLimits::DEFAULT`].
///
/// A part is planned for the largest scale of its instances, so that its triangles meet the tolerance in all of them.
/// There are at most 4096 lines between two creases of a tile, and 4096 segments between two breaks of an edge. If the
/// tolerance requires more, or has unusable values (see [`Tolerance`]), the plan is coarser and reports it in
/// [`Plan::shortfall`]; [`Plan::require_full`] turns that into an error.
///
/// Cost: about 1 µs per tile and per edge.
#[must_use]
pub fn plan(prepared: &Prepared, tolerance: &Tolerance) -> Plan {
    plan_within(prepared, tolerance, &PlanLimits::DEFAULT)
}

/// As [`plan`], within the limits of the caller.
#[must_use]
pub fn plan_within(prepared: &Prepared, tolerance: &Tolerance, limits: &PlanLimits) -> Plan {
    let scales = prepared.scene.largest_scales();
    let of_part =
        |(part, &scale): (&ScenePart, &f64)| PartTolerance::everywhere(&tolerance.within_part(scale), part.radius);
    let asked: Vec<PartTolerance> = prepared.scene.parts.iter().zip(&scales).map(of_part).collect();
    let held_mib = u32::try_from(of_prepared(prepared).div_ceil(1 << 20)).unwrap_or(u32::MAX);
    plan_parts(prepared, &asked, limits, held_mib)
}

/// Plans all parts, each for its own tolerance in part coordinates.
///
/// If the whole does not fit the limits, all densities are lowered by the same factor: no face is favoured. `held_mib`:
/// memory of the prepared model that counts towards the limits, MiB.
pub(crate) fn plan_parts(prepared: &Prepared, asked: &[PartTolerance], limits: &PlanLimits, held_mib: u32) -> Plan {
    /// Factor on all densities per round. It about halves the number of cells.
    const LOWER: f64 = 0.75;
    /// Rounds until every tile has one cell and no plan is smaller: a factor of 1e-12.
    const LOWEST: i32 = 96;
    let mut shortfall = Shortfall { held_mib, ..Shortfall::none(limits) };
    // A part without tiles meets any tolerance.
    let unusable = |(part, asked): (&Arc<PreparedPart>, &PartTolerance)| asked.unusable && !part.tiles.is_empty();
    shortfall.unusable = prepared.parts.iter().zip(asked).any(unusable);
    let mut round = 0;
    loop {
        shortfall.density = LOWER.powi(round);
        shortfall.tiles.clear();
        shortfall.lines.clear();
        shortfall.edges.clear();
        let mut budget = Budget::of(limits, held_mib);
        if round == LOWEST {
            budget.left = u64::MAX;
        }
        let parts = prepared.parts.iter().zip(asked).enumerate();
        let parts: Option<Vec<PartPlan>> = parts
            .map(|(k, (part, asked))| plan_part(PartId::new(k), part, asked, &mut budget, &mut shortfall))
            .collect();
        if let Some(parts) = parts {
            return Plan { parts, drawn: DrawnTiles::default(), shortfall: shortfall.if_any() };
        }
        if round == 0 {
            shortfall.needed = triangles_asked(prepared, asked, limits);
        }
        round += 1;
    }
}

/// Upper bound on the triangles at full density, each tile within its limit.
fn triangles_asked(prepared: &Prepared, asked: &[PartTolerance], limits: &PlanLimits) -> u64 {
    let mut budget = Budget { left: u64::MAX, ..Budget::of(limits, 0) };
    for (k, (part, asked)) in prepared.parts.iter().zip(asked).enumerate() {
        // Keeps the plan of one part at a time in memory. The budget does not run out.
        let _ = plan_part(PartId::new(k), part, asked, &mut budget, &mut Shortfall::none(limits));
    }
    2 * (u64::MAX - budget.left)
}

/// Plans one part; `None` if the budget does not suffice.
fn plan_part(
    id: PartId,
    part: &PreparedPart,
    asked: &PartTolerance,
    budget: &mut Budget,
    shortfall: &mut Shortfall,
) -> Option<PartPlan> {
    let mut need = BoxTolerances::default();
    let mut tiles = Vec::with_capacity(part.tiles.len());
    for (k, tile) in part.tiles.iter().enumerate() {
        let face = &part.faces[part.face_of(tile)];
        asked.over(places(face, tile), &mut need);
        let (lattice, kept) = lattice(face, tile, &need, shortfall.density, budget.cells_per_tile, None);
        budget.spend(cells(&lattice))?;
        if !kept.cells {
            shortfall.tiles.push((id, TileId(k as u32)));
        }
        if !kept.lines {
            shortfall.lines.push((id, TileId(k as u32)));
        }
        tiles.push(Arc::new(lattice));
    }
    let mut tessellants = Tessellants::default();
    let mut edges = Vec::with_capacity(part.edges.len());
    for (k, edge) in part.edges.iter().enumerate() {
        let bare = if asked.limits_length() { None } else { bare(edge, &tiles) };
        let (polyline, kept) = bare.map(|line| (line, true)).unwrap_or_else(|| {
            asked.over(edge.bounds.places.iter(), &mut need);
            tessellants.polyline(edge, &tiles, &need, shortfall.density, None)
        });
        budget.spend(polyline.ts.len() as u64)?;
        if !kept {
            shortfall.edges.push((id, RowId(k as u32)));
        }
        edges.push(Arc::new(polyline));
    }
    Some(PartPlan { tiles, edges })
}
