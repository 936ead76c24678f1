//! One tile, one thread: prepared tile and plan in, triangles out.

use super::evaluate::{EvaluateScratch, evaluate_lattice, evaluate_points};
use super::ladder::Rung;
use super::lift::Surface;
use super::narrow::narrow;
use super::patch::PatchScratch;
use super::plan::{CellWalk, PartPlan, Plan, TileLattice};
use super::samples::Samples;
use super::trim::{
    TrimInput, TrimOutcome, TrimOutput, TrimScratch, fill_loops, reference::trim_tile_reference, trim_tile,
};
use super::unfold::unfold;
use crate::mesh::{EdgeLine, Origin, PatchMesh, TileId};
use crate::model::{EdgeId, FaceId, PartId, SurfaceKind};
use crate::prepare::{EdgeShape, EdgeUse, Prepared, PreparedEdge, PreparedFace, PreparedPart, Tile};
use glam::{DVec2, DVec3, Vec2};
use std::fmt;
use std::sync::Arc;

/// Cell coordinates this close to the tile's border are on it: parameters come from projections that are good to about
/// 1e-12 of the domain, and a border that is almost straight would make slivers.
const BORDER_SNAP: f64 = 1e-9;

/// Corners from which on a lattice is evaluated line by line: below, setting up the lines costs more than they save.
pub(super) const LATTICE_FROM: usize = 16;
/// And the part of the lattice that must be used at least, as one over it.
pub(super) const LATTICE_SHARE: usize = 4;

/// No lattice corner, no vertex.
pub(super) const NONE: u32 = u32::MAX;

/// Buffers that one worker reuses for all its tiles. Leaves no trace in results.
#[derive(Default)]
pub struct Scratch {
    pub(super) cells: Vec<DVec2>,
    pub(super) uvs: Vec<DVec2>,
    pub(super) loop_starts: Vec<u32>,
    /// By lattice point: its vertex, or none.
    pub(super) corners: Vec<u32>,
    pub(super) normals: Vec<DVec3>,
    pub(super) points: Vec<DVec3>,
    /// Points and normals of the whole lattice.
    pub(super) lattice: (Vec<DVec3>, Vec<DVec3>),
    pub(super) trim: TrimScratch,
    pub(super) trimmed: TrimOutput,
    pub(super) evaluate: EvaluateScratch,
    pub(super) patch: PatchScratch,
    /// Buffers for coming tiles.
    spare: Vec<PatchMesh>,
}

impl Scratch {
    /// A mesh without content.
    pub(super) fn spare(&mut self) -> PatchMesh {
        self.spare.pop().unwrap_or_default()
    }

    /// Gives the buffers of a mesh that is no longer needed to tiles to come. What it holds is lost.
    pub fn reuse(&mut self, mut mesh: PatchMesh) {
        mesh.clear();
        self.spare.push(mesh);
    }
}

/// How a tile fell short of the normal path.
#[derive(Clone, Debug, PartialEq)]
pub enum Degradation {
    /// The trim loops cross themselves or each other: each point is covered as often as they wind around it.
    NotSimple {
        /// Boundary segments split at crossings; the triangles that only close join them to the neighbouring faces.
        split: u32,
        /// The first crossing, in the part's coordinates, where segments had to be split.
        place: Option<DVec3>,
    },
    /// The boundary cancels at this tolerance: nothing has to be filled. Where the face has other tiles, these close over it.
    Empty,
    /// The tile could not be triangulated: its boundary is filled in space.
    Filled(String),
    /// Not even the boundary is known: there are no triangles. A defect of this crate.
    Failed(String),
}

impl fmt::Display for Degradation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSimple { split, .. } => {
                write!(
                    f,
                    "the boundary crosses or overlaps itself ({split} segments split); covered as often as it winds"
                )
            }
            Self::Empty => write!(f, "nothing is left of the face at this tolerance"),
            Self::Filled(why) => write!(f, "filled in space, not triangulated: {why}"),
            Self::Failed(why) => write!(f, "no triangles: {why}"),
        }
    }
}

/// A tile's triangles and how they came about.
#[derive(Clone, Debug)]
pub struct TileOutcome {
    /// The face.
    pub face: FaceId,
    /// The triangles.
    pub mesh: PatchMesh,
    /// How far down the ladder of fallbacks it went; [`Rung::Repaired`] at least where prepare repaired the face.
    pub rung: Rung,
    /// What went wrong, if anything did.
    pub degradation: Option<Degradation>,
    /// Triangles that only close the boundary; where the loops are not simple, also those that have no area.
    pub slivers: u32,
    /// Area that the boundary winds around otherwise than once, mm².
    pub rewound: f64,
}

