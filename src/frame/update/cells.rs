//! Cached crossings and cells of a tile, and its new tessellants and lattice lines -> its triangles, rebuilt only where
//! something changed (Kumar and Manocha 1995, §5.2).
//!
//! A segment between tessellants that stay, in lattice strips that stay, keeps its crossings. A cell that only such
//! segments pass through keeps its triangles. The sum of all areas is checked as for a rebuilt tile.

use super::memory::keep;
use crate::frame::trim::bits::Bits;
use crate::frame::trim::climb::{Rungs, TrimScratch, certified};
use crate::frame::trim::input::{CORNER_CLEARANCE, NONE, TrimInput, next_in};
use crate::frame::trim::output::{TrimOutcome, TrimOutput, TrimStats};
use crate::frame::trim::rings::RingOrigin;
use crate::frame::trim::trace::{Crossed, Crossing, Trace};

/// Cached triangulation of a tile, cell by cell.
#[derive(Default)]
pub(crate) struct CellCache {
    cells: (u32, u32),
    /// Number of tessellants.
    tessellants: u32,
    crossings: Vec<Crossing>,
    rings: Vec<CachedRing>,
    /// With vertices as the trim stage numbers them.
    triangles: Vec<[u32; 3]>,
}

/// A cell polygon that was triangulated by itself.
#[derive(Clone, Copy)]
pub(crate) struct CachedRing {
    cell: [u16; 2],
    /// Range of its triangles.
    triangles: [u32; 2],
}

/// A tile, and how its tessellants and lattice strips correspond to the old ones.
#[derive(Clone, Copy)]
pub(crate) struct CellMapping<'a> {
    /// The new tile.
    pub(crate) tile: TrimInput<'a>,
    /// Loop starts of the old tile.
    pub(crate) old_starts: &'a [u32],
    /// Old index of each tessellant, or [`NONE`].
    pub(crate) from: &'a [u32],
    /// New index of each old column and row of cells, or [`NONE`].
    pub(crate) columns: &'a [u32],
    pub(crate) rows: &'a [u32],
}

/// The old crossings of segments with the lattice.
pub(crate) struct OldCrossings<'a> {
    /// All crossings, in curve order.
    crossings: &'a [Crossing],
    /// Index of each old segment's first crossing, then the number of crossings.
    first: &'a [u32],
    /// By tessellant: old index of the segment that starts there, or [`NONE`].
    segments: &'a [u32],
    /// New index of each old column and row.
    columns: &'a [u32],
    rows: &'a [u32],
}

impl<'a> OldCrossings<'a> {
    /// The old crossings of the segment that starts at `v` in cell `from`, if they still hold.
    #[inline(always)]
    pub(crate) fn of(&self, v: usize, from: (i32, i32)) -> Option<Crossed<'a>> {
        let segment = self.segments[v];
        if segment == NONE {
            return None;
        }
        let [start, end] = [segment, segment + 1].map(|s| self.first[s as usize] as usize);
        let crossings = &self.crossings[start..end];
        let Some(first) = crossings.first() else { return Some(Crossed { crossings, move_by: [0; 2] }) };
        let [i, j] = first.cell.map(i32::from);
        let now = (self.columns[i as usize] as i32, self.rows[j as usize] as i32);
        (now == from).then(|| Crossed { crossings, move_by: [now.0 - i, now.1 - j] })
    }
}

/// Work space of [`CellCache::again`]. Does not affect results.
#[derive(Default)]
pub(crate) struct AgainScratch {
    /// Index of each old segment's first crossing, then the number of crossings.
    first: Vec<u32>,
    /// By tessellant: old index of the segment that starts there, if its crossings stay; else [`NONE`].
    segments: Vec<u32>,
    /// By old segment: whether it is in `segments`.
    stays: Vec<bool>,
    /// New index of each old tessellant, or [`NONE`].
    to: Vec<u32>,
    /// Old index of each new column and row, or [`NONE`].
    columns: Vec<u32>,
    rows: Vec<u32>,
    /// New cells on new segments, and old cells on removed segments.
    dirty: Bits,
    old_dirty: Bits,
    /// Reused rings of the new tile.
    kept: Vec<CachedRing>,
}

