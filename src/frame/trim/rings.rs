//! Crossings and kept corners -> cell polygons ("rings"), their triangles, and the full cells.
//!
//! A ring walks counter-clockwise around its cell: along a chain of tessellants to where it leaves the cell, from there
//! to the next crossing on the kept side or around kept corners, and along the next chain, until it is back. It passes
//! every crossing once from either cell, so the rings' boundaries cancel along lattice lines.

use super::input::{NONE, TrimInput};
use super::output::TrimOutput;
use super::trace::Trace;
use super::triangulate::Polygon;
use crate::math::bits::ones;
use std::collections::BTreeSet;

/// Origin of a ring.
#[derive(Clone, Copy, Debug)]
pub(crate) enum RingOrigin {
    /// The ring that contains this chain.
    Chain(u32),
    /// The corners of this cell: all are kept, and no side is crossed.
    Cell(u32),
}

/// A part of the region in one cell, and its triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ring {
    pub(crate) origin: RingOrigin,
    /// Range in the output's triangles; empty if triangulation failed.
    pub(crate) triangles: [u32; 2],
    pub(crate) solved: bool,
}

impl Ring {
    /// The cell that it goes around.
    pub(crate) fn cell(&self, tile: &TrimInput<'_>, trace: &Trace) -> [u32; 2] {
        match self.origin {
            RingOrigin::Chain(k) => trace.crossings[trace.crossings[k as usize].next as usize].cell.map(u32::from),
            RingOrigin::Cell(cell) => tile.cell(cell),
        }
    }
}

/// All rings of a tile.
#[derive(Default)]
pub(crate) struct Rings {
    pub(crate) rings: Vec<Ring>,
    /// Chains that rings contain.
    walked: Vec<bool>,
    /// Cells that were triangulated together.
    pub(crate) joined: BTreeSet<[u32; 2]>,
    /// Number of kept corners that rings and full cells go around, once for each ring or cell.
    corners: u64,
    pub(crate) failed: u32,
}

impl Rings {
    /// Finds and triangulates all rings, and lists the full cells. Rings that fail have no triangles. `None` for
    /// contradictory loops: crossings do not alternate, or a region reaches beyond the tile.
    pub(crate) fn build(
        &mut self,
        tile: &TrimInput<'_>,
        trace: &Trace,
        polygon: &mut Polygon,
        out: &mut TrimOutput,
    ) -> Option<()> {
        self.clear();
        self.walked.clear();
        self.walked.resize(trace.crossings.len(), false);
        self.corners = 0;
        for k in 0..trace.crossings.len() as u32 {
            if !self.walked[k as usize] {
                let corners = walk(tile, trace, k, polygon, |chain| self.walked[chain as usize] = true)?;
                self.corners += corners as u64;
                self.add(RingOrigin::Chain(k), polygon, out);
            }
        }
        self.list_full_cells(tile, trace, polygon, out);
        Some(())
    }

    pub(crate) fn clear(&mut self) {
        self.rings.clear();
        self.joined.clear();
        self.failed = 0;
    }

    #[inline(always)]
    fn add(&mut self, origin: RingOrigin, polygon: &mut Polygon, out: &mut TrimOutput) {
        let before = out.triangles.len() as u32;
        let solved = polygon.triangulate(&mut out.triangles);
        self.failed += u32::from(!solved);
        self.rings.push(Ring { origin, triangles: [before, out.triangles.len() as u32], solved });
    }

    /// Lists cells with four kept corners and no crossing, 64 at a time.
    fn list_full_cells(&mut self, tile: &TrimInput<'_>, trace: &Trace, polygon: &mut Polygon, out: &mut TrimOutput) {
        let (_, nv) = trace.cells();
        for row in 0..nv {
            for word in 0..trace.kept.words_per_row() {
                let kept = |row| trace.kept.word(word, row) & trace.kept.word_after(word, row);
                let full = kept(row) & kept(row + 1) & !trace.crossed_cells(word, row);
                let special = full & trace.special.word(word, row);
                self.corners += 4 * u64::from(full.count_ones());
                for bit in ones(full & !special) {
                    out.full_cells.push([(64 * word + bit) as u32, row as u32]);
                }
                for bit in ones(special) {
                    let cell = row as u32 * tile.cells.0 + (64 * word + bit) as u32;
                    cell_polygon(tile, trace, cell, polygon);
                    self.add(RingOrigin::Cell(cell), polygon, out);
                }
            }
        }
    }

    /// Whether the boundary of all rings and full cells, which [`build`](Self::build) found, is the loops that have
    /// crossings. Loops that are not simple can pass everything else, because full cells come from parities and rings
    /// from the order of crossings.
    ///
    /// A ring and its triangles have the same boundary, and so have cells that [`cleanup`](super::cleanup) accepts. The
    /// chains of all rings sum to the loops; what remains are sides along lattice edges, cut into pieces by crossings
    /// and corners. A piece next to a crossing belongs to the rings that leave and enter there, one in either cell,
    /// since crossings alternate. A whole edge belongs to a ring or full cell that goes around its ends. So all sides
    /// cancel if rings and full cells go around every kept corner in all of its four cells, and around no other corner.
    /// Rings go around kept corners only: counting is enough.
    pub(crate) fn is_closed(&self, trace: &Trace) -> bool {
        self.corners == 4 * trace.kept.count()
    }

