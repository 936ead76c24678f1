//! What the master decides for a frame: lattice lines per tile, tessellants per edge. The only state both sides of an
//! edge share.

use super::lattice::{Density, lattice};
use crate::prepare::{EdgeShape, Prepared, PreparedEdge, PreparedPart, UvCurve};
use std::f64::consts::FRAC_PI_2;

/// Most lines of one tile in one direction, and most segments between two breaks of an edge. Tiles are cut so that real
/// tolerances need tens; this only bounds memory when a tolerance is absurd for the model's size.
pub(super) const MAX_LINES: usize = 4096;

/// What a mesh must keep, in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Largest distance between triangles and surface, and between polylines and edges, millimetres. Positive.
    pub chord: f64,
    /// Largest turning of the normal across a cell and of the tangent along a segment, radians. Positive; more than a
    /// quarter turn counts as a quarter turn, so that small pins and holes never collapse.
    pub angle: f64,
    /// Largest length of a cell's side or an edge's segment, millimetres; `None` = no limit.
    pub max_edge: Option<f64>,
}

/// Lattice lines of one tile, in the parameters of its face's patches; first and last are the tile's border.
#[derive(Clone, Debug, PartialEq)]
pub struct TileLattice {
    /// u-lines, strictly increasing.
    pub us: Vec<f64>,
    /// v-lines, strictly increasing.
    pub vs: Vec<f64>,
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
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EdgePolyline {
    /// Parameters, strictly increasing; contains all breaks.
    pub ts: Vec<f64>,
    /// Where each break stands in `ts`.
    pub breaks: Vec<u32>,
}

/// The plan of one part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PartPlan {
    /// One per tile.
    pub tiles: Vec<TileLattice>,
    /// One per prepared edge (empty for edges that no tile uses).
    pub edges: Vec<EdgePolyline>,
}

/// The plan of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// One per part.
    pub parts: Vec<PartPlan>,
}

/// Rates for a tolerance in object space; the same for all parts. Cost: about 1 µs per tile and per edge.
#[must_use]
pub fn plan(prepared: &Prepared, tolerance: &Tolerance) -> Plan {
    Plan { parts: prepared.parts.iter().map(|p| plan_part(p, tolerance)).collect() }
}

/// Rates of one part.
#[must_use]
pub fn plan_part(part: &PreparedPart, tolerance: &Tolerance) -> PartPlan {
    let tiles: Vec<TileLattice> =
        part.tiles.iter().map(|t| lattice(&part.faces[part.face_of(t)], t, tolerance)).collect();
    let edges = part.edges.iter().map(|e| polyline(part, e, &tiles, tolerance)).collect();
    PartPlan { tiles, edges }
}

/// Tessellants of an edge: its own chord, angle and size bounds, and at most one cell of any lattice along it per segment.
fn polyline(part: &PreparedPart, edge: &PreparedEdge, tiles: &[TileLattice], tolerance: &Tolerance) -> EdgePolyline {
    if edge.uses.is_empty() {
        return EdgePolyline::default();
    }
    let strips = edge.bounds.strips.len();
    let breaks = &edge.bounds.breaks;
    let mut rates = vec![0.0_f64; strips];
    let angle = tolerance.angle.min(FRAC_PI_2);
    for (k, (rate, b)) in rates.iter_mut().zip(&edge.bounds.strips).enumerate() {
        if !edge.straight {
            let width = breaks[k + 1] - breaks[k];
            *rate = (b.second / (8.0 * tolerance.chord)).sqrt().max(b.turn / angle / width);
        }
        *rate = tolerance.max_edge.map_or(*rate, |m| rate.max(b.first / m));
    }
    for &(tile, l, u) in &edge.uses {
        let lattice = &tiles[tile.0 as usize];
        if lattice.us.len() == 2 && lattice.vs.len() == 2 {
            continue;
        }
        let edge_use = &part.tiles[tile.0 as usize].loops[l as usize][u as usize];
        let (a, b) = (edge.breaks[edge_use.from as usize].t, edge.breaks[edge_use.to as usize].t);
        limit_to_cells(&edge_use.uv, (a.min(b), a.max(b)), lattice, breaks, &mut rates);
    }
    let density = Density { breaks: breaks.clone(), rates };
    let closed = edge.breaks.len() == 2
        && edge.breaks[0].point == edge.breaks[1].point
        && matches!(edge.shape, EdgeShape::Curve(_));
    let least = if closed { 3 } else { 1 };
    let mut out = EdgePolyline { ts: vec![edge.breaks[0].t], breaks: vec![0] };
    for w in edge.breaks.windows(2) {
        density.spread(w[0].t, w[1].t, least, &mut out.ts);
        out.breaks.push(u32::try_from(out.ts.len() - 1).unwrap_or(u32::MAX));
    }
    out
}

/// Raises rates so that a segment crosses at most one cell of `lattice` in each direction.
fn limit_to_cells(uv: &UvCurve, range: (f64, f64), lattice: &TileLattice, breaks: &[f64], rates: &mut [f64]) {
    /// Samples per strip: enough that a lattice denser at one end of the strip is seen.
    const SAMPLES: usize = 4;
    let mut hint = 0;
    for (k, rate) in rates.iter_mut().enumerate() {
        let (a, b) = (breaks[k].max(range.0), breaks[k + 1].min(range.1));
        if a >= b {
            continue;
        }
        let mut at = |t: f64| {
            let p = uv.point(t, &mut hint);
            (cell_coordinate(&lattice.us, p.x), cell_coordinate(&lattice.vs, p.y))
        };
        let step = (b - a) / SAMPLES as f64;
        let mut from = at(a);
        for i in 1..=SAMPLES {
            let to = at(a + step * i as f64);
            let cells = (to.0 - from.0).abs().max((to.1 - from.1).abs());
            *rate = rate.max(cells / step);
            from = to;
        }
    }
}