/// The tessellant after `v` in its loop.
impl AgainScratch {
    /// Finds the segments that stay: both ends stay, adjacent and away from lattice lines, and all strips between them.
    fn find_segments(&mut self, cells: &CellCache, moved: &CellMapping<'_>, trace: &Trace) {
        let Self { first, segments, stays, to, columns, rows, .. } = self;
        let count = cells.tessellants as usize;
        first.clear();
        let mut at = 0;
        for segment in 0..=cells.tessellants {
            while at < cells.crossings.len() && cells.crossings[at].segment < segment {
                at += 1;
            }
            first.push(at as u32);
        }
        to.clear();
        to.resize(count, NONE);
        stays.clear();
        stays.resize(count, false);
        for (new, &old) in (0_u32..).zip(moved.from).filter(|(_, old)| **old != NONE) {
            to[old as usize] = new;
        }
        for (back, strips, count) in
            [(columns, moved.columns, moved.tile.cells.0), (rows, moved.rows, moved.tile.cells.1)]
        {
            back.clear();
            back.resize(count as usize, NONE);
            (0_u32..).zip(strips).filter(|(_, new)| **new != NONE).for_each(|(old, &new)| back[new as usize] = old);
        }
        segments.clear();
        segments.resize(moved.from.len(), NONE);
        let near: Vec<bool> = moved.tile.points.iter().map(|&p| trace.near_line(p)).collect();
        for (ends, old_ends) in moved.tile.loop_starts.windows(2).zip(moved.old_starts.windows(2)) {
            let chains = first[old_ends[0] as usize] as usize..first[old_ends[1] as usize] as usize;
            if chains.is_empty() {
                continue;
            }
            let strips_stay = |k: usize| {
                let [i, j] = cells.crossings[k].cell.map(usize::from);
                moved.columns[i] != NONE && moved.rows[j] != NONE
            };
            for v in ends[0]..ends[1] {
                let (w, old) = (next_in(ends, v), moved.from[v as usize]);
                if old == NONE || near[v as usize] || near[w as usize] {
                    continue;
                }
                if moved.from[w as usize] != next_in(old_ends, old) {
                    continue;
                }
                // The crossing after the segment's last one leaves the cell in which the segment ends.
                let range = first[old as usize] as usize..first[old as usize + 1] as usize;
                let after = if range.end == chains.end { chains.start } else { range.end };
                if range.chain([after]).all(strips_stay) {
                    segments[v as usize] = old;
                    stays[old as usize] = true;
                }
            }
        }
    }

    /// Marks the cells that new segments pass through, and those that removed segments passed through.
    fn mark_cells(&mut self, cells: &CellCache, moved: &CellMapping<'_>, trace: &Trace) {
        let Self { segments, stays, dirty, old_dirty, .. } = self;
        dirty.reset(moved.tile.cells.0 as usize, moved.tile.cells.1 as usize);
        mark(&trace.crossings, moved.tile.loop_starts, |v| segments[v] != NONE, dirty);
        old_dirty.reset(cells.cells.0 as usize, cells.cells.1 as usize);
        mark(&cells.crossings, moved.old_starts, |v| stays[v], old_dirty);
    }

    /// Whether the triangles of a cell can be reused.
    fn keeps(&self, trace: &Trace, cell: [u16; 2]) -> bool {
        let [i, j] = cell.map(usize::from);
        let (column, row) = (self.columns[i], self.rows[j]);
        column != NONE
            && row != NONE
            && !self.dirty.get(i, j)
            && !trace.special.get(i, j)
            && !self.old_dirty.get(column as usize, row as usize)
    }
}

