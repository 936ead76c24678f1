//! A tile's loops and lattice -> vertices: tessellants, positions, normals.

/// Points and normals of tessellants, and what lattices share with them.
pub mod evaluate;

/// Points and normals of lattices.
pub mod lattice;

use crate::frame::plan::output::{CellWalk, PartPlan, Plan, TileLattice};
use crate::frame::trim::climb::TrimScratch;
use crate::frame::trim::output::TrimOutput;
use crate::math::lanes::widest;
use crate::mesh::{EdgeLine, Origin, TileMesh};
use crate::model::{EdgeId, PartId, RowId};
use crate::prepare::Prepared;
use crate::prepare::internals::{EdgeShape, EdgeUse, PreparedEdge, PreparedFace, PreparedPart, Tile};
use evaluate::evaluate_points;
use glam::{DVec2, DVec3, Vec3};
use lattice::{EvaluateScratch, evaluate_lattice};

/// Work space that one worker reuses for all its tiles. Does not affect results.
#[derive(Default)]
pub struct Scratch {
    /// Positions of the tessellants.
    pub(crate) outline: Vec<DVec3>,
    /// Where the vertices come from, tessellants first.
    pub(crate) origins: Vec<Origin>,
    /// Cell coordinates of the vertices, tessellants first.
    pub(crate) cells: Vec<DVec2>,
    /// Parameters of the vertices.
    pub(crate) uvs: Vec<DVec2>,
    pub(crate) loop_starts: Vec<u32>,
    /// Parameters of the tessellants of one use of an edge.
    pub(crate) ts: Vec<f64>,
    /// Vertex of each tessellant, which is itself, then of each lattice point, or `NONE`.
    pub(crate) vertices: Vec<u32>,
    /// The lattice points that have a vertex, in its order.
    pub(crate) used: Vec<[u32; 2]>,
    /// Runs of full cells along a row: column and row of the first, and how many.
    pub(crate) runs: Vec<[u32; 3]>,
    /// Triangles that may be folded, ascending.
    pub(crate) doubtful: Vec<usize>,
    pub(crate) trim: TrimScratch,
    pub(crate) trimmed: TrimOutput,
    pub(crate) evaluate: EvaluateScratch,
    /// Empty, with the room of the last tile's mesh.
    mesh: TileMesh,
}

impl Scratch {
    /// An empty mesh, with the room of the last one that came back.
    pub(crate) fn take_mesh(&mut self) -> TileMesh {
        std::mem::take(&mut self.mesh)
    }

    /// Gives the room of the last tile's mesh to the next one. Without it, each tile gets new memory.
    pub fn reuse(&mut self, mut mesh: TileMesh) {
        mesh.clear();
        self.mesh = mesh;
    }
}

/// Snaps cell coordinates this close to the tile's border onto it. Parameters come from projections accurate to about
/// 1e-12 of the domain, and an almost straight border would make slivers.
const BORDER_SNAP: f64 = 1e-9;

/// Position of an edge's tessellant at `t`. A break has its own stored point.
fn edge_point(edge: &PreparedEdge, at_break: Option<u32>, t: f64) -> DVec3 {
    match (at_break, &edge.shape) {
        (Some(k), _) => edge.breaks[k as usize].point,
        (None, EdgeShape::Curve(c)) => c.point(t),
        (None, EdgeShape::Point(p)) => *p,
    }
}

/// Makes the tessellants of the tile's loops in the scratch: cell coordinates, parameters, positions, origins.
pub(crate) fn trace_loops(part: &PreparedPart, plan: &PartPlan, tile: &Tile, lattice: &TileLattice, s: &mut Scratch) {
    s.outline.clear();
    s.origins.clear();
    s.cells.clear();
    s.uvs.clear();
    s.loop_starts.clear();
    s.loop_starts.push(0);
    widest(
        #[inline(always)]
        || {
            for l in &tile.loops {
                for u in l {
                    trace_use((part, plan), u, &mut s.ts, (&mut s.outline, &mut s.origins));
                    if let [_, between @ ..] = &s.ts[..] {
                        s.uvs.push(u.start.1);
                        u.uv.points(between, u.piece, &mut s.uvs);
                    }
                }
                s.loop_starts.push(s.uvs.len() as u32);
            }
            to_cells((tile, lattice), &s.uvs, &mut s.cells);
        },
    );
}

