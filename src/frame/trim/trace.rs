//! Loops of tessellants -> crossings with lattice lines, in curve order and in order along each lattice edge, and the
//! kept lattice corners. One step of a two-dimensional digital differential analyser per crossing; no winding tests.
//!
//! The cell of a tessellant near a lattice line and the order of crossings that nearly coincide may both be wrong: both
//! cells see the same choice, and a wrong one yields a triangle that is not positive, never a wrong mesh.

use super::bits::Bits;
use super::input::{CORNER_CLEARANCE, NONE, TrimInput};
use crate::math::predicates::orient2d;
use glam::DVec2;

/// Positions along a lattice line, or parameters of a segment, closer than this are compared exactly. Rounding errors
/// of positions are about 1e-12 on the largest lattice; beyond 1e-6 the exact path would show in the profile.
const DOUBTFUL: f64 = 1e-9;

/// A tessellant segment leaves the cell `cell` through its side `side` (0 bottom, 1 right, 2 top, 3 left).
///
/// The part of the loop from one crossing to the next is a *chain*. It lies in one cell, and its index is that of the
/// crossing it starts from.
#[derive(Clone, Copy)]
pub(crate) struct Crossing {
    /// Coordinate along the lattice line.
    pub(crate) position: f64,
    /// First tessellant of the segment.
    pub(crate) segment: u32,
    /// The end of the segment that replaces the crossing: `segment` or `segment + 1`, which may be the loop's end
    /// index.
    pub(crate) snap: u32,
    /// The next crossing of the loop.
    pub(crate) next: u32,
    /// Neighbours along the lattice edge, in ascending and descending direction, or [`NONE`].
    pub(crate) above: u32,
    pub(crate) below: u32,
    pub(crate) loop_index: u32,
    pub(crate) cell: [u16; 2],
    pub(crate) side: u8,
    /// The chain from here passes the loop's first tessellant.
    pub(crate) wraps: bool,
}

/// The segment being traced.
struct TracedSegment<'a> {
    tile: &'a TrimInput<'a>,
    loop_index: u32,
    /// Its first tessellant.
    first: u32,
    a: DVec2,
    d: DVec2,
}

/// The crossings of a lattice edge: first, last, and the most recent, near which the next one is likely to belong.
#[derive(Clone, Copy, Default)]
struct EdgeList {
    first: u32,
    last: u32,
    recent: u32,
}

/// Crossings of a tile's loops with its lattice, and what follows from them.
#[derive(Default)]
pub(crate) struct Trace {
    nu: usize,
    nv: usize,
    pub(crate) crossings: Vec<Crossing>,
    /// By lattice edge. Valid only where the bit in `crossed` is set, so it is never cleared.
    lists: Vec<EdgeList>,
    /// Lattice edges with crossings: the horizontal ones (i, j)-(i + 1, j), then in further rows the vertical ones
    /// (i, j)-(i, j + 1).
    crossed: Bits,
    /// Horizontal lattice edges with an odd number of crossings.
    odd_h: Bits,
    /// Lattice corners inside the region.
    pub(crate) kept: Bits,
    /// Cells that are not full cells even if nothing crosses their edges: with a loop inside or a replaced corner.
    pub(crate) special: Bits,
    /// Kept corners replaced by a tessellant, and by which.
    snapped: Bits,
    replacement: Vec<u32>,
    /// Whether there are any.
    has_snapped: bool,
    /// Corners close to a tessellant or a crossing. Distances of tessellants are scaled down, so that they win.
    candidates: Vec<CornerCandidate>,
    /// Loops that stay inside one cell, with that cell.
    pub(crate) in_cell_loops: Vec<InCellLoop>,
}

struct CornerCandidate {
    corner: u32,
    distance: f64,
    tessellant: u32,
}

/// A loop without crossings.
pub(crate) struct InCellLoop {
    pub(crate) cell: u32,
    pub(crate) loop_index: u32,
}

impl Trace {
    /// Traces all loops, after [`reset`](Self::reset).
    #[inline(always)]
    pub(crate) fn run(&mut self, tile: &TrimInput<'_>) {
        for (index, ends) in tile.loop_starts.windows(2).enumerate() {
            if ends[0] < ends[1] {
                let ends = (ends[0] as usize, ends[1] as usize);
                self.trace_loop(tile, index as u32, ends);
            }
        }
        self.keep_corners();
        if !self.candidates.is_empty() {
            self.snap_corners();
        }
    }

