//! A tile's loops and a plan -> tessellants: positions, parameters, cell coordinates.

use super::scratch::Scratch;
use crate::frame::plan::output::{CellWalk, PartPlan, Plan, TileLattice};
use crate::mesh::{EdgeLine, Origin, TileMesh};
use crate::model::{EdgeId, PartId, RowId};
use crate::prepare::Prepared;
use crate::prepare::internals::{EdgeShape, EdgeUse, PreparedEdge, PreparedPart, Tile};
use glam::{DVec2, DVec3};

/// Snaps cell coordinates this close to the tile's border onto it. Parameters come from projections accurate to about
/// 1e-12 of the domain, and an almost straight border would make slivers.
const BORDER_SNAP: f64 = 1e-9;

/// Position of an edge's tessellant at `t`. A break has its own stored point, so that all faces get the same bits.
pub(crate) fn edge_point(edge: &PreparedEdge, at_break: Option<u32>, t: f64) -> DVec3 {
    match (at_break, &edge.shape) {
        (Some(k), _) => edge.breaks[k as usize].point,
        (None, EdgeShape::Curve(c)) => c.point(t),
        (None, EdgeShape::Point(p)) => *p,
    }
}

/// Makes the tessellants of the tile's loops: cell coordinates, parameters, positions, origins.
pub(crate) fn trace_loops(
    part: &PreparedPart,
    plan: &PartPlan,
    tile: &Tile,
    lattice: &TileLattice,
    s: &mut Scratch,
    mesh: &mut TileMesh,
) {
    s.cells.clear();
    s.uvs.clear();
    s.loop_starts.clear();
    s.loop_starts.push(0);
    let mut spot = Spot::of(tile, lattice);
    for l in &tile.loops {
        for u in l {
            let edge = &part.edges[u.edge.index()];
            let polyline = &plan.edges[u.edge.index()];
            let (ts, mut hint) = (&polyline.ts[..], 0);
            for (k, at_break) in steps_with_breaks(u, &polyline.breaks) {
                let uv = u.uv.point(ts[k], &mut hint);
                s.cells.push(spot.cell(uv));
                s.uvs.push(uv);
                mesh.positions.push(edge_point(edge, at_break, ts[k]));
                mesh.origins.push(origin(part, u.edge, k as u32));
            }
        }
        s.loop_starts.push(s.cells.len() as u32);
    }
}

/// Maps parameters to cell coordinates. Fastest if each parameter is near the one before.
struct Spot<'a> {
    tile: &'a Tile,
    cells: (u32, u32),
    scale: DVec2,
    along: [CellWalk<'a>; 2],
}

impl<'a> Spot<'a> {
    fn of(tile: &'a Tile, lattice: &'a TileLattice) -> Self {
        let along = [CellWalk::new(&lattice.us), CellWalk::new(&lattice.vs)];
        Self { tile, cells: lattice.cells(), scale: cell_size(tile, lattice), along }
    }

    #[inline(always)]
    fn cell(&mut self, uv: DVec2) -> DVec2 {
        let Self { tile, cells, scale, along: [u, v] } = self;
        if *cells == (1, 1) {
            return ((uv - tile.min) / (tile.max - tile.min)).clamp(DVec2::ZERO, DVec2::ONE) * *scale;
        }
        DVec2::new(snap(u.cell(uv.x), cells.0), snap(v.cell(uv.y), cells.1))
    }
}

/// Indices of an edge's tessellants along one use, in loop order, without the last: each with the index of its break if
/// it is one.
pub(crate) fn steps_with_breaks<'a>(
    u: &'a EdgeUse,
    breaks: &'a [u32],
) -> impl Iterator<Item = (usize, Option<u32>)> + use<'a> {
    let (a, b) = (breaks[u.from as usize] as usize, breaks[u.to as usize] as usize);
    let mut next = u.from;
    (0..a.abs_diff(b)).map(move |i| {
        let k = if a < b { a + i } else { a - i };
        let at_break = (breaks[next as usize] as usize == k).then_some(next);
        if at_break.is_some() {
            next = if u.from < u.to { next + 1 } else { next.saturating_sub(1) };
        }
        (k, at_break)
    })
}

pub(crate) fn origin(part: &PreparedPart, edge: RowId, k: u32) -> Origin {
    if edge.index() < part.brep_edges {
        Origin::Edge { edge: EdgeId(edge.0), k }
    } else {
        Origin::Border { border: edge.0 - part.brep_edges as u32, k }
    }
}

fn snap(x: f64, cells: u32) -> f64 {
    let last = f64::from(cells);
    if x < BORDER_SNAP {
        0.0
    } else if x > last - BORDER_SNAP {
        last
    } else {
        x
    }
}

/// Size of the tile's cells in cell units. A single cell gets the tile's proportions in space, for better triangles: it
/// has no lattice lines to fit.
pub(crate) fn cell_size(tile: &Tile, lattice: &TileLattice) -> DVec2 {
    if lattice.cells() == (1, 1) { tile.proportions } else { DVec2::ONE }
}

/// The polyline of a B-rep edge by a plan. Empty for an edge that no tile uses.
#[must_use]
pub fn edge_line(prepared: &Prepared, plan: &Plan, part: PartId, edge: EdgeId) -> EdgeLine {
    let row = &prepared.parts[part.index()].edges[edge.index()];
    let line = &plan.parts[part.index()].edges[edge.index()];
    let mut breaks = (0..).zip(&line.breaks).peekable();
    let point =
        |(k, &t): (usize, &f64)| edge_point(row, breaks.next_if(|&(_, &at)| at as usize == k).map(|(b, _)| b), t);
    let points = line.ts.iter().enumerate().map(point).collect();
    EdgeLine { part, edge, points }
}
