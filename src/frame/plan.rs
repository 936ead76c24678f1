//! What the master decides for a frame: lattice lines per tile, tessellants per edge. The only state both sides of an
//! edge share.

use super::asked::{Asked, Need};
use super::lattice::{lattice, places};
use super::limits::{Budget, PlanLimits, Shortfall};
use super::tessellants::{Tessellants, bare};
use super::tolerance::Tolerance;
use crate::mesh::{Drawn, ScenePart, TileId};
use crate::model::PartId;
use crate::prepare::{Prepared, PreparedPart};
use std::sync::Arc;

/// Most lines of one tile in one direction between two creases, and most segments between two breaks of an edge. Tiles
/// are cut so that real tolerances need tens; this only bounds memory when a tolerance is absurd for the model's size.
pub(super) const MAX_LINES: usize = 4096;

/// Lattice lines of one tile, in the parameters of its face's patches; first and last are the tile's border.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TileLattice {
    /// u-lines, strictly increasing.
    pub us: Vec<f64>,
    /// v-lines, strictly increasing.
    pub vs: Vec<f64>,
    /// The strictest chord tolerance anywhere in the tile, in the part's own millimetres.
    pub chord: f64,
}

impl TileLattice {
    /// Number of cells in u and in v.
    #[must_use]
    pub fn cells(&self) -> (u32, u32) {
        let count = |lines: &[f64]| u32::try_from(lines.len() - 1).unwrap_or(u32::MAX);
        (count(&self.us), count(&self.vs))
    }
}

/// Position of a parameter among lines, in cells: the integer part is the line below, the fraction linear to the next.
/// Clamped to the lines' range.
#[must_use]
pub fn cell_coordinate(lines: &[f64], x: f64) -> f64 {
    let last = lines.len() - 1;
    if x <= lines[0] {
        return 0.0;
    }
    if x >= lines[last] {
        return last as f64;
    }
    let k = lines.partition_point(|&l| l <= x) - 1;
    k as f64 + (x - lines[k]) / (lines[k + 1] - lines[k])
}

/// Positions among lines, as [`cell_coordinate`], of parameters that are near the ones before: without a search.
pub(super) struct CellWalk<'a> {
    lines: &'a [f64],
    /// The line below the last parameter.
    at: usize,
}

impl<'a> CellWalk<'a> {
    pub(super) fn new(lines: &'a [f64]) -> Self {
        Self { lines, at: 0 }
    }

    /// From a share of the way from the first to the last line on.
    pub(super) fn from_share(lines: &'a [f64], share: f32) -> Self {
        Self { lines, at: ((f64::from(share) * (lines.len() - 1) as f64) as usize).min(lines.len() - 2) }
    }

    /// The same number as [`cell_coordinate`].
    #[inline]
    pub(super) fn cell(&mut self, x: f64) -> f64 {
        let Self { lines, at } = self;
        let last = lines.len() - 1;
        if x <= lines[0] {
            return 0.0;
        }
        if x >= lines[last] {
            return last as f64;
        }
        // One of the two loops does nothing. What is no number stays where it is.
        while x >= lines[*at + 1] {
            *at += 1;
        }
        while x < lines[*at] {
            *at -= 1;
        }
        *at as f64 + (x - lines[*at]) / (lines[*at + 1] - lines[*at])
    }

    /// Of a share of the way from the first to the last line.
    #[inline]
    pub(super) fn at_share(&mut self, share: f64) -> f64 {
        let (first, last) = (self.lines[0], self.lines[self.lines.len() - 1]);
        self.cell(first + share * (last - first))
    }
}

/// Tessellants of one edge.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EdgePolyline {
    /// Parameters, strictly increasing; contains all breaks.
    pub ts: Vec<f64>,
    /// Where each break stands in `ts`.
    pub breaks: Vec<u32>,
}

/// The plan of one part.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PartPlan {
    /// One per tile.
    pub tiles: Vec<Arc<TileLattice>>,
    /// One per prepared edge (empty for edges that no tile uses).
    pub edges: Vec<Arc<EdgePolyline>>,
}

/// The plan of a frame: all that workers are told.
///
/// With `serde` it can be kept and made again elsewhere, bit for bit ([`Session::frame`](crate::parallel::Session::frame)), in formats
/// that keep numbers whole and know infinity: CBOR and the like, not JSON.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Plan {
    /// One per part.
    pub parts: Vec<PartPlan>,
    /// What of it is drawn; everything, unless it is a [`Planner`](super::Planner)'s.
    pub drawn: Drawn,
    /// What is coarser than the tolerance asks; `None` if nothing is.
    pub shortfall: Option<Shortfall>,
}