    /// Traces the loops of a tile of one cell, which they cannot leave.
    pub(crate) fn run_in_one_cell(&mut self, tile: &TrimInput<'_>) {
        (self.nu, self.nv) = (1, 1);
        self.kept.reset(2, 2);
        self.crossings.clear();
        self.in_cell_loops.clear();
        let loops = (0..).zip(tile.loop_starts.windows(2)).filter(|(_, ends)| ends[0] < ends[1]);
        self.in_cell_loops.extend(loops.map(|(loop_index, _)| InCellLoop { cell: 0, loop_index }));
    }

    /// Clears the trace for a tile.
    pub(crate) fn reset(&mut self, tile: &TrimInput<'_>) {
        let (nu, nv) = (tile.cells.0 as usize, tile.cells.1 as usize);
        (self.nu, self.nv) = (nu, nv);
        self.crossed.reset(nu + 1, 2 * (nv + 1));
        for bits in [&mut self.odd_h, &mut self.kept, &mut self.special, &mut self.snapped] {
            bits.reset(nu + 1, nv + 1);
        }
        self.has_snapped = false;
        let corners = (nu + 1) * (nv + 1);
        if self.lists.len() < 2 * corners {
            self.lists.resize(2 * corners, EdgeList::default());
        }
        if self.replacement.len() < corners {
            self.replacement.resize(corners, 0);
        }
        self.crossings.clear();
        self.candidates.clear();
        self.in_cell_loops.clear();
    }

    #[inline(always)]
    fn trace_loop(&mut self, tile: &TrimInput<'_>, index: u32, (start, end): (usize, usize)) {
        let points = &tile.points[start..end];
        let count = points.len();
        let first_crossing = self.crossings.len();
        let mut a = points[0];
        let home = if self.near_line(a) {
            self.kept_side_cell(points[count - 1], a, points[1 % count])
        } else {
            self.cell_of(a)
        };
        let mut from = home;
        for k in 0..count {
            let last = k + 1 == count;
            let d = if last { points[0] } else { points[k + 1] };
            let mut to = self.cell_of(d);
            if self.near_line(d) {
                let next = if k + 2 >= count { points[(k + 2) % count] } else { points[k + 2] };
                to = if last { home } else { self.kept_side_cell(a, d, next) };
                self.note_near_corner(d, (start + if last { 0 } else { k + 1 }) as u32);
            }
            if from != to {
                let segment = TracedSegment { tile, loop_index: index, first: (start + k) as u32, a, d };
                self.step_through(&segment, from, to);
            }
            a = d;
            from = to;
        }
        let crossings = self.crossings.len();
        if crossings == first_crossing {
            self.in_cell_loops
                .push(InCellLoop { cell: (from.1 as usize * self.nu + from.0 as usize) as u32, loop_index: index });
            self.special.set(from.0 as usize, from.1 as usize);
        } else {
            let last = &mut self.crossings[crossings - 1];
            last.next = first_crossing as u32;
            last.wraps = true;
        }
    }

    /// Adds the crossings of a segment from cell `from` to cell `to`. The cells alone determine how many steps there
    /// are in x and in y, not the coordinates.
    #[inline(always)]
    fn step_through(&mut self, segment: &TracedSegment<'_>, from: (i32, i32), to: (i32, i32)) {
        let (a, d) = (segment.a, segment.d);
        let (di, dj) = (to.0 - from.0, to.1 - from.1);
        let direction = d - a;
        // Infinite in a direction that has no steps, or when the cells differ only by ownership.
        let inverse = direction.recip();
        let (mut i, mut j) = from;
        let (mut steps_x, mut steps_y) = (di.abs(), dj.abs());
        let nearer_end = |t: f64| segment.first + u32::from(t >= 0.5);
        let mut snap = segment.first;
        while steps_x + steps_y > 0 {
            let line = DVec2::new(f64::from(i + i32::from(di > 0)), f64::from(j + i32::from(dj > 0)));
            let t = (line - a) * inverse;
            let x_first = if steps_y == 0 {
                true
            } else if steps_x == 0 {
                false
            } else if (t.x - t.y).abs() > DOUBTFUL {
                t.x < t.y
            } else {
                let turn = orient2d(a, d, line);
                let turn = if turn == 0.0 { direction.y } else { turn };
                (turn > 0.0) == ((di > 0) == (dj > 0))
            };
            if x_first {
                let t = unit(t.x);
                let side = if di > 0 { 1 } else { 3 };
                snap = self.push(segment, [i, j], side, a.y + t * direction.y, snap.max(nearer_end(t)));
                i += di.signum();
                steps_x -= 1;
            } else {
                let t = unit(t.y);
                let side = if dj > 0 { 2 } else { 0 };
                snap = self.push(segment, [i, j], side, a.x + t * direction.x, snap.max(nearer_end(t)));
                j += dj.signum();
                steps_y -= 1;
            }
        }
    }

