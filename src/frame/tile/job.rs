//! A prepared tile and a plan -> its triangles.

use super::outcome::{Degradation, Rung, TileOutcome};
use crate::frame::plan::output::{PartPlan, Plan, TileLattice};
use crate::frame::refine::lift::FaceSurface;
use crate::frame::refine::narrow::narrow;
use crate::frame::refine::unfold::unfold;
use crate::frame::refine::web::TriangleShape;
use crate::frame::trim::climb::{fill_loops, trim_tile};
use crate::frame::trim::input::{NONE, TrimInput};
use crate::frame::trim::output::{TrimOutcome, TrimOutput};
use crate::frame::trim::reference::trim_tile_reference;
use crate::frame::vertices::{Scratch, cell_size, evaluate_vertices, trace_loops, trace_use};
use crate::math::lanes::{smaller, widest};
use crate::mesh::{MeshLists, Origin, TileMesh};
use crate::model::{AxisMap, PartId, SurfaceKind, TileId};
use crate::prepare::Prepared;
use crate::prepare::internals::{PreparedFace, PreparedPart, Tile};
use glam::{DVec2, DVec3, Vec2};
use smallvec::SmallVec;
use std::collections::BTreeMap;

/// Tessellates one tile by a plan. Of the lists that not every sink reads, the mesh has these.
///
/// Pure function of its arguments; `scratch` only saves allocations. Cost: tens of nanoseconds per boundary tessellant,
/// about 10 ns per lattice point.
#[must_use]
pub fn tessellate_tile(
    prepared: &Prepared,
    plan: &Plan,
    (part, tile): (PartId, TileId),
    lists: MeshLists,
    scratch: &mut Scratch,
) -> TileOutcome {
    let job = Job::of(prepared, plan, part, tile);
    trace_loops(job.part, job.plan, job.tile, job.lattice, scratch);
    let trimmed = job.trim(scratch);
    job.finish(trimmed, lists, scratch)
}

/// A tile and everything that its tessellation reads.
#[derive(Clone, Copy)]
struct Job<'a> {
    part: &'a PreparedPart,
    plan: &'a PartPlan,
    tile: &'a Tile,
    lattice: &'a TileLattice,
    face: &'a PreparedFace,
}

impl<'a> Job<'a> {
    fn of(prepared: &'a Prepared, plan: &'a Plan, part: PartId, tile: TileId) -> Self {
        let rows = &prepared.parts[part.index()];
        let plan = &plan.parts[part.index()];
        let row = &rows.tiles[tile.0 as usize];
        let face = rows.face_of(row);
        Self { part: rows, plan, tile: row, lattice: &plan.tiles[tile.0 as usize], face }
    }

    /// Triangulates the loops in the scratch. The triangles go to `scratch.trimmed`. Where the trim stage refuses, it
    /// says why, and the boundary is filled.
    fn trim(&self, scratch: &mut Scratch) -> Result<TrimOutcome, String> {
        let Scratch { outline, cells, loop_starts, trim, trimmed, .. } = scratch;
        let input = TrimInput { cells: self.lattice.cells(), points: cells, loop_starts, places: outline };
        // Only the reference measures the area that meeting loops do not wind around exactly once.
        let outcome =
            if self.tile.entangled { trim_tile_reference(&input, trimmed) } else { trim_tile(&input, trim, trimmed) };
        outcome.map_err(|refused| {
            fill_loops(&input, trimmed);
            refused.to_string()
        })
    }

