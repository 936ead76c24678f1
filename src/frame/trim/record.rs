//! The buffers of a tile that was just triangulated -> a record of what the stages did with it, by the input's indices.
//!
//! Recording costs nothing while triangles are made: the trace and the cell polygons stay in the buffers until the next
//! tile. Only `zone_cells` are computed again.

use super::climb::TrimScratch;
use super::input::TrimInput;
use super::output::TrimStats;
use super::reference;
use glam::DVec2;
use std::collections::BTreeMap;

/// Record of the stages that triangulated one tile, in cell units. Lists are empty for stages that were not reached.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct TrimRecord {
    /// Crossings of segments with lattice lines, in curve order. If the whole tile was triangulated at once, they are
    /// those of the failed attempt.
    pub crossings: Vec<TracedCrossing>,
    /// By tessellant, its cell; `None` if it repeats its neighbour.
    pub cell_of: Vec<Option<[u32; 2]>>,
    /// Lattice corners inside the region.
    pub kept_corners: Vec<[u32; 2]>,
    /// Kept corners that are replaced by a tessellant close to them, and its index.
    pub moved_corners: Vec<([u32; 2], u32)>,
    /// Prime-active cells: crossed by loops, or with a whole loop inside, or with a moved corner.
    pub prime_cells: Vec<[u32; 2]>,
    /// Pseudo-active cells: crossed by loops, but with no part of the region left in them.
    pub pseudo_cells: Vec<[u32; 2]>,
    /// Cells whose polygons were triangulated together, because some failed by themselves.
    pub merged_cells: Vec<[u32; 2]>,
    /// Cells that loops come near to, if the whole tile was triangulated at once.
    pub zone_cells: Vec<[u32; 2]>,
}

/// A crossing of a loop's segment with a lattice line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracedCrossing {
    /// Position.
    pub at: DVec2,
    /// The tessellants before and after it. Unless the segment crosses several lines, they are the paper's exit point
    /// of the cell that it leaves, and its external point.
    pub segment: [u32; 2],
    /// The one of them that replaces the crossing.
    pub snap: u32,
    /// The cell that the loop leaves, and the one that it enters.
    pub cells: [[u32; 2]; 2],
}

impl TrimScratch {
    /// Records the last call of [`trim_tile`](super::climb::trim_tile), which must have been with this input.
    pub(crate) fn record(&self, input: &TrimInput<'_>, stats: &TrimStats) -> TrimRecord {
        let repeats = self.distinct.repeats;
        let traced = if repeats { self.distinct.tile(input) } else { *input };
        let original = |v: u32| if repeats { self.distinct.original[v as usize] } else { v };
        let mut out = TrimRecord { cell_of: vec![None; input.points.len()], ..TrimRecord::default() };
        if stats.whole_tile {
            out.zone_cells = reference::zone(&traced);
        }
        let trace = &self.ladder.trace;
        let (nu, nv) = trace.cells();
        if (nu as u32, nv as u32) != input.cells {
            return out;
        }
        for (k, crossing) in trace.crossings.iter().enumerate() {
            let (at, beyond) = trace.place(crossing);
            let l = crossing.loop_index;
            let segment = [crossing.segment, traced.next(l, crossing.segment)];
            let snap = segment[usize::from(crossing.snap != crossing.segment)];
            let cell = crossing.cell.map(u32::from);
            let [segment, snap] = [segment, [snap; 2]].map(|ids| ids.map(original));
            out.crossings.push(TracedCrossing { at, segment, snap: snap[0], cells: [cell, beyond] });
            // The chain from here lies in the cell that the next crossing leaves.
            let to = &trace.crossings[trace.crossings[k].next as usize];
            let mut v = traced.next(l, crossing.segment);
            let count = if crossing.segment == to.segment && !crossing.wraps {
                0
            } else {
                let length = traced.loop_starts[l as usize + 1] - traced.loop_starts[l as usize];
                (to.segment + length - crossing.segment - 1) % length + 1
            };
            for _ in 0..count {
                out.cell_of[original(v) as usize] = Some(to.cell.map(u32::from));
                v = traced.next(l, v);
            }
        }
        for l in &trace.in_cell_loops {
            let ends = &traced.loop_starts[l.loop_index as usize..];
            (ends[0]..ends[1]).for_each(|v| out.cell_of[original(v) as usize] = Some(input.cell(l.cell)));
        }
        for j in 0..=nv {
            for i in (0..=nu).filter(|&i| trace.kept.get(i, j)) {
                let corner = [i as u32, j as u32];
                out.kept_corners.push(corner);
                let (vertex, _) = trace.corner(&traced, i, j);
                if (vertex as usize) < traced.points.len() {
                    out.moved_corners.push((corner, original(vertex)));
                }
            }
        }
        if !stats.whole_tile {
            self.record_pieces(input, &mut out);
        }
        out
    }

    /// Records cells by the outcome of their polygons.
    fn record_pieces(&self, input: &TrimInput<'_>, out: &mut TrimRecord) {
        let (trace, rings) = (&self.ladder.trace, &self.ladder.rings);
        let loops = trace.in_cell_loops.iter().map(|l| (input.cell(l.cell), true));
        let mut cells: BTreeMap<[u32; 2], bool> = loops.collect();
        for ring in &rings.rings {
            let vanished = ring.solved && ring.triangles[0] == ring.triangles[1];
            *cells.entry(ring.cell(input, trace)).or_default() |= !vanished;
        }
        for (cell, is_left) in cells {
            if is_left { &mut out.prime_cells } else { &mut out.pseudo_cells }.push(cell);
        }
        out.merged_cells.extend(&rings.joined);
    }
}

#[cfg(test)]
mod tests {
    use super::super::climb::trim_tile;
    use super::super::output::TrimOutput;
    use super::*;

    #[test]
    fn a_record_does_not_depend_on_repeated_points_of_the_tile_before() {
        let square = [(0.5, 0.5), (1.5, 0.5), (1.5, 1.5), (0.5, 1.5)].map(DVec2::from);
        let repeated = [square[2], square[2], square[3], square[0], square[1]];
        let input = |points| TrimInput { cells: (2, 2), points, loop_starts: &[0, 4], places: &[] };
        let record = |scratch: &mut TrimScratch| {
            let mut out = TrimOutput::default();
            trim_tile(&input(&square), scratch, &mut out).expect("a tile");
            scratch.record(&input(&square), &out.stats)
        };
        let fresh = record(&mut TrimScratch::default());
        let mut used = TrimScratch::default();
        let before = TrimInput { loop_starts: &[0, 5], ..input(&repeated) };
        trim_tile(&before, &mut used, &mut TrimOutput::default()).expect("a tile");
        let again = record(&mut used);
        assert_eq!((again.crossings, again.cell_of), (fresh.crossings, fresh.cell_of));
    }
}