    /// Appends a crossing, inserts it in order along its lattice edge, and returns its snap, which never falls along a
    /// segment.
    #[inline(always)]
    fn push(&mut self, segment: &TracedSegment<'_>, cell: [i32; 2], side: u8, position: f64, snap: u32) -> u32 {
        let (i, j) = (cell[0] as usize, cell[1] as usize);
        let edge = self.edge(i, j, side);
        if edge.horizontal {
            self.odd_h.flip(edge.column, edge.row);
        }
        let seen = self.crossed.set(edge.column, edge.row_in_crossed);
        let index = self.crossings.len() as u32;
        self.crossings.push(Crossing {
            position,
            segment: segment.first,
            snap,
            next: index + 1,
            above: NONE,
            below: NONE,
            loop_index: segment.loop_index,
            cell: [i as u16, j as u16],
            side,
            wraps: false,
        });
        if seen {
            self.insert(segment.tile, index, edge.index);
        } else {
            self.lists[edge.index] = EdgeList { first: index, last: index, recent: index };
        }
        // A segment along the tile's border crosses inner lines at corners of the border. These are never kept, so they
        // need not take the slow path.
        let (line, at) = nearest_line(position);
        let distance = (position - at).abs();
        let limit = if edge.horizontal { self.nu } else { self.nv };
        if distance < CORNER_CLEARANCE && line > 0 && line < limit as i32 {
            let line = line as usize;
            let (ci, cj) = if edge.horizontal { (line, edge.row) } else { (edge.column, line) };
            self.note_near_crossing(segment, (ci, cj), distance, snap);
        }
        snap
    }

    /// Puts the last crossing in order along its lattice edge.
    #[inline(always)]
    fn insert(&mut self, tile: &TrimInput<'_>, index: u32, edge: usize) {
        let EdgeList { first, last, recent } = self.lists[edge];
        let (mut below, mut above) = (recent, self.crossings[recent as usize].above);
        if self.less(tile, index, recent) {
            while below != NONE && self.less(tile, index, below) {
                above = below;
                below = self.crossings[below as usize].below;
            }
        } else {
            while above != NONE && !self.less(tile, index, above) {
                below = above;
                above = self.crossings[above as usize].above;
            }
        }
        if below != NONE {
            self.crossings[below as usize].above = index;
        }
        if above != NONE {
            self.crossings[above as usize].below = index;
        }
        let crossing = &mut self.crossings[index as usize];
        (crossing.below, crossing.above) = (below, above);
        self.lists[edge] = EdgeList {
            first: if below == NONE { index } else { first },
            last: if above == NONE { index } else { last },
            recent: index,
        };
    }

    #[inline(always)]
    fn less(&self, tile: &TrimInput<'_>, index: u32, other: u32) -> bool {
        let difference = self.crossings[index as usize].position - self.crossings[other as usize].position;
        if difference.abs() > DOUBTFUL { difference < 0.0 } else { self.less_exact(tile, index, other) }
    }

    /// Orders two crossings that rounding cannot separate, by the segment that lies entirely on one side of the other
    /// segment's line. Simple loops always have one.
    #[cold]
    #[inline(never)]
    fn less_exact(&self, tile: &TrimInput<'_>, index: u32, other: u32) -> bool {
        let [crossing, other] = [index, other].map(|k| &self.crossings[k as usize]);
        let ends = |c: &Crossing| [c.segment, tile.next(c.loop_index, c.segment)].map(|v| tile.points[v as usize]);
        // The left of a segment is "greater" along the edge if it crosses a horizontal edge downwards or a vertical one
        // to the right.
        let leftward_is_greater = |c: &Crossing| c.side < 2;
        let ([a, d], [b, e]) = (ends(crossing), ends(other));
        let (at_a, at_d) = (orient2d(b, e, a), orient2d(b, e, d));
        if at_a >= 0.0 && at_d >= 0.0 && (at_a > 0.0 || at_d > 0.0) {
            return !leftward_is_greater(other);
        }
        if at_a <= 0.0 && at_d <= 0.0 && (at_a < 0.0 || at_d < 0.0) {
            return leftward_is_greater(other);
        }
        let other_is_left = orient2d(a, d, b) >= 0.0 && orient2d(a, d, e) >= 0.0;
        other_is_left == leftward_is_greater(crossing)
    }