    /// Finishes a tile whose loops were traced and triangulated.
    fn finish(&self, trimmed: Result<TrimOutcome, String>, lists: MeshLists, scratch: &mut Scratch) -> TileOutcome {
        let Self { tile, lattice, face, .. } = *self;
        let mut mesh = scratch.take_mesh();
        make_triangles(face, (tile, lattice), scratch, &mut mesh);
        add_parameters(face, lattice, lists, (&scratch.uvs, &mut mesh));
        let rewound = add_layers(face, scratch, &mut mesh);
        let before = mesh.triangles.len();
        scratch.trimmed.closing.iter().for_each(|&t| push_triangle(&mut mesh, t, face.reversed));
        let mut slivers = (mesh.triangles.len() - before) as u32;
        if face.filled || !matches!(trimmed, Ok(outcome) if outcome < TrimOutcome::Repaired { split: 0 }) {
            slivers += mesh.triangles[..before].iter().filter(|&&t| has_no_area(&mesh, t)).count() as u32;
        }
        let least = match face {
            PreparedFace { filled: true, .. } => Rung::Filled,
            PreparedFace { repaired: true, .. } => Rung::Repaired,
            _ => Rung::Normal,
        };
        let (rung, degradation) = match trimmed {
            Err(why) => (Rung::Filled, Some(Degradation::Filled(why))),
            Ok(_) if mesh.triangles.is_empty() => (Rung::NoArea, Some(Degradation::Empty)),
            Ok(TrimOutcome::Repaired { split }) => {
                let first = mesh.origins.iter().position(|o| matches!(o, Origin::Crossing { .. }));
                let place = first.map(|k| mesh.positions[k]);
                let depth = depth_of_layers(&scratch.trimmed.layers, &mesh.positions);
                (Rung::Repaired.max(least), Some(Degradation::NotSimple { split, depth, chord: lattice.chord, place }))
            }
            Ok(outcome) => (Rung::of(outcome, &scratch.trimmed.stats).max(least), None),
        };
        std::mem::swap(&mut mesh.origins, &mut scratch.origins);
        if lists.origins {
            mesh.origins.extend_from_slice(&scratch.origins);
        }
        TileOutcome { face: tile.face, mesh, rung, degradation, slivers, rewound }
    }
}

fn has_no_area(mesh: &TileMesh, corners: [u32; 3]) -> bool {
    let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
    (b - a).cross(c - a) == DVec3::ZERO
}