impl TileOutcome {
    /// A tile of which nothing could be made.
    #[must_use]
    pub fn lost(face: FaceId, why: String) -> Self {
        let degradation = Some(Degradation::Failed(why));
        Self { face, mesh: PatchMesh::default(), rung: Rung::Lost, degradation, slivers: 0, rewound: 0.0 }
    }
}

/// Point of an edge's tessellant at `t`: the break's own point where it is one, so that all faces have the same bits.
pub(super) fn edge_point(edge: &PreparedEdge, at_break: Option<u32>, t: f64) -> DVec3 {
    match (at_break, &edge.shape) {
        (Some(k), _) => edge.breaks[k as usize].point,
        (None, EdgeShape::Curve(c)) => c.point(t),
        (None, EdgeShape::Point(p)) => *p,
    }
}

/// Tessellates one tile under a plan.
///
/// Pure function of its arguments; `scratch` only saves allocations. Cost: tens of nanoseconds per boundary tessellant,
/// about 10 ns per lattice point.
#[must_use]
pub fn tessellate_tile(
    prepared: &Prepared,
    plan: &Plan,
    part: PartId,
    tile: TileId,
    scratch: &mut Scratch,
) -> TileOutcome {
    let job = Job::of(prepared, plan, part, tile);
    let mut mesh = scratch.spare();
    trace_loops(job.part, job.plan, job.tile, job.lattice, job.face, scratch, &mut mesh);
    let trimmed = job.trim(scratch, &mesh);
    job.finish(trimmed, None, scratch, mesh).0
}

/// How a tile was triangulated.
pub(super) enum Trimmed {
    /// From its loops.
    By(TrimOutcome),
    /// Not at all, for this reason: its boundary is filled.
    Filled(String),
}

/// A tile and what it is made by.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub(super) part: &'a PreparedPart,
    pub(super) plan: &'a PartPlan,
    pub(super) tile: &'a Tile,
    pub(super) lattice: &'a Arc<TileLattice>,
    pub(super) face: &'a PreparedFace,
}

impl<'a> Job<'a> {
    pub(super) fn of(prepared: &'a Prepared, plan: &'a Plan, part: PartId, tile: TileId) -> Self {
        let rows = &prepared.parts[part.index()];
        let plan = &plan.parts[part.index()];
        let row = &rows.tiles[tile.0 as usize];
        let face = &rows.faces[rows.face_of(row)];
        Self { part: rows, plan, tile: row, lattice: &plan.tiles[tile.0 as usize], face }
    }

    /// Triangles of the loops that the scratch and the mesh have.
    pub(super) fn trim(&self, scratch: &mut Scratch, mesh: &PatchMesh) -> Trimmed {
        let Scratch { cells, loop_starts, trim, trimmed, .. } = scratch;
        let input = TrimInput { cells: self.lattice.cells(), points: cells, loop_starts, places: &mesh.positions };
        // What loops that meet wind around otherwise than once is measured there.
        let outcome =
            if self.tile.entangled { trim_tile_reference(&input, trimmed) } else { trim_tile(&input, trim, trimmed) };
        match outcome {
            Ok(outcome) => Trimmed::By(outcome),
            Err(refused) => {
                fill_loops(&input, trimmed);
                Trimmed::Filled(refused.to_string())
            }
        }
    }

    /// The rest of a tile whose loops were traced and triangulated; and whether its triangles are just those.
    pub(super) fn finish(
        &self,
        trimmed: Trimmed,
        kept: Option<&mut Kept<'_>>,
        scratch: &mut Scratch,
        mut mesh: PatchMesh,
    ) -> (TileOutcome, bool) {
        let Self { tile, lattice, face, .. } = *self;
        let as_trimmed = finish(face, (tile, lattice), kept, scratch, &mut mesh);
        let rewound = add_layers(face, scratch, &mut mesh);
        let before = mesh.triangles.len();
        scratch.trimmed.closing.iter().for_each(|&t| push_triangle(&mut mesh, t, face.reversed));
        let mut slivers = (mesh.triangles.len() - before) as u32;
        if face.filled || !matches!(trimmed, Trimmed::By(outcome) if outcome < TrimOutcome::Repaired { split: 0 }) {
            slivers += mesh.triangles[..before].iter().filter(|&&t| has_no_area(&mesh, t)).count() as u32;
        }
        let least = match face {
            PreparedFace { filled: true, .. } => Rung::Filled,
            PreparedFace { repaired: true, .. } => Rung::Repaired,
            _ => Rung::Normal,
        };
        let (rung, degradation) = match trimmed {
            _ if mesh.triangles.is_empty() => (Rung::NoArea, Some(Degradation::Empty)),
            Trimmed::Filled(why) => (Rung::Filled, Some(Degradation::Filled(why))),
            Trimmed::By(TrimOutcome::Repaired { split }) => {
                let first = mesh.origins.iter().position(|o| matches!(o, Origin::Crossing { .. }));
                let place = first.map(|k| mesh.positions[k]);
                (Rung::Repaired.max(least), Some(Degradation::NotSimple { split, place }))
            }
            Trimmed::By(outcome) => (Rung::of(outcome, &scratch.trimmed.stats).max(least), None),
        };
        (TileOutcome { face: tile.face, mesh, rung, degradation, slivers, rewound }, as_trimmed)
    }
}