    #[cold]
    #[inline(never)]
    fn note_near_crossing(&mut self, segment: &TracedSegment<'_>, (i, j): (usize, usize), distance: f64, snap: u32) {
        let [start, end] = segment.tile.ends(segment.loop_index);
        let tessellant = if snap == end { start } else { snap };
        // Puts a tessellant on the corner, at distance 0, before a crossing there.
        let distance = distance + f64::MIN_POSITIVE;
        self.candidates.push(CornerCandidate { corner: (j * (self.nu + 1) + i) as u32, distance, tessellant });
    }

    /// Notes a tessellant near a lattice line if it is near an inner corner as well.
    #[cold]
    #[inline(never)]
    fn note_near_corner(&mut self, p: DVec2, tessellant: u32) {
        let corner = (p + 0.5).floor();
        let distance = (p - corner).abs().max_element();
        let inner = |c: f64, limit: usize| c > 0.0 && c < limit as f64;
        if distance < CORNER_CLEARANCE && inner(corner.x, self.nu) && inner(corner.y, self.nv) {
            let corner = (corner.y as usize * (self.nu + 1) + corner.x as usize) as u32;
            // Scaled so that a tessellant wins over a crossing.
            self.candidates.push(CornerCandidate { corner, distance: distance * CORNER_CLEARANCE, tessellant });
        }
    }

    /// The cell of a point. Cells are half-open, but the last of a row or column is closed.
    #[inline(always)]
    fn cell_of(&self, p: DVec2) -> (i32, i32) {
        let cell = |coordinate: f64, count: usize| {
            let (line, at) = nearest_line(coordinate);
            (line - i32::from(at > coordinate)).min(count as i32 - 1)
        };
        (cell(p.x, self.nu), cell(p.y, self.nv))
    }

    /// Whether the point lies within the clearance of an inner lattice line.
    #[inline(always)]
    fn near_line(&self, p: DVec2) -> bool {
        let near = |coordinate: f64, limit: usize| {
            let (line, at) = nearest_line(coordinate);
            (coordinate - at).abs() < CORNER_CLEARANCE && line > 0 && line < limit as i32
        };
        near(p.x, self.nu) || near(p.y, self.nv)
    }

    /// The cell of tessellant `a`, between `prev` and `next`: on the kept side of the inner lattice lines that it lies
    /// on, up to the clearance. Tips that touch a line, and segments along it, then belong to the cells they bound, and
    /// do not disturb the full cells beyond.
    #[cold]
    #[inline(never)]
    fn kept_side_cell(&self, prev: DVec2, a: DVec2, next: DVec2) -> (i32, i32) {
        let half_open = self.cell_of(a);
        let mut cell = [half_open.0, half_open.1];
        let limits = [self.nu as f64, self.nv as f64];
        for axis in 0..2 {
            let line = (a[axis] + 0.5).floor();
            if (a[axis] - line).abs() > CORNER_CLEARANCE || line <= 0.0 || line >= limits[axis] {
                continue;
            }
            let beyond = |q: DVec2| {
                let distance = q[axis] - line;
                if distance.abs() <= CORNER_CLEARANCE { 0.0 } else { distance.signum() }
            };
            let (before, after) = (beyond(prev), beyond(next));
            // Moving up along a vertical line keeps its left, moving right along a horizontal one keeps what is above.
            let keeps_greater = if axis == 0 { -1.0 } else { 1.0 };
            let kept = if after == 0.0 {
                keeps_greater * (next[1 - axis] - a[1 - axis])
            } else if before == 0.0 {
                keeps_greater * (a[1 - axis] - prev[1 - axis])
            } else if before == after {
                // A right turn is the tip of a part trimmed away: the kept side is the far one.
                if orient2d(prev, a, next) < 0.0 { -before } else { before }
            } else {
                continue;
            };
            cell[axis] = line as i32 - i32::from(kept < 0.0);
        }
        (cell[0], cell[1])
    }

    /// Keeps corners with an odd number of crossings before them on their row; rows on the tile border keep nothing.
    fn keep_corners(&mut self) {
        for row in 1..self.nv {
            self.kept.set_to_parity_before(row, &self.odd_h);
        }
    }