/// Appends the layers: what the loops wind around, but not exactly once. Returns their area, mm².
fn add_layers(face: &PreparedFace, s: &Scratch, mesh: &mut TileMesh) -> f64 {
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

/// How far points of the layers may be from their outline, mm: the heights of triangles, added up from triangle to
/// triangle, from those with a side on it. Layers without an outline count with their largest height.
fn depth_of_layers(layers: &[([u32; 3], i32)], positions: &[DVec3]) -> f64 {
    let sides = |k: usize| {
        let [a, b, c] = layers[k].0;
        [[a, b], [b, c], [c, a]].map(|[from, to]| [from.min(to), from.max(to)])
    };
    let mut beside: BTreeMap<[u32; 2], SmallVec<[usize; 2]>> = BTreeMap::new();
    for k in 0..layers.len() {
        for side in sides(k) {
            beside.entry(side).or_default().push(k);
        }
    }
    let height = |k: usize, [from, to]: [u32; 2]| {
        let [p, q, r] = layers[k].0.map(|v| positions[v as usize]);
        let height = (q - p).cross(r - p).length() / positions[from as usize].distance(positions[to as usize]);
        // A side that is a point has none, and its triangle has no area.
        height.max(0.0)
    };
    let least = |k: usize| {
        let outer = sides(k).into_iter().filter(|side| beside[side].len() == 1);
        outer.map(|side| height(k, side)).reduce(f64::min)
    };
    let mut depths: Vec<Option<f64>> = (0..layers.len()).map(least).collect();
    let mut reached: Vec<usize> = (0..layers.len()).filter(|&k| depths[k].is_some()).collect();
    let mut at = 0;
    while let Some(&k) = reached.get(at) {
        at += 1;
        for side in sides(k) {
            for &other in &beside[&side] {
                if depths[other].is_none() {
                    depths[other] = depths[k].map(|depth| depth + height(other, side));
                    reached.push(other);
                }
            }
        }
    }
    let largest = |k: usize| sides(k).map(|side| height(k, side)).into_iter().fold(0.0, f64::max);
    let depths = depths.iter().enumerate().map(|(k, depth)| depth.unwrap_or_else(|| largest(k)));
    depths.fold(0.0, f64::max)
}

/// Makes lattice points, normals and oriented triangles, and refines those of the trim stage.
fn make_triangles(face: &PreparedFace, (tile, lattice): (&Tile, &TileLattice), s: &mut Scratch, mesh: &mut TileMesh) {
    let corners_used = name_vertices((tile, lattice), s);
    std::mem::swap(&mut mesh.origins, &mut s.origins);
    evaluate_vertices(face, lattice, corners_used, s, mesh);
    mesh.triangles.reserve_exact(s.trimmed.triangles.len() + 2 * s.trimmed.full_cells.len());
    mesh.triangles.extend_from_slice(&s.trimmed.triangles);
    if face.reversed {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    // A point on a sharp crease has two normals, and the one it stores says nothing about the triangles on the other
    // side.
    let unfolds = face.kind != SurfaceKind::Plane && !face.sharp;
    s.doubtful.clear();
    if unfolds {
        list_doubtful(mesh, &mut s.doubtful);
    } else {
        let TileMesh { positions, triangles, .. } = mesh;
        triangles.retain(|&t| are_apart(positions, t));
    }
    // How many triangles may be wider than a cell: halves of full cells are not.
    let mut count = mesh.triangles.len();
    push_full_cells(mesh, (&s.runs, &s.vertices[s.outline.len()..]), lattice.us.len(), face.reversed);
    if face.kind == SurfaceKind::Plane {
        return;
    }
    let TileLattice { chord, loosest, .. } = *lattice;
    let mut surface = FaceSurface { face, uvs: &mut s.uvs, chord, loosest };
    if unfolds && unfold(mesh, &s.doubtful, tile.entangled || face.repaired, &surface) {
        // Halves of full cells may have been flipped, too.
        count = mesh.triangles.len();
    }
    if lattice.cells() == (1, 1) {
        // Nothing is wider than the tile.
        return;
    }
    narrow(mesh, count, &mut surface, &s.cells);
}

/// Turns the lattice corners that triangles and full cells use into vertices, and names crossings after them. Returns
/// the number of these corners.
fn name_vertices((tile, lattice): (&Tile, &TileLattice), s: &mut Scratch) -> usize {
    let tessellants = s.cells.len() as u32;
    let (nu, nv) = lattice.cells();
    let width = nu + 1;
    let corners = width * (nv + 1);
    s.vertices.clear();
    s.vertices.extend(0..tessellants);
    s.vertices.resize((tessellants + corners) as usize, NONE);
    s.used.resize(corners as usize + 1, [0; 2]);
    let mut used = UsedCorners { tessellants, used: &mut s.used, count: 0 };
    let vertices = &mut s.vertices[..];
    s.trimmed.rename(
        tessellants,
        // Inlined, because it is called for every corner of every triangle.
        #[inline(always)]
        |v| vertices.get_mut(v as usize).map_or(v, |slot| used.vertex(slot, [v, 0])),
    );
    for place in &mut used.used[..used.count] {
        let c = place[0] - tessellants;
        *place = [c % width, c / width];
    }
    let slots = &mut vertices[tessellants as usize..];
    s.runs.clear();
    for run in s.trimmed.full_cells.chunk_by(|&[i, j], &[k, l]| k == i + 1 && l == j) {
        let ([i, j], count) = (run[0], run.len());
        s.runs.push([i, j, count as u32]);
        let (below, above) = slots[(j * width + i) as usize..].split_at_mut(width as usize);
        let [first, below @ ..] = &mut below[..=count] else { continue };
        let [last, above @ ..] = &mut above[..=count] else { continue };
        // Counter-clockwise around each cell, without the vertices where the one before it ends.
        used.vertex(first, [i, j]);
        for (k, (b, c)) in (i + 1..).zip(below.iter_mut().zip(above)) {
            used.vertex(b, [k, j]);
            used.vertex(c, [k, j + 1]);
            if k == i + 1 {
                used.vertex(last, [i, j + 1]);
            }
        }
    }
    let corners_used = used.count as u32;
    s.used.truncate(corners_used as usize);
    let (us, vs) = (&lattice.us[..], &lattice.vs[..]);
    s.uvs.extend(s.used.iter().map(|&[i, j]| DVec2::new(us[i as usize], vs[j as usize])));
    s.cells.extend(s.used.iter().map(|&[i, j]| DVec2::new(f64::from(i), f64::from(j))));
    s.origins.extend(s.used.iter().map(|&[i, j]| Origin::Lattice { i, j }));
    for (k, p) in s.trimmed.extra_points.iter().enumerate() {
        s.uvs.push(from_cells(lattice, *p / cell_size(tile, lattice)));
        s.cells.push(*p);
        s.origins.push(Origin::Crossing { k: k as u32 });
    }
    if !s.trimmed.extra_points.is_empty() {
        let first = tessellants + corners;
        s.trimmed.rename(first, |v| if v < first { v } else { v - corners + corners_used });
    }
    corners_used as usize
}

/// Lattice corners that triangles use, which become vertices.
struct UsedCorners<'a> {
    /// Number of vertices before them.
    tessellants: u32,
    /// The first `count` are used; at least one more follows.
    used: &'a mut [[u32; 2]],
    count: usize,
}

impl UsedCorners<'_> {
    /// The vertex of a slot. Makes one at `place` if the slot is [`NONE`], which is larger than all.
    ///
    /// Without a branch: processors cannot guess which corners come for the first time.
    #[inline(always)]
    fn vertex(&mut self, slot: &mut u32, place: [u32; 2]) -> u32 {
        let next = self.tessellants + self.count as u32;
        self.used[self.count] = place;
        *slot = next.min(*slot);
        self.count += usize::from(*slot == next);
        *slot
    }
}

