//! Loops in a plane -> strictly positive triangles with the same boundary, by a sweep; or a refusal.
//!
//! Method: Hertel and Mehlhorn, "Fast triangulation of simple polygons", 1983. A line passes over the vertices along
//! the longer side of their box, here from left to right. What it cuts of the region is intervals between two segments.
//! The part of an interval's region that has no triangles yet ends on the left in a chain, which turns away from it at
//! every inner vertex. Each vertex that the line meets extends a chain, and cuts off the triangles that are positive. A
//! vertex that points to the left, into an interval, splits it: its partner is the last vertex of that interval. One
//! that points to the right joins two.
//!
//! Diagonals and triangles are cut off chains, so the boundary of all triangles is the loops, whatever the input: that
//! all are positive is the only thing to prove, and it is checked. Simple loops, with holes and islands to any depth,
//! always pass. Cost: sorting, and for each vertex that starts, splits, joins or ends an interval, a search and a move
//! in the list of intervals.

use super::flip::{BORDER, Mesh};
use super::input::NONE;
use crate::math::order::{larger, ordered, smaller};
use crate::math::predicates::orient2d;
use glam::DVec2;

/// Work space of [`Sweep::triangulate`].
#[derive(Default)]
pub(crate) struct Sweep {
    /// By vertex: its neighbours in its loop.
    next: Vec<u32>,
    prev: Vec<u32>,
    /// The vertices in the order in which the line meets them, each with its coordinate as a number in [`ordered`]; and
    /// the place of each there.
    order: Vec<(i64, u32)>,
    rank: Vec<u32>,
    /// By the vertex that a segment starts from: the interval that it bounds.
    bounds: Vec<u32>,
    intervals: Vec<Interval>,
    /// The intervals that the line cuts, from below.
    cut: Vec<u32>,
    nodes: Vec<Node>,
    mesh: Mesh,
}

/// A stretch of the sweep line inside the region.
#[derive(Clone, Copy)]
struct Interval {
    /// Where the segment below starts, which runs to the right, and the one above, which runs to the left.
    below: u32,
    above: u32,
    /// The ends of the chain: nodes of the left ends of these segments.
    low: u32,
    high: u32,
    /// The node of the last vertex that the line met in this interval.
    last: u32,
}

/// A vertex of a chain.
#[derive(Clone, Copy)]
struct Node {
    vertex: u32,
    lower: u32,
    upper: u32,
    /// The edge to the node above.
    edge: u32,
}

/// The loops wind otherwise than once or never around some point, or touch where the sweep cannot tell how.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NotSimple;

impl Sweep {
    /// Triangulates the region to the left of loops of vertices: loop k has the indices from `starts[k]` to the next
    /// start, or to the end.
    pub(crate) fn triangulate(&mut self, points: &[DVec2], starts: &[u32]) -> Result<&Mesh, NotSimple> {
        self.load(points, starts);
        for at in 0..self.order.len() {
            self.meet(points, self.order[at].1)?;
        }
        if !self.cut.is_empty() {
            return Err(NotSimple);
        }
        self.mesh.flip(points);
        Ok(&self.mesh)
    }

    fn load(&mut self, points: &[DVec2], starts: &[u32]) {
        let n = points.len() as u32;
        self.next.clear();
        self.prev.clear();
        self.order.clear();
        for (k, &start) in starts.iter().enumerate() {
            let end = starts.get(k + 1).copied().unwrap_or(n);
            if start == end {
                continue;
            }
            self.next.extend(start + 1..end);
            self.next.push(start);
            self.prev.push(end - 1);
            self.prev.extend(start..end - 1);
            // The two segments of a loop of two vertices cancel.
            if end - start > 2 {
                self.order.extend((start..end).map(|v| (0, v)));
            }
        }
        self.sort(points);
        self.rank.clear();
        self.rank.resize(n as usize, 0);
        for (rank, &(_, v)) in self.order.iter().enumerate() {
            self.rank[v as usize] = rank as u32;
        }
        self.bounds.clear();
        self.bounds.resize(n as usize, NONE);
        self.intervals.clear();
        self.cut.clear();
        self.nodes.clear();
        self.mesh.clear();
    }