/// Marks the cells of segments that do not stay.
fn mark(crossings: &[Crossing], loop_starts: &[u32], stays: impl Fn(usize) -> bool, cells: &mut Bits) {
    let mut cell = |k: usize| {
        let [i, j] = crossings[k].cell.map(usize::from);
        cells.set(i, j);
    };
    let mut at = 0;
    for ends in loop_starts.windows(2) {
        let from = at;
        for v in ends[0]..ends[1] {
            let stays = stays(v as usize);
            while at < crossings.len() && crossings[at].segment == v {
                if !stays {
                    cell(at);
                }
                at += 1;
            }
            if !stays {
                let is_last = at == crossings.len() || crossings[at].segment >= ends[1];
                let after = if is_last { from } else { at };
                if after < crossings.len() {
                    cell(after);
                }
            }
        }
    }
}

impl CellCache {
    /// Heap size, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<Crossing>() * self.crossings.capacity()
            + size_of::<CachedRing>() * self.rings.capacity()
            + size_of::<[u32; 3]>() * self.triangles.capacity()
    }

    /// Appends the triangles of reused cells, with new vertex numbers. `None` if a vertex is gone.
    fn copy(
        &self,
        tile: &TrimInput<'_>,
        place: impl Fn([u16; 2]) -> Option<[u16; 2]>,
        to: &[u32],
        (out, kept): (&mut Vec<[u32; 3]>, &mut Vec<CachedRing>),
    ) -> Option<()> {
        let width = self.cells.0 + 1;
        for ring in &self.rings {
            let Some(cell) = place(ring.cell) else { continue };
            let move_by = [0, 1].map(|axis| u32::from(cell[axis]).wrapping_sub(u32::from(ring.cell[axis])));
            let vertex = |v: u32| {
                if v < self.tessellants {
                    return to[v as usize];
                }
                let corner = v - self.tessellants;
                let (i, j) = (corner % width, corner / width);
                tile.corner_id(i.wrapping_add(move_by[0]), j.wrapping_add(move_by[1]))
            };
            let from = out.len() as u32;
            for t in &self.triangles[ring.triangles[0] as usize..ring.triangles[1] as usize] {
                let t = t.map(vertex);
                if t.contains(&NONE) {
                    return None;
                }
                out.push(t);
            }
            kept.push(CachedRing { cell, triangles: [from, out.len() as u32] });
        }
        Some(())
    }
}

impl CellCache {
    /// Caches the last call of the trim stage and returns true, if every cell was triangulated by itself and no corner
    /// gave way to a tessellant. `out` must be as that call left it. `again` is given if the call reused cells.
    pub(crate) fn keep(
        &mut self,
        (trim, again): (&TrimScratch, Option<&AgainScratch>),
        tile: &TrimInput<'_>,
        out: &TrimOutput,
    ) -> bool {
        let TrimScratch { ladder: Rungs { trace, rings, .. }, distinct } = trim;
        let kept = again.map_or(&[][..], |again| &again.kept);
        let cells = self;
        let TrimStats { failed_rings, retraced, whole_tile, .. } = out.stats;
        let by_itself = failed_rings == 0 && !retraced && !whole_tile && trace.in_cell_loops.is_empty();
        if !by_itself || trace.snaps || distinct.repeats || tile.cells == (1, 1) {
            return false;
        }
        cells.cells = tile.cells;
        cells.tessellants = tile.points.len() as u32;
        cells.rings.clear();
        cells.rings.shrink_to(2 * (rings.rings.len() + kept.len()));
        cells.rings.reserve_exact(rings.rings.len() + kept.len());
        for ring in &rings.rings {
            let RingOrigin::Chain(k) = ring.origin else { return false };
            let cell = trace.crossings[trace.crossings[k as usize].next as usize].cell;
            cells.rings.push(CachedRing { cell, triangles: ring.triangles });
        }
        cells.rings.extend_from_slice(kept);
        keep(&mut cells.triangles, &out.triangles);
        keep(&mut cells.crossings, &trace.crossings);
        true
    }