/// Appends positions and origins of an edge's tessellants along one use, in loop order, without the last. Sets `ts` to
/// their parameters.
#[inline(always)]
pub(crate) fn trace_use(
    (part, plan): (&PreparedPart, &PartPlan),
    u: &EdgeUse,
    ts: &mut Vec<f64>,
    (positions, origins): (&mut Vec<DVec3>, &mut Vec<Origin>),
) {
    let (edge, line) = (&part.edges[u.edge.index()], &plan.edges[u.edge.index()]);
    let (all, breaks) = (&line.ts[..], &line.breaks[..]);
    let forwards = u.from < u.to;
    ts.clear();
    let (mut at, mut from) = (u.from, breaks[u.from as usize] as usize);
    while at != u.to {
        // A break has its own stored point, so that all faces get the same bits.
        positions.push(if at == u.from { u.start.0 } else { edge.breaks[at as usize].point });
        at = if forwards { at + 1 } else { at - 1 };
        let (to, first) = (breaks[at as usize] as usize, ts.len());
        for i in 0..from.abs_diff(to) {
            let k = if forwards { from + i } else { from - i };
            ts.push(all[k]);
            origins.push(origin(part, u.edge, k as u32));
        }
        // The shape may be in no cache: it is not read where nothing is between the breaks.
        let between = &ts[first + 1..];
        if !between.is_empty() {
            match &edge.shape {
                EdgeShape::Curve(curve) => curve.points(between, positions),
                EdgeShape::Point(p) => between.iter().for_each(|_| positions.push(*p)),
            }
        }
        from = to;
    }
}

/// Appends the cell coordinates of the tile's tessellants.
#[inline(always)]
fn to_cells((tile, lattice): (&Tile, &TileLattice), uvs: &[DVec2], out: &mut Vec<DVec2>) {
    let (cells, scale) = (lattice.cells(), cell_size(tile, lattice));
    if cells == (1, 1) {
        for &uv in uvs {
            out.push(((uv - tile.min) / (tile.max - tile.min)).clamp(DVec2::ZERO, DVec2::ONE) * scale);
        }
        return;
    }
    let (mut along_u, mut along_v) = (CellWalk::new(&lattice.us), CellWalk::new(&lattice.vs));
    for uv in uvs {
        out.push(DVec2::new(snap(along_u.cell(uv.x), cells.0), snap(along_v.cell(uv.y), cells.1)));
    }
}

#[inline(always)]
fn origin(part: &PreparedPart, edge: RowId, k: u32) -> Origin {
    if edge.index() < part.brep_edges {
        Origin::Edge { edge: EdgeId(edge.0), k }
    } else {
        Origin::Border { border: edge.0 - part.brep_edges as u32, k }
    }
}

#[inline(always)]
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

/// Fewest lattice points to evaluate line by line. With fewer, setting up the lines costs more than it saves.
const LATTICE_FROM: usize = 16;
/// Evaluates line by line only if at least one in this many of the lattice's points is used.
const LATTICE_SHARE: usize = 4;

/// Evaluates the positions of lattice points and crossings, and the normals of all vertices. A plane has one normal.
///
/// Positions of tessellants are those of their edges. Lattices that are largely used are evaluated line by line, all
/// else point by point. Both give the same bits.
pub(crate) fn evaluate_vertices(
    face: &PreparedFace,
    lattice: &TileLattice,
    corners_used: usize,
    s: &mut Scratch,
    mesh: &mut TileMesh,
) {
    let Scratch { outline, uvs, vertices, evaluate, .. } = s;
    let (tessellants, side) = (outline.len(), if face.reversed { -1.0 } else { 1.0 });
    let corners = &vertices[tessellants..];
    let TileMesh { positions, normals, .. } = mesh;
    positions.reserve_exact(uvs.len());
    positions.extend_from_slice(outline);
    // All are evaluated below. A position that stays NaN fails every check.
    positions.resize(uvs.len(), DVec3::NAN);
    if let Some(normal) = face.plane_normal {
        normals.resize(uvs.len(), (normal * side).as_vec3());
        let positions = &mut positions[tessellants..];
        evaluate_points(&face.patches, &uvs[tessellants..], &mut |first, points| {
            positions[first..].iter_mut().zip(points.iter()).for_each(|(to, (position, _))| *to = position);
        });
        return;
    }
    normals.resize(uvs.len(), Vec3::Z);
    let (positions, normals) = (&mut positions[tessellants..], &mut normals[..]);
    let normal = move |n: DVec3| (n * side).as_vec3();
    evaluate_points(&face.patches, &uvs[..tessellants], &mut |first, points| {
        normals[first..].iter_mut().zip(points.iter()).for_each(|(to, (_, n))| *to = normal(n));
    });
    let normals = &mut normals[tessellants..];
    let mut rest = &uvs[tessellants..];
    let mut first = 0;
    if corners_used >= LATTICE_FROM && corners_used * LATTICE_SHARE >= corners.len() {
        let (positions, normals) = (&mut *positions, &mut *normals);
        // Owns its slices: if it referred to them, they would be loaded again for each point.
        let put = move |vertex: usize, position: DVec3, n: DVec3| {
            let k = vertex - tessellants;
            positions[k] = position;
            normals[k] = normal(n);
        };
        evaluate_lattice(&face.patches, &lattice.us, &lattice.vs, corners, evaluate, put);
        (first, rest) = (corners_used, &rest[corners_used..]);
    }
    evaluate_points(&face.patches, rest, &mut |k, points| {
        for (k, (position, n)) in (first + k..).zip(points.iter()) {
            positions[k] = position;
            normals[k] = normal(n);
        }
    });
}