    /// Loads the polygon of a ring again.
    pub(crate) fn reload(&self, tile: &TrimInput<'_>, trace: &Trace, ring: usize, polygon: &mut Polygon) {
        match self.rings[ring].origin {
            RingOrigin::Chain(k) => {
                let again = walk(tile, trace, k, polygon, |_| ());
                debug_assert!(again.is_some(), "a ring that was walked once can be walked again");
            }
            RingOrigin::Cell(cell) => cell_polygon(tile, trace, cell, polygon),
        }
    }
}

/// Loads the corners of a cell as a polygon, with snapped ones replaced.
fn cell_polygon(tile: &TrimInput<'_>, trace: &Trace, cell: u32, polygon: &mut Polygon) {
    let [i, j] = tile.cell(cell).map(|k| k as usize);
    polygon.clear();
    for (a, b) in [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)] {
        let (id, point) = trace.corner(tile, a, b);
        polygon.push(id, point);
    }
    polygon.close();
}

/// Loads the polygon of the ring that contains chain `first`, and calls `visit` for its chains. Returns how many
/// corners it goes around, `None` for contradictory loops.
#[inline(always)]
fn walk(
    tile: &TrimInput<'_>,
    trace: &Trace,
    first: u32,
    polygon: &mut Polygon,
    mut visit: impl FnMut(u32),
) -> Option<usize> {
    polygon.clear();
    let mut k = first;
    let (mut chains, mut corners, mut first_chain) = (0usize, 0usize, 0);
    loop {
        visit(k);
        let crossing = push_chain(tile, trace, k, polygon);
        if chains == 0 {
            first_chain = polygon.corners.len();
        }
        chains += 1;
        k = next_chain(trace, crossing, |i, j| {
            let (id, point) = trace.corner(tile, i, j);
            polygon.push(id, point);
            corners += 1;
        })?;
        if k == first {
            break;
        }
        if chains > trace.crossings.len() {
            return None;
        }
    }
    let open = polygon.corners.len();
    polygon.close();
    let n = polygon.corners.len();
    let facing = (chains == 1 && n == first_chain + corners) || (chains == 2 && corners == 0);
    polygon.zip = if n == open && first_chain < n && facing { first_chain } else { 0 };
    Some(corners)
}

/// Pushes the tessellants of chain `k` and returns the crossing where it ends.
#[inline(always)]
fn push_chain(tile: &TrimInput<'_>, trace: &Trace, k: u32, polygon: &mut Polygon) -> u32 {
    let from = &trace.crossings[k as usize];
    let to = &trace.crossings[from.next as usize];
    let [start, end] = tile.ends(from.loop_index);
    let wrap = |v: u32| if v == end { start } else { v };
    let mut push = |v: u32| {
        let v = wrap(v);
        polygon.push(v, tile.points[v as usize]);
    };
    if from.wraps {
        // Both snaps may be the loop's end index, and the chain passes it.
        for step in 0..=(to.snap + (end - start) - from.snap) {
            let v = from.snap + step;
            push(if v > end { v - (end - start) } else { v });
        }
    } else {
        push(from.snap);
        if from.snap < to.snap {
            push(from.snap + 1);
            // From the third vertex on, a run cannot repeat a vertex.
            for v in from.snap + 2..=to.snap {
                let v = wrap(v);
                polygon.push_distinct(v, tile.points[v as usize]);
            }
        }
    }
    from.next
}

/// By side of a cell, the corner at its counter-clockwise end.
const AFTER: [[usize; 2]; 4] = [[1, 0], [1, 1], [0, 1], [0, 0]];

/// Goes counter-clockwise from the crossing where a chain leaves its cell to the chain that enters it next. Calls
/// `corner` for the kept corners on the way. `None` for contradictory loops.
#[inline(always)]
fn next_chain(trace: &Trace, crossing: u32, mut corner: impl FnMut(usize, usize)) -> Option<u32> {
    let c = &trace.crossings[crossing as usize];
    let partner = if c.side < 2 { c.above } else { c.below };
    if partner != NONE {
        // Crossings alternate: the next one on the kept side must enter where this one leaves.
        let enters = trace.crossings[partner as usize].side == (c.side + 2) & 3;
        return enters.then_some(partner);
    }
    let (i, j) = (c.cell[0] as usize, c.cell[1] as usize);
    let mut side = c.side;
    for _ in 0..4 {
        let [di, dj] = AFTER[side as usize];
        let (ci, cj) = (i + di, j + dj);
        if !trace.kept.get(ci, cj) {
            return None;
        }
        corner(ci, cj);
        side = (side + 1) & 3;
        if let Some(first) = trace.first_on_side(i, j, side) {
            let enters = trace.crossings[first as usize].side == (side + 2) & 3;
            return enters.then_some(first);
        }
    }
    None
}