impl Plan {
    /// The plan, unless limits made it coarser than the tolerance asks: for those who want the tolerance or nothing.
    ///
    /// # Errors
    /// [`Plan::shortfall`], where it comes [of limits](Shortfall::by_limits).
    pub fn as_asked(self) -> Result<Self, Shortfall> {
        match self.shortfall {
            Some(shortfall) if shortfall.by_limits() => Err(shortfall),
            shortfall => Ok(Self { shortfall, ..self }),
        }
    }
}

/// Rates for a tolerance in the placed model, within [`PlanLimits::DEFAULT`].
///
/// A part that is placed at a scale is planned for the largest: its triangles keep the tolerance wherever it stands. Lines
/// and tessellants are limited to 4096 between two creases of a tile, and between two breaks of an edge; with tolerances
/// that ask for more, or that are no usable numbers (see [`Tolerance`]), the plan is coarser and says so in
/// [`Plan::shortfall`]; [`Plan::as_asked`] refuses such a plan.
/// Cost: about 1 µs per tile and per edge.
#[must_use]
pub fn plan(prepared: &Prepared, tolerance: &Tolerance) -> Plan {
    plan_within(prepared, tolerance, &PlanLimits::DEFAULT)
}

/// The same within limits of the caller's.
#[must_use]
pub fn plan_within(prepared: &Prepared, tolerance: &Tolerance, limits: &PlanLimits) -> Plan {
    let scales = prepared.scene.largest_scales();
    let of_part = |(part, &scale): (&ScenePart, &f64)| Asked::everywhere(&tolerance.within_part(scale), part.radius);
    let asked: Vec<Asked> = prepared.scene.parts.iter().zip(&scales).map(of_part).collect();
    plan_parts(prepared, &asked, limits)
}

/// Rates for what is asked of each part, in the part's own millimetres.
///
/// While the whole does not fit the limits, all densities are lowered together: no face is favoured.
pub(super) fn plan_parts(prepared: &Prepared, asked: &[Asked], limits: &PlanLimits) -> Plan {
    /// What a density is lowered to in one go: cells go down to about the half.
    const LOWER: f64 = 0.75;
    /// Then there is one cell per tile, and no plan is smaller: a factor of 1e-12.
    const LOWEST: i32 = 96;
    let mut shortfall = Shortfall::none(limits);
    // A part without tiles is meshed at any tolerance.
    let unusable = |(part, asked): (&Arc<PreparedPart>, &Asked)| asked.unusable && !part.tiles.is_empty();
    shortfall.unusable = prepared.parts.iter().zip(asked).any(unusable);
    let mut round = 0;
    loop {
        shortfall.density = LOWER.powi(round);
        shortfall.tiles.clear();
        shortfall.lines.clear();
        shortfall.edges.clear();
        let mut budget = Budget::of(limits);
        if round == LOWEST {
            budget.left = u64::MAX;
        }
        let parts = prepared.parts.iter().zip(asked).enumerate();
        let parts: Option<Vec<PartPlan>> = parts
            .map(|(k, (part, asked))| plan_part(PartId::new(k), part, asked, &mut budget, &mut shortfall))
            .collect();
        if let Some(parts) = parts {
            return Plan { parts, drawn: Drawn::default(), shortfall: shortfall.if_any() };
        }
        if round == 0 {
            shortfall.needed = triangles_asked(prepared, asked, limits);
        }
        round += 1;
    }
}

/// Triangles that all cells and tessellants can make at the density that is asked, each tile within its limit.
fn triangles_asked(prepared: &Prepared, asked: &[Asked], limits: &PlanLimits) -> u64 {
    let mut budget = Budget { left: u64::MAX, ..Budget::of(limits) };
    for (k, (part, asked)) in prepared.parts.iter().zip(asked).enumerate() {
        // Lines and tessellants of one part at a time; there is room for all cells there are.
        let _ = plan_part(PartId::new(k), part, asked, &mut budget, &mut Shortfall::none(limits));
    }
    2 * (u64::MAX - budget.left)
}

/// Rates of one part; `None` when the budget does not suffice.
fn plan_part(
    id: PartId,
    part: &PreparedPart,
    asked: &Asked,
    budget: &mut Budget,
    shortfall: &mut Shortfall,
) -> Option<PartPlan> {
    let mut need = Need::default();
    let mut tiles = Vec::with_capacity(part.tiles.len());
    for (k, tile) in part.tiles.iter().enumerate() {
        let face = &part.faces[part.face_of(tile)];
        asked.over(places(face, tile), &mut need);
        let (lattice, kept) = lattice(face, tile, &need, shortfall.density, budget.cells_per_tile, None);
        let (nu, nv) = lattice.cells();
        budget.spend(u64::from(nu) * u64::from(nv))?;
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
            shortfall.edges.push((id, k as u32));
        }
        edges.push(Arc::new(polyline));
    }
    Some(PartPlan { tiles, edges })
}