    /// Puts the vertices into the order in which the line meets them. It moves along the longer side of their box: the
    /// triangles that it leaves are wider that way, and fewer of them are flipped.
    fn sort(&mut self, points: &[DVec2]) {
        let (low, high) = points.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
            let axis = |k: usize| (smaller(p[k], low[k]), larger(p[k], high[k]));
            let [x, y] = [0, 1].map(axis);
            (DVec2::new(x.0, y.0), DVec2::new(x.1, y.1))
        });
        // Turned by a right angle if it is tall.
        let tall = high.y - low.y > high.x - low.x;
        let along = |p: DVec2| ordered(if tall { p.y } else { p.x });
        let across = |v: u32| ordered(if tall { -points[v as usize].x } else { points[v as usize].y });
        self.order.iter_mut().for_each(|(key, v)| *key = along(points[*v as usize]));
        self.order
            .sort_unstable_by(|&(p, a), &(q, b)| p.cmp(&q).then_with(|| across(a).cmp(&across(b)).then(a.cmp(&b))));
    }

    /// Moves the line over vertex `v`.
    fn meet(&mut self, points: &[DVec2], v: u32) -> Result<(), NotSimple> {
        let (from, to) = (self.prev[v as usize], self.next[v as usize]);
        let here = self.rank[v as usize];
        match (self.rank[from as usize] < here, self.rank[to as usize] < here) {
            (true, false) => {
                let interval = self.bounded_by(from)?;
                self.extend_low(points, interval, v, BORDER);
                self.intervals[interval as usize].below = v;
                self.bounds[v as usize] = interval;
            }
            (false, true) => {
                let interval = self.bounded_by(v)?;
                self.extend_high(points, interval, v, BORDER);
                self.intervals[interval as usize].above = from;
                self.bounds[from as usize] = interval;
            }
            (true, true) => {
                let (over, under) = (self.bounded_by(from)?, self.bounded_by(v)?);
                self.leave(points, over, v)?;
                if over == under {
                    self.finish(points, over, v)?;
                } else {
                    self.join(points, under, over, v);
                }
            }
            (false, false) => {
                let turn = orient2d(points[from as usize], points[v as usize], points[to as usize]);
                let below = self.count_below(points, v, false);
                if turn > 0.0 {
                    self.start(v, from, below);
                } else if turn < 0.0 && below > 0 {
                    self.split(points, v, from, below);
                } else {
                    return Err(NotSimple);
                }
            }
        }
        Ok(())
    }

    /// The interval bounded by the segment that starts from `v`.
    fn bounded_by(&self, v: u32) -> Result<u32, NotSimple> {
        let interval = self.bounds[v as usize];
        if interval == NONE { Err(NotSimple) } else { Ok(interval) }
    }

    /// How many of the intervals begin below vertex `v`; with `or_at`, those that begin at it count too.
    fn count_below(&self, points: &[DVec2], v: u32, or_at: bool) -> usize {
        self.cut.partition_point(|&interval| {
            let below = self.intervals[interval as usize].below as usize;
            let turn = orient2d(points[below], points[self.next[below] as usize], points[v as usize]);
            turn > 0.0 || (or_at && turn == 0.0)
        })
    }

    /// Begins an interval at a vertex that points to the left, out of the region.
    fn start(&mut self, v: u32, from: u32, at: usize) {
        let node = self.add_node(v);
        let interval = self.intervals.len() as u32;
        self.intervals.push(Interval { below: v, above: from, low: node, high: node, last: node });
        self.bounds[v as usize] = interval;
        self.bounds[from as usize] = interval;
        self.cut.insert(at, interval);
    }

    /// Splits the interval before `at`. Its chain is split at its last vertex, from which a diagonal leads to `v`.
    fn split(&mut self, points: &[DVec2], v: u32, from: u32, at: usize) {
        let (lower, upper) = (self.cut[at - 1], self.intervals.len() as u32);
        let Interval { above, high, last, .. } = self.intervals[lower as usize];
        let Node { vertex, upper: onward, edge, .. } = self.nodes[last as usize];
        let twin = self.add_node(vertex);
        self.nodes[last as usize].upper = NONE;
        self.link(twin, onward, edge);
        let high_of_upper = if onward == NONE { twin } else { high };
        self.intervals.push(Interval { below: v, above, low: twin, high: high_of_upper, last: twin });
        let interval = &mut self.intervals[lower as usize];
        (interval.above, interval.high) = (from, last);
        self.bounds[from as usize] = lower;
        self.bounds[above as usize] = upper;
        self.bounds[v as usize] = upper;
        self.cut.insert(at, upper);
        let diagonal = self.mesh.add_edge();
        self.extend_high(points, lower, v, diagonal);
        self.extend_low(points, upper, v, diagonal);
    }

    /// Joins two intervals that meet at a vertex which points to the right, into the region.
    fn join(&mut self, points: &[DVec2], under: u32, over: u32, v: u32) {
        self.extend_high(points, under, v, BORDER);
        self.extend_low(points, over, v, BORDER);
        let Interval { above, low, high, .. } = self.intervals[over as usize];
        let joint = self.intervals[under as usize].high;
        let Node { upper: onward, edge, .. } = self.nodes[low as usize];
        self.link(joint, onward, edge);
        let interval = &mut self.intervals[under as usize];
        (interval.above, interval.high, interval.last) = (above, high, joint);
        self.bounds[above as usize] = under;
    }

    /// Takes out of the list the interval that begins at `v`.
    fn leave(&mut self, points: &[DVec2], interval: u32, v: u32) -> Result<(), NotSimple> {
        let count = self.count_below(points, v, true);
        if count == 0 || self.cut[count - 1] != interval {
            return Err(NotSimple);
        }
        self.cut.remove(count - 1);
        Ok(())
    }

    /// Cuts off all triangles that are left in an interval that ends at `v`.
    fn finish(&mut self, points: &[DVec2], interval: u32, v: u32) -> Result<(), NotSimple> {
        let mut low = self.intervals[interval as usize].low;
        let mut edge = BORDER;
        loop {
            let Node { vertex: b, upper, edge: side, .. } = self.nodes[low as usize];
            if upper == NONE {
                return Ok(());
            }
            let Node { vertex: a, upper: beyond, .. } = self.nodes[upper as usize];
            if orient2d(points[a as usize], points[b as usize], points[v as usize]) <= 0.0 {
                return Err(NotSimple);
            }
            let cut = if beyond == NONE { BORDER } else { self.mesh.add_edge() };
            self.mesh.add([a, b, v], [side, edge, cut]);
            (low, edge) = (upper, cut);
        }
    }

    /// Appends `v` below a chain, after it has cut off what triangles it can. `edge` leads from the lowest node to `v`.
    fn extend_low(&mut self, points: &[DVec2], interval: u32, v: u32, mut edge: u32) {
        let mut low = self.intervals[interval as usize].low;
        loop {
            let Node { vertex: b, upper, edge: side, .. } = self.nodes[low as usize];
            if upper == NONE {
                break;
            }
            let a = self.nodes[upper as usize].vertex;
            if orient2d(points[a as usize], points[b as usize], points[v as usize]) <= 0.0 {
                break;
            }
            let cut = self.mesh.add_edge();
            self.mesh.add([a, b, v], [side, edge, cut]);
            (low, edge) = (upper, cut);
        }
        let node = self.add_node(v);
        self.link(node, low, edge);
        let interval = &mut self.intervals[interval as usize];
        (interval.low, interval.last) = (node, node);
    }

    /// Appends `v` above a chain, as [`Self::extend_low`] does below.
    fn extend_high(&mut self, points: &[DVec2], interval: u32, v: u32, mut edge: u32) {
        let mut high = self.intervals[interval as usize].high;
        loop {
            let Node { vertex: b, lower, .. } = self.nodes[high as usize];
            if lower == NONE {
                break;
            }
            let Node { vertex: a, edge: side, .. } = self.nodes[lower as usize];
            if orient2d(points[v as usize], points[b as usize], points[a as usize]) <= 0.0 {
                break;
            }
            let cut = self.mesh.add_edge();
            self.mesh.add([v, b, a], [edge, side, cut]);
            (high, edge) = (lower, cut);
        }
        let node = self.add_node(v);
        self.link(high, node, edge);
        let interval = &mut self.intervals[interval as usize];
        (interval.high, interval.last) = (node, node);
    }

    fn add_node(&mut self, vertex: u32) -> u32 {
        self.nodes.push(Node { vertex, lower: NONE, upper: NONE, edge: BORDER });
        self.nodes.len() as u32 - 1
    }

    /// Makes two nodes neighbours; `upper` may be [`NONE`].
    fn link(&mut self, lower: u32, upper: u32, edge: u32) {
        self.nodes[lower as usize].upper = upper;
        self.nodes[lower as usize].edge = edge;
        if upper != NONE {
            self.nodes[upper as usize].lower = lower;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::trim::cdt::{self, AtCrossings, Segment};
    use std::f64::consts::TAU;

    /// Loops around centres, each with a number of corners and a radius; clockwise where the number is negative.
    fn rounds(loops: &[(f64, f64, i32, f64)]) -> (Vec<DVec2>, Vec<u32>) {
        let (mut points, mut starts) = (Vec::new(), Vec::new());
        for &(x, y, corners, radius) in loops {
            starts.push(points.len() as u32);
            let corner = |k: i32| {
                let angle = TAU * f64::from(k) / f64::from(corners);
                DVec2::new(x, y) + DVec2::from_angle(angle) * radius * (1.0 + 0.2 * (5.0 * angle).sin())
            };
            points.extend((0..corners.abs()).map(corner));
        }
        (points, starts)
    }

    /// Sweeps, and proves that the boundary of the triangles is the loops and that all are positive.
    fn sweep(points: &[DVec2], starts: &[u32]) -> Result<usize, NotSimple> {
        let mut sweep = Sweep::default();
        let triangles: Vec<_> = sweep.triangulate(points, starts)?.triangles().collect();
        let mut sides: Vec<[u32; 2]> = Vec::new();
        for (k, &start) in starts.iter().enumerate() {
            let end = starts.get(k + 1).map_or(points.len() as u32, |&end| end);
            sides.extend((start..end).map(|v| [if v + 1 == end { start } else { v + 1 }, v]));
        }
        for &[a, b, c] in &triangles {
            assert!(orient2d(points[a as usize], points[b as usize], points[c as usize]) > 0.0);
            sides.extend([[a, b], [b, c], [c, a]]);
        }
        // A loop of one vertex has no side.
        sides.retain(|[a, b]| a != b);
        while let Some([a, b]) = sides.pop() {
            let at = sides.iter().position(|&side| side == [b, a]).expect("each side has its reverse");
            sides.swap_remove(at);
        }
        Ok(triangles.len())
    }

    #[test]
    fn holes_islands_and_regions_side_by_side() {
        let disc = (0.0, 0.0, 60, 10.0);
        let hole = (1.0, 1.0, -40, 5.0);
        let island = (1.0, 1.0, 20, 3.0);
        let other = (30.0, 0.0, 9, 4.0);
        for (loops, count) in [
            (&[disc][..], 58),
            (&[disc, hole], 100),
            (&[hole, disc, island], 118),
            (&[other, island, disc, hole], 7 + 18 + 100),
            (&[disc, (5.0, 0.0, -7, 1.0), (-5.0, 0.0, -7, 1.0), (0.0, 5.0, -7, 1.0)], 58 + 27),
        ] {
            let (points, starts) = rounds(loops);
            assert_eq!(sweep(&points, &starts).ok(), Some(count), "{loops:?}");
        }
    }

    #[test]
    fn columns_and_rows_of_corners_in_line() {
        // Squares with corners along their sides: the line meets many vertices at once, and many lie on a line.
        let side = |a: DVec2, b: DVec2| (0..6).map(move |k| a.lerp(b, f64::from(k) / 8.0));
        let square = |low: f64, high: f64| {
            let corners = [(low, low), (high, low), (high, high), (low, high)].map(DVec2::from);
            (0..4).flat_map(move |k| side(corners[k], corners[(k + 1) % 4])).collect::<Vec<_>>()
        };
        let mut points = square(0.0, 8.0);
        let mut hole = square(2.0, 6.0);
        hole.reverse();
        assert!(orient2d(hole[0], hole[8], hole[16]) < 0.0);
        points.extend(hole);
        assert_eq!(sweep(&points, &[0, 24]).ok(), Some(48));
        // Teeth that end in one column. The line meets all at once if the comb is wide, one after the other if it is tall.
        for back in [300.0, 3.0] {
            let teeth = (0..41).map(|k| DVec2::new(f64::from(k % 2), f64::from(40 - k)));
            let comb: Vec<_> = [DVec2::new(back, 0.0), DVec2::new(back, 40.0)].into_iter().chain(teeth).collect();
            let turned: Vec<_> = comb.iter().map(|p| p.perp()).collect();
            assert_eq!([comb, turned].map(|comb| sweep(&comb, &[0]).ok()), [Some(41); 2]);
        }
    }

    /// The deciles of the triangles' smallest angles, and the length of all sides.
    fn shapes(points: &[DVec2], triangles: &[[u32; 3]]) -> (Vec<f64>, f64) {
        let mut length = 0.0;
        let mut smallest: Vec<f64> = Vec::new();
        for triangle in triangles {
            let corners = triangle.map(|v| points[v as usize]);
            let angles = [0, 1, 2].map(|k| {
                let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3].map(|at| corners[at]);
                length += a.distance(b);
                (b - a).angle_to(c - a).abs()
            });
            smallest.push(angles.into_iter().fold(f64::INFINITY, f64::min));
        }
        smallest.sort_by(f64::total_cmp);
        ((1..10).map(|k| smallest[k * smallest.len() / 10]).collect(), length)
    }

    #[test]
    fn triangles_come_close_to_delaunay() {
        let hole = |k: i32| (f64::from(k % 5) * 4.0 - 8.0, f64::from(k / 5) * 4.0 - 8.0, -24, 1.2);
        let plate: Vec<_> = std::iter::once((0.0, 0.0, 90, 18.0)).chain((0..25).map(hole)).collect();
        let ring = [(0.0, 0.0, 300, 10.0), (0.0, 0.0, -300, 9.0)];
        for loops in [&[(0.0, 0.0, 40, 1.0)][..], &[(0.0, 0.0, 256, 1.0)], &ring, &plate] {
            let (points, starts) = rounds(loops);
            let mut sweep = Sweep::default();
            let swept: Vec<_> = sweep.triangulate(&points, &starts).expect("simple").triangles().collect();
            let next = sweep.next.iter().zip(0..);
            let segments: Vec<_> = next.map(|(&to, from)| Segment { ends: [from, to], weight: 1 }).collect();
            let delaunay = cdt::triangulate(&points, &segments, AtCrossings::Refuse).expect("simple").triangles;
            let ((ours, length), (theirs, least)) = (shapes(&points, &swept), shapes(&points, &delaunay));
            assert_eq!(swept.len(), delaunay.len());
            assert!(length <= 1.2 * least, "{loops:?}: {length} and {least}");
            assert!(ours.iter().zip(&theirs).all(|(a, b)| 2.0 * a >= *b), "{loops:?}: {ours:?} and {theirs:?}");
        }
    }

    #[test]
    fn loops_without_area_add_nothing() {
        let (mut points, mut starts) = rounds(&[(0.0, 0.0, 6, 1.0)]);
        starts.extend([6, 6, 7]);
        points.extend([DVec2::ZERO, DVec2::ZERO, DVec2::new(0.1, 0.0)]);
        assert_eq!(sweep(&points, &starts).ok(), Some(4));
        assert_eq!(sweep(&[], &[0]).ok(), Some(0));
    }

    #[test]
    fn loops_that_wind_otherwise_are_refused() {
        let (clockwise, starts) = rounds(&[(0.0, 0.0, -12, 1.0)]);
        assert!(sweep(&clockwise, &starts).is_err());
        let eight = [(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)].map(DVec2::from);
        assert!(sweep(&eight, &[0]).is_err());
        let (outside, starts) = rounds(&[(0.0, 0.0, 12, 1.0), (9.0, 0.0, -12, 1.0)]);
        assert!(sweep(&outside, &starts).is_err());
        let (crossing, starts) = rounds(&[(0.0, 0.0, 12, 1.0), (1.0, 0.0, -12, 1.0)]);
        assert!(sweep(&crossing, &starts).is_err());
    }
}
