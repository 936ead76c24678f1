//! What the master decides for a frame: lattice lines per tile, tessellants per edge. The only state both sides of an
//! edge share.

use super::asked::{Asked, Need, dilated, most_touched};
use super::density::Density;
use super::lattice::{lattice, places};
use super::limits::{Budget, PlanLimits, Shortfall};
use super::tolerance::Tolerance;
use crate::mesh::{Drawn, ScenePart, TileId};
use crate::model::PartId;
use crate::prepare::{EdgeShape, Prepared, PreparedEdge, PreparedPart, StripBounds, UvCurve};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// Most lines of one tile in one direction between two creases, and most segments between two breaks of an edge. Tiles
/// are cut so that real tolerances need tens; this only bounds memory when a tolerance is absurd for the model's size.
pub(super) const MAX_LINES: usize = 4096;

/// Lattice lines of one tile, in the parameters of its face's patches; first and last are the tile's border.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
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

/// Tessellants of one edge.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EdgePolyline {
    /// Parameters, strictly increasing; contains all breaks.
    pub ts: Vec<f64>,
    /// Where each break stands in `ts`.
    pub breaks: Vec<u32>,
}

/// The plan of one part.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
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
    let mut tiles = Vec::with_capacity(part.tiles.len());
    for (k, tile) in part.tiles.iter().enumerate() {
        let face = &part.faces[part.face_of(tile)];
        let (lattice, kept) =
            lattice(face, tile, &asked.over(places(face, tile)), shortfall.density, budget.cells_per_tile);
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
    let mut edges = Vec::with_capacity(part.edges.len());
    for (k, edge) in part.edges.iter().enumerate() {
        let (polyline, kept) = polyline(part, edge, &tiles, &asked.over(edge.bounds.places.iter()), shortfall.density);
        budget.spend(polyline.ts.len() as u64)?;
        if !kept {
            shortfall.edges.push((id, k as u32));
        }
        edges.push(Arc::new(polyline));
    }
    Some(PartPlan { tiles, edges })
}

/// Segments of one edge, over all its breaks: what a curve whose speed varies by many decades would ask for is noise.
const SEGMENTS_OF_EDGE: usize = 16_384;
/// Segments between two breaks that an edge always may have.
const LEAST_LIMIT: usize = 64;

/// Tessellants of an edge: its own chord, angle and size bounds times `factor`, and at most one cell of any lattice along
/// it per segment. And whether they keep that.
pub(super) fn polyline(
    part: &PreparedPart,
    edge: &PreparedEdge,
    tiles: &[Arc<TileLattice>],
    need: &Need,
    factor: f64,
) -> (EdgePolyline, bool) {
    if edge.uses.is_empty() {
        return (EdgePolyline::default(), true);
    }
    let Need { tolerance, shares } = need;
    if need.is_even() {
        return tessellants(part, edge, tiles, tolerance, shares, factor);
    }
    let mut reach = 1;
    loop {
        // A segment that lies in several strips has to keep the tolerances of all.
        let shares = dilated(shares, 1, reach);
        let (out, kept) = tessellants(part, edge, tiles, tolerance, &shares, factor);
        let touched = most_touched(&edge.bounds.breaks, &out.ts);
        if touched <= reach + 1 {
            return (out, kept);
        }
        reach = touched - 1;
    }
}

/// Tessellants that keep a tolerance; of each strip it is given as a share of the strip's own.
fn tessellants(
    part: &PreparedPart,
    edge: &PreparedEdge,
    tiles: &[Arc<TileLattice>],
    tolerance: &Tolerance,
    shares: &[f64],
    factor: f64,
) -> (EdgePolyline, bool) {
    let angle = tolerance.angle.min(FRAC_PI_2);
    let own = |k: usize, b: &StripBounds| {
        let width = edge.bounds.breaks[k + 1] - edge.bounds.breaks[k];
        let bend = b.second * shares[k];
        let rate =
            if edge.straight { 0.0 } else { (bend / (8.0 * tolerance.chord)).sqrt().max(b.turn / angle / width) };
        // However coarse: what turns by more than a right angle per segment is another shape, and may cross itself.
        let least = if edge.straight { 0.0 } else { b.turn / FRAC_PI_2 / width };
        (factor * tolerance.max_edge.map_or(rate, |m| rate.max(b.first * shares[k] / m))).max(least)
    };
    let of_strips: Vec<f64> = edge.bounds.strips.iter().enumerate().map(|(k, b)| own(k, b)).collect();
    let Density { breaks, mut rates } = with_dense_images(part, edge, of_strips);
    let breaks = &breaks;
    for &(tile, l, u) in &edge.uses {
        let lattice = &tiles[tile.0 as usize];
        if lattice.us.len() == 2 && lattice.vs.len() == 2 {
            continue;
        }
        let edge_use = &part.tiles[tile.0 as usize].loops[l as usize][u as usize];
        let (a, b) = (edge.breaks[edge_use.from as usize].t, edge.breaks[edge_use.to as usize].t);
        limit_to_cells(&edge_use.uv, (a.min(b), a.max(b)), lattice, breaks, &mut rates);
    }
    if let [start, end] = edge.breaks[..]
        && start.point == end.point
        && matches!(edge.shape, EdgeShape::Curve(_))
    {
        // A closed edge is a triangle at least.
        let least = 3.0 / (end.t - start.t);
        rates.iter_mut().for_each(|rate| *rate = rate.max(least));
    }
    let density = Density { breaks: breaks.clone(), rates };
    let mut out = EdgePolyline { ts: vec![edge.breaks[0].t], breaks: vec![0] };
    let mut kept = true;
    let limit = (SEGMENTS_OF_EDGE / (edge.breaks.len() - 1)).clamp(LEAST_LIMIT, MAX_LINES);
    for w in edge.breaks.windows(2) {
        kept &= density.spread(w[0].t, w[1].t, limit, &mut out.ts);
        out.breaks.push(u32::try_from(out.ts.len() - 1).unwrap_or(u32::MAX));
    }
    (out, kept)
}