    /// Replaces kept corners close to the boundary by the nearest candidate, in all four cells alike.
    #[cold]
    #[inline(never)]
    fn snap_corners(&mut self) {
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.sort_unstable_by(|a, b| {
            a.corner.cmp(&b.corner).then(a.distance.total_cmp(&b.distance)).then(a.tessellant.cmp(&b.tessellant))
        });
        let mut last = NONE;
        for candidate in &candidates {
            if candidate.corner == last {
                continue;
            }
            last = candidate.corner;
            let (i, j) = (last as usize % (self.nu + 1), last as usize / (self.nu + 1));
            if self.kept.get(i, j) {
                self.replacement[last as usize] = candidate.tessellant;
                self.snapped.set(i, j);
                self.has_snapped = true;
                for (x, y) in [(i - 1, j - 1), (i, j - 1), (i - 1, j), (i, j)] {
                    self.special.set(x, y);
                }
            }
        }
        candidates.clear();
        self.candidates = candidates;
    }

    /// The vertex of a kept corner: the corner itself, or the tessellant that replaces it.
    #[inline(always)]
    pub(crate) fn corner(&self, tile: &TrimInput<'_>, i: usize, j: usize) -> (u32, DVec2) {
        if self.has_snapped && self.snapped.get(i, j) {
            let vertex = self.replacement[j * (self.nu + 1) + i];
            (vertex, tile.points[vertex as usize])
        } else {
            let (i, j) = (i as u32, j as u32);
            (tile.corner_id(i, j), DVec2::new(f64::from(i), f64::from(j)))
        }
    }

    #[inline(always)]
    fn edge(&self, i: usize, j: usize, side: u8) -> LatticeEdge {
        let (column, row) = (i + usize::from(side == 1), j + usize::from(side == 2));
        let horizontal = side & 1 == 0;
        let row_in_crossed = row + if horizontal { 0 } else { self.nv + 1 };
        LatticeEdge { index: row_in_crossed * (self.nu + 1) + column, horizontal, column, row, row_in_crossed }
    }

    /// The first crossing of the cell's side when going around the cell counter-clockwise.
    #[inline(always)]
    pub(crate) fn first_on_side(&self, i: usize, j: usize, side: u8) -> Option<u32> {
        let edge = self.edge(i, j, side);
        self.crossed.get(edge.column, edge.row_in_crossed).then(|| {
            let list = &self.lists[edge.index];
            if side < 2 { list.first } else { list.last }
        })
    }

    /// Position of a crossing, and the cell that its loop enters there.
    pub(crate) fn place(&self, crossing: &Crossing) -> (DVec2, [u32; 2]) {
        let [i, j] = crossing.cell.map(usize::from);
        let edge = self.edge(i, j, crossing.side);
        let (column, row) = (edge.column as f64, edge.row as f64);
        let at =
            if edge.horizontal { DVec2::new(crossing.position, row) } else { DVec2::new(column, crossing.position) };
        let beyond = match crossing.side {
            0 => (i, j.saturating_sub(1)),
            1 => (i + 1, j),
            2 => (i, j + 1),
            _ => (i.saturating_sub(1), j),
        };
        (at, [beyond.0 as u32, beyond.1 as u32])
    }

    /// The cells of a row with a crossing on a side: bit `k` is that of column `64 * word + k`.
    pub(crate) fn crossed_cells(&self, word: usize, row: usize) -> u64 {
        let (crossed, upright) = (&self.crossed, self.nv + 1 + row);
        let (below, above) = (crossed.word(word, row), crossed.word(word, row + 1));
        below | above | crossed.word(word, upright) | crossed.word_after(word, upright)
    }

    /// Number of columns and rows of cells.
    pub(crate) fn cells(&self) -> (usize, usize) {
        (self.nu, self.nv)
    }
}

/// Clamps to 0..=1; NaN becomes 0.
#[inline(always)]
fn unit(t: f64) -> f64 {
    if t > 0.0 { t.min(1.0) } else { 0.0 }
}

/// The lattice line nearest to a coordinate of at least -0.5, as an integer and as a coordinate.
///
/// Rounding functions are calls on processors without SSE 4.1, and conversions to integers take checks. A number next
/// to 2^52 is rounded to an integer, which is in its lowest bits.
#[inline(always)]
fn nearest_line(coordinate: f64) -> (i32, f64) {
    const SHIFT: f64 = (1_u64 << 52) as f64;
    let shifted = coordinate + SHIFT;
    (shifted.to_bits() as i32, shifted - SHIFT)
}

/// Indices of a lattice edge.
struct LatticeEdge {
    index: usize,
    horizontal: bool,
    column: usize,
    row: usize,
    /// The row in [`Trace::crossed`].
    row_in_crossed: usize,
}