/// Adds the parameters of vertices and lattice lines, in the surface's natural parametrisation.
fn add_parameters(
    face: &PreparedFace,
    lattice: &TileLattice,
    lists: MeshLists,
    (uvs, mesh): (&[DVec2], &mut TileMesh),
) {
    let natural = face.maps.map(AxisMap::naturals);
    if lists.uvs {
        mesh.uvs.extend(uvs.iter().map(|p| Vec2::new(natural[0](p.x) as f32, natural[1](p.y) as f32)));
    }
    if lists.lines {
        for ((to, from), natural) in mesh.lines.iter_mut().zip([&lattice.us, &lattice.vs]).zip(&natural) {
            to.extend(from.iter().map(|&x| natural(x) as f32));
        }
    }
}

/// Appends a triangle unless two of its corners are the same point, as at a pole. Its other two sides then are the same
/// edge, so that nothing opens.
fn push_triangle(mesh: &mut TileMesh, corners: [u32; 3], reversed: bool) {
    if are_apart(&mesh.positions, corners) {
        mesh.triangles.push(oriented(corners, reversed));
    }
}

/// Lists the triangles of a curved face that may be folded, and removes those that [`push_triangle`] leaves out.
fn list_doubtful(mesh: &mut TileMesh, doubtful: &mut Vec<usize>) {
    let TileMesh { positions, normals, triangles, .. } = mesh;
    widest(
        #[inline(always)]
        || {
            // Of one length, so that each corner takes one check.
            let positions = &positions[..];
            let normals = &normals[..positions.len()];
            let least = TriangleShape::clear_area(positions);
            for (k, &corners) in triangles.iter().enumerate() {
                if !TriangleShape::is_clearly_right((positions, normals), corners, least) {
                    doubtful.push(k);
                }
            }
        },
    );
    // A triangle that has an area has no two corners at the same point.
    if doubtful.iter().any(|&k| !are_apart(positions, triangles[k])) {
        let mut removed = 0;
        doubtful.retain_mut(|k| {
            let stays = are_apart(positions, triangles[*k]);
            *k -= removed;
            removed += usize::from(!stays);
            stays
        });
        triangles.retain(|&t| are_apart(positions, t));
    }
}