fn has_no_area(mesh: &PatchMesh, corners: [u32; 3]) -> bool {
    let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
    (b - a).cross(c - a) == DVec3::ZERO
}

/// Appends what the loops wind around otherwise than once, and returns its area, mm².
fn add_layers(face: &PreparedFace, s: &Scratch, mesh: &mut PatchMesh) -> f64 {
    let mut area = 0.0;
    for &([a, b, c], times) in &s.trimmed.layers {
        let [p, q, r] = [a, b, c].map(|v| mesh.positions[v as usize]);
        area += 0.5 * (q - p).cross(r - p).length();
        for _ in 0..times.unsigned_abs() {
            push_triangle(mesh, [a, b, c], face.reversed != (times < 0));
        }
    }
    area
}

/// Tessellants of the tile's loops: cell coordinates, parameters, positions.
pub(super) fn trace_loops(
    part: &PreparedPart,
    plan: &PartPlan,
    tile: &Tile,
    lattice: &TileLattice,
    face: &PreparedFace,
    s: &mut Scratch,
    mesh: &mut PatchMesh,
) {
    s.cells.clear();
    s.uvs.clear();
    s.loop_starts.clear();
    s.loop_starts.push(0);
    let mut spot = Spot::of(face, tile, lattice);
    for l in &tile.loops {
        for u in l {
            let edge = &part.edges[u.edge as usize];
            let polyline = &plan.edges[u.edge as usize];
            let mut hint = 0;
            for (k, at_break) in steps_with_breaks(u, &polyline.breaks) {
                let uv = u.uv.point(polyline.ts[k], &mut hint);
                s.cells.push(spot.cell(uv));
                s.uvs.push(uv);
                mesh.positions.push(edge_point(edge, at_break, polyline.ts[k]));
                mesh.origins.push(origin(part, u.edge, k as u32));
            }
        }
        s.loop_starts.push(s.cells.len() as u32);
    }
}

/// Where parameters are in a tile's cells: quickest for those that are near the ones before.
pub(super) struct Spot<'a> {
    tile: &'a Tile,
    cells: (u32, u32),
    scale: DVec2,
    along: [CellWalk<'a>; 2],
}

impl<'a> Spot<'a> {
    pub(super) fn of(face: &PreparedFace, tile: &'a Tile, lattice: &'a TileLattice) -> Self {
        let along = [CellWalk::new(&lattice.us), CellWalk::new(&lattice.vs)];
        Self { tile, cells: lattice.cells(), scale: cell_size(face, tile, lattice), along }
    }

    #[inline(always)]
    pub(super) fn cell(&mut self, uv: DVec2) -> DVec2 {
        let Self { tile, cells, scale, along: [u, v] } = self;
        if *cells == (1, 1) {
            return ((uv - tile.min) / (tile.max - tile.min)).clamp(DVec2::ZERO, DVec2::ONE) * *scale;
        }
        DVec2::new(snap(u.cell(uv.x), cells.0), snap(v.cell(uv.y), cells.1))
    }
}

/// Tessellant numbers of a use, in loop order, without the last.
pub(super) fn steps(u: &EdgeUse, breaks: &[u32]) -> impl Iterator<Item = usize> + use<> {
    let (a, b) = (breaks[u.from as usize] as usize, breaks[u.to as usize] as usize);
    let count = a.abs_diff(b);
    (0..count).map(move |i| if a < b { a + i } else { a - i })
}

/// The same, with the break that each is, if it is one.
pub(super) fn steps_with_breaks<'a>(
    u: &'a EdgeUse,
    breaks: &'a [u32],
) -> impl Iterator<Item = (usize, Option<u32>)> + use<'a> {
    let mut next = u.from;
    steps(u, breaks).map(move |k| {
        let at_break = (breaks[next as usize] as usize == k).then_some(next);
        if at_break.is_some() {
            next = if u.from < u.to { next + 1 } else { next.saturating_sub(1) };
        }
        (k, at_break)
    })
}