/// The strips of an edge's bounds with their rates, cut further where one of its images turns within a strip: beside a pole
/// it runs over half a lattice in a thousandth of the edge, and only there segments have to be short.
fn with_dense_images(part: &PreparedPart, edge: &PreparedEdge, rates: Vec<f64>) -> Density {
    /// Samples of an image within a strip from which on it is cut at each of them. Ordinary edges have two to eight.
    const MANY: usize = 16;
    let breaks = &edge.bounds.breaks;
    let mut cuts: Vec<f64> = Vec::new();
    for &(tile, l, u) in &edge.uses {
        let UvCurve::Hermite(samples) = &part.tiles[tile.0 as usize].loops[l as usize][u as usize].uv else { continue };
        if samples.len() < MANY {
            continue;
        }
        for w in breaks.windows(2) {
            let first = samples.partition_point(|s| s.t <= w[0]);
            let last = samples.partition_point(|s| s.t < w[1]);
            if last >= first + MANY {
                cuts.extend(samples[first..last].iter().map(|s| s.t));
            }
        }
    }
    if cuts.is_empty() {
        return Density { breaks: breaks.clone(), rates };
    }
    cuts.extend_from_slice(breaks);
    // A stretch of the edge ends at a break, and is sampled up to there.
    cuts.extend(edge.breaks.iter().map(|b| b.t).filter(|&t| t > breaks[0] && t < breaks[breaks.len() - 1]));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let rate = |w: &[f64]| rates[(breaks.partition_point(|&b| b <= w[0]).max(1) - 1).min(rates.len() - 1)];
    let rates = cuts.windows(2).map(rate).collect();
    Density { breaks: cuts, rates }
}

/// Raises rates so that a segment crosses at most one cell of `lattice` in each direction.
///
/// An image that runs to and fro over the lattice far more often than any real edge is noise; it gets as many segments
/// as a busy one.
fn limit_to_cells(uv: &UvCurve, range: (f64, f64), lattice: &TileLattice, breaks: &[f64], rates: &mut [f64]) {
    /// Samples per strip: enough that a lattice denser at one end of the strip is seen.
    const SAMPLES: usize = 4;
    /// Traversals of the lattice by one edge: an outline of a gear or a word as one spline makes a few dozen.
    const TRAVERSALS: f64 = 64.0;
    let mut hint = 0;
    let mut wanted = Vec::with_capacity(rates.len());
    let mut total = 0.0;
    for ends in breaks.windows(2) {
        let (a, b) = (ends[0].max(range.0), ends[1].min(range.1));
        if a >= b {
            wanted.push(0.0);
            continue;
        }
        let mut at = |t: f64| {
            let p = uv.point(t, &mut hint);
            (cell_coordinate(&lattice.us, p.x), cell_coordinate(&lattice.vs, p.y))
        };
        let step = (b - a) / SAMPLES as f64;
        let mut from = at(a);
        let mut rate = 0.0_f64;
        for i in 1..=SAMPLES {
            let to = at(a + step * i as f64);
            let cells = (to.0 - from.0).abs().max((to.1 - from.1).abs());
            rate = rate.max(cells / step);
            from = to;
        }
        wanted.push(rate);
        total += rate * (b - a);
    }
    let (nu, nv) = lattice.cells();
    let share = (TRAVERSALS * f64::from(nu + nv) / total).min(1.0);
    for (rate, wanted) in rates.iter_mut().zip(wanted) {
        *rate = rate.max(wanted * share);
    }
}