    /// Triangulates a tile incrementally. Reuses crossings if `crossings`, and triangles of cells if `triangles`; these
    /// come last in the output. Returns the outcome and the number of new triangles. `None` if nothing stays or
    /// something is doubtful; `out` is unspecified then.
    pub(crate) fn again(
        &self,
        moved: &CellMapping<'_>,
        (trim, again): (&mut TrimScratch, &mut AgainScratch),
        (crossings, triangles): (bool, bool),
        out: &mut TrimOutput,
    ) -> Option<(TrimOutcome, usize)> {
        let none = |strips: &[u32]| strips.iter().all(|&strip| strip == NONE);
        if none(moved.columns) || none(moved.rows) {
            return None;
        }
        out.clear();
        again.kept.clear();
        let (cells, tile) = (self, &moved.tile);
        tile.validate().ok()?;
        let TrimScratch { ladder, distinct } = trim;
        if distinct.collect(tile) || tile.loops().any(|l| l.len() < 3) {
            return None;
        }
        let Rungs { trace, rings, polygon, .. } = ladder;
        trace.reset(tile, CORNER_CLEARANCE);
        again.find_segments(cells, moved, trace);
        let known = OldCrossings {
            crossings: &cells.crossings,
            first: &again.first,
            segments: &again.segments,
            columns: moved.columns,
            rows: moved.rows,
        };
        if crossings {
            trace.run(tile, |v, from| known.of(v, from));
        } else {
            trace.run(tile, |_, _| None);
        }
        if !triangles {
            let outcome = ladder.by_traced_cells(tile, out).ok()?;
            return Some((outcome, out.triangles.len()));
        }
        if !trace.in_cell_loops.is_empty() {
            return None;
        }
        out.stats.crossings = trace.crossings.len() as u32;
        again.mark_cells(cells, moved, trace);
        rings.build(tile, trace, polygon, out, |cell| again.keeps(trace, cell)).ok()?;
        if rings.failed > 0 {
            return None;
        }
        let fresh = out.triangles.len();
        let mut kept = std::mem::take(&mut again.kept);
        let place = |[i, j]: [u16; 2]| {
            let [i, j] = [moved.columns[usize::from(i)], moved.rows[usize::from(j)]];
            let cell = [u16::try_from(i).ok()?, u16::try_from(j).ok()?];
            again.keeps(trace, cell).then_some(cell)
        };
        let copied = cells.copy(tile, place, &again.to, (&mut out.triangles, &mut kept));
        again.kept = kept;
        copied?;
        out.stats.rings = (rings.rings.len() + again.kept.len()) as u32;
        let outcome = certified(tile, out).ok()?;
        Some((outcome, fresh))
    }
}