pub(super) fn origin(part: &PreparedPart, edge: u32, k: u32) -> Origin {
    if (edge as usize) < part.brep_edges {
        Origin::Edge { edge: EdgeId(edge), k }
    } else {
        Origin::Border { border: edge - part.brep_edges as u32, k }
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

/// Size of the tile's cells in cell units. A single cell has no lines to respect: its coordinates keep the face's proportions,
/// for better triangles.
pub(super) fn cell_size(face: &PreparedFace, tile: &Tile, lattice: &TileLattice) -> DVec2 {
    if lattice.cells() == (1, 1) { proportions(face, tile) } else { DVec2::ONE }
}

/// Length of the tile in u and in v as shares of the longer one.
fn proportions(face: &PreparedFace, tile: &Tile) -> DVec2 {
    let middle = 0.5 * (tile.min + tile.max);
    let d = face.patches.derivatives(middle.x, middle.y);
    let size = DVec2::new(d.du.length(), d.dv.length()) * (tile.max - tile.min);
    let longest = size.max_element();
    if longest > 0.0 && longest.is_finite() { (size / longest).max(DVec2::splat(1e-6)) } else { DVec2::ONE }
}

/// What is known of a tile that is patched.
pub(super) struct Kept<'a> {
    pub(super) samples: &'a Samples,
    /// Which vertex each tessellant was.
    pub(super) from: &'a mut Vec<u32>,
    /// Triangles of the trim stage that are new, the first ones; of the others it is known that nothing has to be changed.
    pub(super) fresh: usize,
}

/// Lattice points, normals and oriented triangles. Whether no triangle had to be changed.
fn finish(
    face: &PreparedFace,
    (tile, lattice): (&Tile, &TileLattice),
    kept: Option<&mut Kept<'_>>,
    s: &mut Scratch,
    mesh: &mut PatchMesh,
) -> bool {
    let tessellants = s.cells.len() as u32;
    let (nu, nv) = lattice.cells();
    let corners = (nu + 1) * (nv + 1);
    s.corners.clear();
    s.corners.resize(corners as usize, NONE);
    let mut next = tessellants;
    let mut use_corner = |c: u32, uvs: &mut Vec<DVec2>, origins: &mut Vec<Origin>| {
        let slot = &mut s.corners[c as usize];
        if *slot == NONE {
            *slot = next;
            next += 1;
            let (i, j) = (c % (nu + 1), c / (nu + 1));
            uvs.push(DVec2::new(lattice.us[i as usize], lattice.vs[j as usize]));
            origins.push(Origin::Lattice { i, j });
        }
        *slot
    };
    s.trimmed.rename(|v| {
        if v >= tessellants && v < tessellants + corners {
            use_corner(v - tessellants, &mut s.uvs, &mut mesh.origins)
        } else {
            v
        }
    });
    let corner = |i: u32, j: u32| j * (nu + 1) + i;
    let mut quads = Vec::with_capacity(s.trimmed.full_cells.len());
    for &[i, j] in &s.trimmed.full_cells {
        quads.push(
            [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]
                .map(|c| use_corner(c, &mut s.uvs, &mut mesh.origins)),
        );
    }
    let corners_used = next - tessellants;
    for (k, p) in s.trimmed.extra_points.iter().enumerate() {
        s.uvs.push(from_cells(lattice, *p / cell_size(face, tile, lattice)));
        mesh.origins.push(Origin::Crossing { k: k as u32 });
    }
    if !s.trimmed.extra_points.is_empty() {
        s.trimmed.rename(|v| if v >= tessellants + corners { v - corners + corners_used } else { v });
    }
    let mut fresh = usize::MAX;
    if let Some(Kept { samples, from, fresh: new }) = kept {
        samples.find_corners(lattice, s, from);
        samples.evaluate(face, lattice, from, s, mesh);
        fresh = *new;
    } else {
        evaluate(face, lattice, tessellants as usize, corners_used as usize, s, &mut mesh.positions);
        let side = if face.reversed { -1.0 } else { 1.0 };
        mesh.normals.extend(s.normals.iter().map(|n| (*n * side).as_vec3()));
    }
    mesh.uvs.extend(
        s.uvs.iter().map(|p| Vec2::new(face.maps[0].to_natural(p.x) as f32, face.maps[1].to_natural(p.y) as f32)),
    );
    for ((to, from), map) in mesh.lines.iter_mut().zip([&lattice.us, &lattice.vs]).zip(&face.maps) {
        to.extend(from.iter().map(|&x| map.to_natural(x) as f32));
    }
    mesh.triangles.reserve(s.trimmed.triangles.len() + 2 * quads.len());
    let mut trimmed = 0;
    for (k, t) in s.trimmed.triangles.iter().enumerate() {
        push_triangle(mesh, *t, face.reversed);
        if k < fresh {
            trimmed = mesh.triangles.len();
        }
    }
    for [a, b, c, d] in quads {
        let p = |v: u32| mesh.positions[v as usize];
        let halves = if p(a).distance_squared(p(c)) <= p(b).distance_squared(p(d)) {
            [[a, b, c], [a, c, d]]
        } else {
            [[a, b, d], [b, c, d]]
        };
        for t in halves {
            push_triangle(mesh, t, face.reversed);
        }
    }
    if face.kind == SurfaceKind::Plane {
        return true;
    }
    let mut as_trimmed = true;
    let mut surface = Surface { face, uvs: &mut s.uvs };
    // On a crease a point has two normals, and the one that is kept says nothing about the triangles beyond.
    if face.creases.iter().all(Vec::is_empty) {
        as_trimmed &= !unfold(mesh, trimmed, lattice.chord, &surface);
    }
    let cell = |mesh: &PatchMesh, v: u32| match mesh.origins[v as usize] {
        Origin::Lattice { i, j } => DVec2::new(f64::from(i), f64::from(j)),
        Origin::Crossing { k } => s.trimmed.extra_points[k as usize],
        _ => s.cells[v as usize],
    };
    as_trimmed & !narrow(mesh, trimmed, lattice.chord, &mut surface, cell)
}

/// Normals of all vertices into `s.normals`, and positions of those that are not tessellants.
///
/// Lattices that are mostly used are evaluated line by line, all else one by one. Both give the same bits.
fn evaluate(
    face: &PreparedFace,
    lattice: &TileLattice,
    tessellants: usize,
    corners_used: usize,
    s: &mut Scratch,
    positions: &mut Vec<DVec3>,
) {
    let Scratch { uvs, corners, normals, points, evaluate, lattice: on_lattice, .. } = s;
    if corners_used < LATTICE_FROM || corners_used * LATTICE_SHARE < corners.len() {
        evaluate_points(&face.patches, uvs, points, normals);
        positions.extend_from_slice(&points[tessellants..]);
        return;
    }
    let width = lattice.us.len();
    let wanted = |i: usize, j: usize| corners[j * width + i] != NONE;
    let (all_points, all_normals) = on_lattice;
    evaluate_lattice(&face.patches, &lattice.us, &lattice.vs, wanted, evaluate, all_points, all_normals);
    evaluate_points(&face.patches, &uvs[..tessellants], points, normals);
    positions.resize(tessellants + corners_used, DVec3::ZERO);
    normals.resize(tessellants + corners_used, DVec3::Z);
    let height = lattice.vs.len();
    for (c, &vertex) in corners.iter().enumerate().filter(|&(_, &vertex)| vertex != NONE) {
        let at = c % width * height + c / width;
        positions[vertex as usize] = all_points[at];
        normals[vertex as usize] = all_normals[at];
    }
    let crossings = &uvs[tessellants + corners_used..];
    if !crossings.is_empty() {
        let (all_points, all_normals) = on_lattice;
        evaluate_points(&face.patches, crossings, all_points, all_normals);
        positions.extend_from_slice(all_points);
        normals.extend_from_slice(all_normals);
    }
}

/// Appends a triangle unless two of its corners are one point (a pole): both its other sides are the same edge.
#[inline(always)]
fn push_triangle(mesh: &mut PatchMesh, [a, b, c]: [u32; 3], reversed: bool) {
    let p = |v: u32| mesh.positions[v as usize];
    if p(a) != p(b) && p(b) != p(c) && p(c) != p(a) {
        mesh.triangles.push(if reversed { [a, c, b] } else { [a, b, c] });
    }
}

/// Parameters of a point in cell units.
fn from_cells(lattice: &TileLattice, p: DVec2) -> DVec2 {
    let at = |lines: &[f64], x: f64| {
        let k = (x.max(0.0) as usize).min(lines.len() - 2);
        lines[k] + (x - k as f64) * (lines[k + 1] - lines[k])
    };
    DVec2::new(at(&lattice.us, p.x), at(&lattice.vs, p.y))
}

/// The polyline of a B-rep edge under a plan. Empty for an edge that no tile uses.
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
