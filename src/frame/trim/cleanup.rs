//! Rings that failed, and loops inside one cell -> triangles, by joining them with their surroundings.
//!
//! The boundaries of all rings in these cells, and in the cells beside those of rings that failed, are summed (opposite
//! edges cancel) and constrain a Delaunay triangulation, which is accepted if its region's boundary is exactly that sum.
//! If it is refused, the rings in the cells beside all of these join.

use super::cdt::{self, AtCrossings, Segment};
use super::chain::EdgeSum;
use super::input::TrimInput;
use super::output::{TrimOutcome, TrimOutput};
use super::rings::Rings;
use super::trace::Trace;
use super::triangulate::Polygon;
use crate::math::predicates::orient2d;
use std::collections::BTreeSet;

/// Refusals after which the whole tile is triangulated instead.
const GIVE_UP_AFTER: u32 = 3;

/// Marks triangles that were replaced.
const DEAD: [u32; 3] = [u32::MAX; 3];

/// Solves all unsolved rings and in-cell loops. `None` if no union of cells could be triangulated. Allocates: it runs
/// for few tiles.
#[cold]
#[inline(never)]
pub(crate) fn clean_up(
    tile: &TrimInput<'_>,
    trace: &Trace,
    rings: &mut Rings,
    polygon: &mut Polygon,
    out: &mut TrimOutput,
) -> Option<TrimOutcome> {
    let cell_of: Vec<[u32; 2]> = rings.rings.iter().map(|ring| ring.cell(tile, trace)).collect();
    let failed: BTreeSet<[u32; 2]> =
        rings.rings.iter().zip(&cell_of).filter(|(ring, _)| !ring.solved).map(|(_, cell)| *cell).collect();
    let mut cells = with_neighbours(&failed);
    cells.extend(trace.in_cell_loops.iter().map(|l| tile.cell(l.cell)));
    let mut refusals = 0;
    let triangles = loop {
        let joined: Vec<usize> = (0..rings.rings.len()).filter(|&ring| cells.contains(&cell_of[ring])).collect();
        if refusals > GIVE_UP_AFTER || refusals > 0 && joined == rings.joined {
            return None;
        }
        rings.joined = joined;
        if let Some(triangles) = triangulate(tile, trace, rings, polygon) {
            break triangles;
        }
        refusals += 1;
        cells = with_neighbours(&cells);
    };
    for &ring in &rings.joined {
        let [from, to] = rings.rings[ring].triangles;
        out.triangles[from as usize..to as usize].fill(DEAD);
    }
    out.triangles.retain(|t| *t != DEAD);
    out.triangles.extend(triangles);
    Some(if failed.is_empty() && refusals == 0 { TrimOutcome::Certified } else { TrimOutcome::Cdt })
}

/// Cells, and those beside them, some of which may be beyond the tile.
fn with_neighbours(cells: &BTreeSet<[u32; 2]>) -> BTreeSet<[u32; 2]> {
    let beside =
        |&[i, j]: &[u32; 2]| [[i, j], [i.saturating_sub(1), j], [i + 1, j], [i, j.saturating_sub(1)], [i, j + 1]];
    cells.iter().flat_map(beside).collect()
}

/// The triangles of all joined rings and in-cell loops, or `None` if their boundary does not bound a region.
fn triangulate(tile: &TrimInput<'_>, trace: &Trace, rings: &Rings, polygon: &mut Polygon) -> Option<Vec<[u32; 3]>> {
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for l in &trace.in_cell_loops {
        let [start, end] = tile.ends(l.loop_index);
        edges.extend((start..end).map(|v| [v, tile.next(l.loop_index, v)]));
    }
    for &ring in &rings.joined {
        rings.reload(tile, trace, ring, polygon);
        let ids = &polygon.ids;
        edges.extend(ids.iter().enumerate().map(|(k, &v)| [v, ids[(k + 1) % ids.len()]]));
    }
    let mut sites: Vec<u32> = edges.iter().map(|e| e[0]).collect();
    cancel_opposites(&mut edges)?;
    // Tessellants stay only as ends of segments. Kept corners inside stay as free vertices, to keep triangles small.
    sites.retain(|&v| v as usize >= tile.points.len());
    sites.extend(edges.as_flattened());
    sites.sort_unstable();
    sites.dedup();
    let points: Vec<_> = sites.iter().map(|&v| tile.point(v)).collect();
    let local = |v: u32| sites.binary_search(&v).map(|k| k as u32).ok();
    let mut segments = Vec::with_capacity(edges.len());
    for &[a, b] in &edges {
        segments.push(Segment { ends: [local(a)?, local(b)?], weight: 1 });
    }
    let region = cdt::triangulate(&points, &segments, AtCrossings::Refuse).ok()?;
    let positive = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| points[v as usize]);
        orient2d(a, b, c) > 0.0
    };
    let is_region = region.layers.is_empty() && region.triangles.iter().all(positive);
    let triangles: Vec<_> = region.triangles.iter().map(|t| t.map(|v| sites[v as usize])).collect();
    // Where loops touch, triangles may use another vertex at the same place.
    let mut rest = EdgeSum::default();
    edges.iter().for_each(|&edge| rest.add(edge, 1));
    triangles.iter().for_each(|&triangle| rest.add_triangle(triangle, -1));
    (is_region && rest.is_zero()).then_some(triangles)
}

/// Removes pairs of opposite edges. `None` if more than one edge remains in one direction.
fn cancel_opposites(edges: &mut Vec<[u32; 2]>) -> Option<()> {
    let line = |e: &[u32; 2]| [e[0].min(e[1]), e[0].max(e[1])];
    edges.sort_unstable_by_key(|e| (line(e), e[0]));
    let mut left = Vec::with_capacity(edges.len());
    for group in edges.chunk_by(|a, b| line(a) == line(b)) {
        let forward = group.iter().filter(|e| e[0] < e[1]).count();
        let backward = group.len() - forward;
        match forward.abs_diff(backward) {
            0 => {}
            1 => left.push(if forward > backward { line(&group[0]) } else { [line(&group[0])[1], line(&group[0])[0]] }),
            _ => return None,
        }
    }
    *edges = left;
    Some(())
}