/// New index of each strip between the old lines, or [`NONE`].
pub(crate) fn strips(old: &[f64], new: &[f64], out: &mut Vec<u32>) {
    out.clear();
    let mut k = 0;
    for w in old.windows(2) {
        while k < new.len() && new[k] < w[0] {
            k += 1;
        }
        let stays = new.get(k..k + 2).is_some_and(|n| n == w);
        out.push(if stays { k as u32 } else { NONE });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::trim::climb::trim_tile;
    use glam::DVec2;

    /// A tile with loops, in parameters. Lines and tessellants differ from tile to tile.
    struct Tile {
        lines: [Vec<f64>; 2],
        /// By loop: parameter along it and point.
        loops: Vec<Vec<(f64, DVec2)>>,
    }

    impl Tile {
        fn cells(&self) -> (u32, u32) {
            (self.lines[0].len() as u32 - 1, self.lines[1].len() as u32 - 1)
        }

        fn points(&self) -> Vec<DVec2> {
            let at = |p: DVec2| {
                let [x, y] = [0, 1].map(|axis| crate::frame::plan::output::cell_coordinate(&self.lines[axis], p[axis]));
                DVec2::new(x, y)
            };
            self.loops.iter().flatten().map(|&(_, p)| at(p)).collect()
        }

        fn starts(&self) -> Vec<u32> {
            let ends = self.loops.iter().scan(0, |sum, l| {
                *sum += l.len() as u32;
                Some(*sum)
            });
            std::iter::once(0).chain(ends).collect()
        }

        fn from(&self, old: &Self) -> Vec<u32> {
            let starts = old.starts();
            let find =
                |l: usize, t: f64| old.loops[l].iter().position(|k| k.0 == t).map_or(NONE, |k| starts[l] + k as u32);
            self.loops.iter().enumerate().flat_map(|(l, ts)| ts.iter().map(move |k| find(l, k.0))).collect()
        }
    }

    /// The unit square with holes (centre, radius, tessellants), and `border` tessellants per side.
    fn tile(lines: [usize; 2], border: usize, holes: &[(DVec2, f64, usize)]) -> Tile {
        let even = |n: usize| (0..=n).map(|k| k as f64 / n as f64).collect::<Vec<f64>>();
        let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let side = |s: usize| {
            (0..border).map(move |k| {
                let t = k as f64 / border as f64;
                (s as f64 + t, corners[s].lerp(corners[(s + 1) % 4], t))
            })
        };
        let hole = |&(centre, radius, n): &(DVec2, f64, usize)| {
            let at = move |k: usize| {
                let t = k as f64 / n as f64;
                (t, centre + radius * DVec2::from_angle(-std::f64::consts::TAU * t))
            };
            (0..n).map(at).collect()
        };
        let mut loops: Vec<Vec<(f64, DVec2)>> = vec![(0..4).flat_map(side).collect()];
        loops.extend(holes.iter().map(hole));
        Tile { lines: lines.map(even), loops }
    }

    fn sorted(mut triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
        triangles.iter_mut().for_each(|t| {
            let least = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
            t.rotate_left(least);
        });
        triangles.sort_unstable();
        triangles
    }

    /// Updates from tile to tile and compares with rebuilt ones. Returns the numbers of reused and of all triangles.
    fn walk(tiles: &[Tile]) -> [usize; 2] {
        let mut counts = [0; 2];
        for ways in [(true, true), (true, false), (false, true)] {
            let (mut scratch, mut buffers) = (TrimScratch::default(), AgainScratch::default());
            let mut out = TrimOutput::default();
            let mut cells = CellCache::default();
            let mut old: Option<&Tile> = None;
            for tile in tiles {
                let (points, starts) = (tile.points(), tile.starts());
                let input = TrimInput { cells: tile.cells(), points: &points, loop_starts: &starts, places: &[] };
                let mut made = TrimOutput::default();
                let outcome = trim_tile(&input, &mut TrimScratch::default(), &mut made).unwrap();
                let again = old.and_then(|old| {
                    let (mut columns, mut rows) = (Vec::new(), Vec::new());
                    strips(&old.lines[0], &tile.lines[0], &mut columns);
                    strips(&old.lines[1], &tile.lines[1], &mut rows);
                    let (old_starts, from) = (old.starts(), tile.from(old));
                    let moved = CellMapping {
                        tile: input,
                        old_starts: &old_starts,
                        from: &from,
                        columns: &columns,
                        rows: &rows,
                    };
                    cells.again(&moved, (&mut scratch, &mut buffers), ways, &mut out)
                });
                let patched = again.is_some();
                match again {
                    Some((how, fresh)) => {
                        assert_eq!((how, &out.full_cells), (outcome, &made.full_cells));
                        assert_eq!(sorted(out.triangles.clone()), sorted(made.triangles.clone()));
                        counts[0] += out.triangles.len() - fresh;
                    }
                    None => _ = trim_tile(&input, &mut scratch, &mut out).unwrap(),
                }
                counts[1] += out.triangles.len();
                old = cells.keep((&scratch, patched.then_some(&buffers)), &input, &out).then_some(tile);
            }
        }
        counts
    }

    const A: (DVec2, f64) = (DVec2::new(0.31, 0.33), 0.17);
    const B: (DVec2, f64) = (DVec2::new(0.71, 0.62), 0.23);

    #[test]
    fn reused_triangles_equal_rebuilt_ones() {
        let with = |lines, border, a, b| tile(lines, border, &[(A.0, A.1, a), (B.0, B.1, b)]);
        // First tessellants along a hole change, then along the border. Later, lines in u and in v.
        let [kept, all] = walk(&[
            with([12, 12], 13, 30, 40),
            with([12, 12], 13, 30, 80),
            with([12, 12], 13, 37, 80),
            with([12, 12], 26, 37, 80),
            with([12, 12], 13, 37, 80),
            with([12, 12], 13, 37, 40),
            with([12, 12], 13, 37, 40),
        ]);
        assert!(4 * kept > all, "{kept} of {all}");
        let mut tiles = vec![with([9, 7], 10, 31, 43)];
        for (axis, cut) in [(0, 2), (1, 4), (0, 7), (1, 0)] {
            let mut next = with([9, 7], 10, 31, 43);
            next.lines = tiles[tiles.len() - 1].lines.clone();
            let middle = 0.5 * (next.lines[axis][cut] + next.lines[axis][cut + 1]);
            next.lines[axis].insert(cut + 1, middle);
            tiles.push(next);
        }
        tiles.push(with([9, 7], 10, 31, 43));
        let [kept, _] = walk(&tiles);
        assert!(kept > 100, "{kept}");
    }

    /// Tessellants on lines and corners, segments along lines, loops within a cell, corners that give way, slivers.
    #[test]
    fn degenerate_input_updates_like_a_rebuild() {
        let mut made = 0;
        let mut walk = |tiles: &[Tile]| made += walk(tiles)[1];
        let on_lines = |n: usize| tile([4, 4], n, &[(DVec2::new(0.5, 0.5), 0.25, 8), (DVec2::new(0.2, 0.2), 0.02, n)]);
        walk(&[on_lines(4), on_lines(8), on_lines(4), on_lines(5)]);
        let square = |n: usize, low: f64, high: f64| {
            let mut t = tile([8, 8], n, &[]);
            let corners = [(low, low), (low, high), (high, high), (high, low)];
            t.loops.push(corners.iter().enumerate().map(|(k, &(x, y))| (k as f64, DVec2::new(x, y))).collect());
            t
        };
        // Along lattice lines, off them by less than the clearance, and by a little more.
        for off in [0.0, 1e-12, 1e-5, 1e-3, 2e-3] {
            walk(&[
                square(8, 0.25 + off, 0.75 - off),
                square(16, 0.25 + off, 0.75 - off),
                square(4, 0.25 + off, 0.75 - off),
            ]);
        }
        // One and two rows of cells; a hole finer and coarser than a cell.
        for lines in [[1, 6], [6, 1], [2, 2]] {
            let with = |n: usize| tile(lines, 6, &[(DVec2::new(0.45, 0.55), 0.3, n)]);
            walk(&[with(6), with(12), with(48), with(3), with(6)]);
        }
        // Two loops through the same cells, side by side.
        let beside = |n: usize| {
            let hole = |x: f64| (DVec2::new(x, 0.5), 0.1, n);
            tile([5, 5], 5, &[hole(0.39), hole(0.6)])
        };
        walk(&[beside(12), beside(24), beside(12), beside(7)]);
        assert!(made > 1000, "{made} triangles were compared");
    }

    #[test]
    fn strips_stay_between_the_same_lines() {
        let mut out = Vec::new();
        strips(&[0.0, 1.0, 2.0, 3.0], &[0.0, 1.0, 1.5, 2.0, 3.0], &mut out);
        assert_eq!(out, [0, NONE, 3]);
        strips(&[0.0, 1.0, 1.5, 2.0, 3.0], &[0.0, 1.0, 2.0, 3.0], &mut out);
        assert_eq!(out, [0, NONE, NONE, 2]);
        strips(&[0.0, 2.0], &[0.0, 1.0, 2.0], &mut out);
        assert_eq!(out, [NONE]);
    }
}