/// Appends the halves of full cells, split along the shorter diagonal, as [`push_triangle`] does. `corners`: the vertex
/// of each lattice point, in rows of `width`.
fn push_full_cells(mesh: &mut TileMesh, (runs, corners): (&[[u32; 3]], &[u32]), width: usize, reversed: bool) {
    // By value, so that its length stays in a register.
    let mut out = std::mem::take(&mut mesh.triangles);
    widest(
        #[inline(always)]
        || {
            let positions = &mesh.positions[..];
            for &[i, j, count] in runs {
                let row = |j: u32| &corners[j as usize * width + i as usize..][..=count as usize];
                let (below, above) = (row(j), row(j + 1));
                let (mut a, mut d) = (below[0], above[0]);
                let [mut p, mut s] = [a, d].map(|v| positions[v as usize]);
                let mut left = p != s;
                // Each cell begins where the one before it ends.
                for (&b, &c) in below[1..].iter().zip(&above[1..]) {
                    let [q, r] = [b, c].map(|v| positions[v as usize]);
                    let right = q != r;
                    let (first, second) = (p.distance_squared(r), q.distance_squared(s));
                    let halves = if first <= second { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                    if left && right && p != q && r != s && smaller(first, second) > 0.0 {
                        out.extend_from_slice(&halves.map(|half| oriented(half, reversed)));
                    } else {
                        let apart = halves.into_iter().filter(|&half| are_apart(positions, half));
                        out.extend(apart.map(|half| oriented(half, reversed)));
                    }
                    (a, d, p, s, left) = (b, c, q, r, right);
                }
            }
        },
    );
    mesh.triangles = out;
}

/// Whether the corners of a triangle are at three points.
#[inline(always)]
fn are_apart(positions: &[DVec3], corners: [u32; 3]) -> bool {
    let [a, b, c] = corners.map(|v| positions[v as usize]);
    a != b && b != c && c != a
}

/// A triangle with its corners in the order of its face's outside.
#[inline(always)]
fn oriented([a, b, c]: [u32; 3], reversed: bool) -> [u32; 3] {
    if reversed { [a, c, b] } else { [a, b, c] }
}

/// Parameters of a point in cell units.
fn from_cells(lattice: &TileLattice, p: DVec2) -> DVec2 {
    let at = |lines: &[f64], x: f64| {
        let k = (x.max(0.0) as usize).min(lines.len() - 2);
        lines[k] + (x - k as f64) * (lines[k + 1] - lines[k])
    };
    DVec2::new(at(&lattice.us, p.x), at(&lattice.vs, p.y))
}

/// Fills one tile's loops in space, after [`tessellate_tile`] panicked. `why`
/// is the reason to report.
///
/// Uses only the points of edges. Normals are averaged from the triangles, parameters are zero.
#[must_use]
pub(crate) fn fill_tile(prepared: &Prepared, plan: &Plan, part: PartId, tile: TileId, why: String) -> TileOutcome {
    let (rows, plan) = (&prepared.parts[part.index()], &plan.parts[part.index()]);
    let tile = &rows.tiles[tile.0 as usize];
    let reversed = rows.face_of(tile).reversed;
    let mut mesh = TileMesh::default();
    let (mut loop_starts, mut ts) = (vec![0], Vec::new());
    for l in &tile.loops {
        for used in l {
            trace_use((rows, plan), used, &mut ts, (&mut mesh.positions, &mut mesh.origins));
        }
        loop_starts.push(mesh.positions.len() as u32);
    }
    let points = vec![DVec2::ZERO; mesh.positions.len()];
    let input = TrimInput { cells: (1, 1), points: &points, loop_starts: &loop_starts, places: &mesh.positions };
    let mut filled = TrimOutput::default();
    fill_loops(&input, &mut filled);
    mesh.triangles = filled.closing.iter().map(|&corners| oriented(corners, reversed)).collect();
    mesh.uvs = vec![Vec2::ZERO; mesh.positions.len()];
    let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
        corners.iter().for_each(|&v| normals[v as usize] += (b - a).cross(c - a));
    }
    mesh.normals = normals.iter().map(|n| n.normalize_or(DVec3::Z).as_vec3()).collect();
    let slivers = mesh.triangles.len() as u32;
    let degradation = Some(Degradation::Filled(why));
    TileOutcome { face: tile.face, mesh, rung: Rung::Filled, degradation, slivers, rewound: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles in zigzag between two rows of points at a distance, `step` apart in each row.
    fn strip(across: f64, step: f64) -> f64 {
        let row = |y: f64| (0..=100).map(move |k| DVec3::new(step * f64::from(k), y, 0.0));
        let positions: Vec<DVec3> = row(0.0).chain(row(across)).collect();
        let cells = (0..100).flat_map(|k| [[k, k + 1, k + 101], [k + 1, k + 102, k + 101]]);
        depth_of_layers(&cells.map(|t| (t, -1)).collect::<Vec<_>>(), &positions)
    }

    #[test]
    fn layers_are_as_deep_as_they_are_wide_however_fine_their_triangles_are() {
        for (across, step) in [(1e-9, 1.0), (1.0, 1.0), (1.0, 1e-6), (1e-3, 1e-3)] {
            let depth = strip(across, step);
            assert!(depth > 0.99 * across && depth < 1.01 * across, "{across} {step}: {depth}");
        }
        assert_eq!(depth_of_layers(&[], &[]), 0.0);
        // A square of many cells.
        let positions: Vec<_> = (0..51 * 51).map(|k| DVec3::new(f64::from(k % 51), f64::from(k / 51), 0.0)).collect();
        let corners = (0..50 * 50).map(|k| k / 50 * 51 + k % 50);
        let cells = corners.flat_map(|v| [[v, v + 1, v + 52], [v, v + 52, v + 51]]);
        let depth = depth_of_layers(&cells.map(|t| (t, 1)).collect::<Vec<_>>(), &positions);
        assert!((25.0..=50.0).contains(&depth), "{depth}");
    }
}
