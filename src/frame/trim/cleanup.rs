//! Rings that failed, and loops inside one cell -> triangles.
//!
//! A cell with loops is swept with them: they and its rings bound one region. A cell fails if the sweep refuses it, or
//! one of its rings has failed.
//!
//! Failed cells and their neighbours are joined. The boundaries of their rings and loops are summed: opposite edges
//! cancel. The sum constrains a Delaunay triangulation, which is accepted if exactly this sum bounds its region. If it
//! is refused, the neighbours of all joined cells join, and it is tried again. Cells without rings and loops never
//! join.

use super::cdt::{self, AtCrossings, Segment};
use super::chain::EdgeSum;
use super::close::Places;
use super::input::TrimInput;
use super::output::{TrimOutcome, TrimOutput};
use super::rings::Rings;
use super::trace::Trace;
use super::triangulate::Polygon;
use crate::math::predicates::orient2d;
use std::collections::{BTreeMap, BTreeSet};

/// Refusals after which the whole tile is triangulated instead.
const GIVE_UP_AFTER: u32 = 3;

/// Marks triangles that were replaced.
const DEAD: [u32; 3] = [u32::MAX; 3];

/// What is in one cell.
#[derive(Default)]
struct Cell {
    rings: Vec<usize>,
    loops: Vec<u32>,
    /// Its triangles: ranges of those of the tile.
    triangles: Vec<[u32; 2]>,
}

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
    let mut cells: BTreeMap<[u32; 2], Cell> = BTreeMap::new();
    for (k, ring) in rings.rings.iter().enumerate() {
        let cell = cells.entry(ring.cell(tile, trace)).or_default();
        cell.rings.push(k);
        cell.triangles.push(ring.triangles);
    }
    for l in &trace.in_cell_loops {
        cells.entry(tile.cell(l.cell)).or_default().loops.push(l.loop_index);
    }
    let mut failed = BTreeSet::new();
    for (&at, cell) in &mut cells {
        let solved = if cell.loops.is_empty() {
            cell.rings.iter().all(|&ring| rings.rings[ring].solved)
        } else {
            cell.discard(out);
            let before = out.triangles.len() as u32;
            let solved = cell.sweep(tile, trace, rings, polygon, &mut out.triangles);
            cell.triangles.push([before, out.triangles.len() as u32]);
            solved
        };
        if !solved {
            failed.insert(at);
        }
    }
    if !failed.is_empty() {
        let grown = |of: &BTreeSet<[u32; 2]>| -> BTreeSet<[u32; 2]> {
            // Some neighbours may be outside the tile.
            let around = |&[i, j]: &[u32; 2]| {
                [[i, j], [i.saturating_sub(1), j], [i + 1, j], [i, j.saturating_sub(1)], [i, j + 1]]
            };
            of.iter().flat_map(around).filter(|at| cells.contains_key(at)).collect()
        };
        let mut joined = grown(&failed);
        let mut refusals = 0;
        let triangles = loop {
            let members = joined.iter().map(|at| &cells[at]);
            if let Some(triangles) = triangulate(tile, trace, rings, polygon, members) {
                break triangles;
            }
            refusals += 1;
            let more = grown(&joined);
            if refusals > GIVE_UP_AFTER || more == joined {
                return None;
            }
            joined = more;
        };
        cells.iter_mut().filter(|(at, _)| joined.contains(*at)).for_each(|(_, cell)| cell.discard(out));
        out.triangles.extend(triangles);
        rings.joined = joined;
    }
    out.triangles.retain(|t| *t != DEAD);
    Some(if failed.is_empty() { TrimOutcome::Certified } else { TrimOutcome::Cdt })
}

impl Cell {
    /// Removes its triangles.
    fn discard(&mut self, out: &mut TrimOutput) {
        for [from, to] in self.triangles.drain(..) {
            out.triangles[from as usize..to as usize].fill(DEAD);
        }
    }

    /// Triangulates the region that all of its rings and loops bound. Returns false, and appends nothing, if they are
    /// not simple.
    fn sweep(
        &self,
        tile: &TrimInput<'_>,
        trace: &Trace,
        rings: &Rings,
        polygon: &mut Polygon,
        out: &mut Vec<[u32; 3]>,
    ) -> bool {
        let load = |&ring: &usize| {
            rings.reload(tile, trace, ring, polygon);
            polygon.corners.clone()
        };
        let around: Vec<_> = self.rings.iter().map(load).collect();
        polygon.clear();
        for corners in around {
            polygon.begin_loop();
            polygon.corners.extend(corners);
        }
        self.loops.iter().for_each(|&l| polygon.add_loop(tile, l));
        polygon.triangulate(out)
    }
}

/// The triangles of all that is in some cells, or `None` if the sum of its boundaries does not bound a region.
fn triangulate<'a>(
    tile: &TrimInput<'_>,
    trace: &Trace,
    rings: &Rings,
    polygon: &mut Polygon,
    cells: impl Iterator<Item = &'a Cell>,
) -> Option<Vec<[u32; 3]>> {
    let (mut sites, mut sum) = (Vec::new(), EdgeSum::default());
    let mut add = |edge: [u32; 2]| {
        sites.push(edge[0]);
        sum.add(edge, 1);
    };
    for cell in cells {
        for &l in &cell.loops {
            let [start, end] = tile.ends(l);
            (start..end).for_each(|v| add([v, tile.next(l, v)]));
        }
        for &ring in &cell.rings {
            rings.reload(tile, trace, ring, polygon);
            let corners = &polygon.corners;
            corners.iter().enumerate().for_each(|(k, v)| add([v.id, corners[(k + 1) % corners.len()].id]));
        }
    }
    let mut edges = sum.edges();
    edges.sort_unstable_by_key(|&[a, b]| [a.min(b), a.max(b)]);
    if edges.windows(2).any(|pair| pair[0] == pair[1]) {
        return None;
    }
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
    let (one, mut rest) = (Places::of(tile), EdgeSum::default());
    edges.iter().for_each(|edge| rest.add(edge.map(|v| one.at(v)), 1));
    triangles.iter().for_each(|triangle| rest.add_triangle(triangle.map(|v| one.at(v)), -1));
    (is_region && rest.is_zero()).then_some(triangles)
}
