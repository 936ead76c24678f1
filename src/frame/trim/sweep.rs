//! Loops in a plane -> strictly positive triangles with the same boundary, by a sweep; or a refusal.
//!
//! Method: Hertel and Mehlhorn, "Fast triangulation of simple polygons", 1983. A line passes over the vertices from
//! left to right. What it cuts of the region is intervals between two segments. The part of an interval's region that
//! has no triangles yet ends on the left in a chain, which turns away from it at every inner vertex. Each vertex that
//! the line meets extends a chain, and cuts off the triangles that are positive. A vertex that points to the left, into
//! an interval, splits it: its partner is the last vertex of that interval. One that points to the right joins two.
//!
//! Diagonals and triangles are cut off chains, so the boundary of all triangles is the loops, whatever the input: that
//! all are positive is the only thing to prove, and it is checked. Simple loops, with holes and islands to any depth,
//! always pass. Cost: sorting, and for each vertex that starts, splits, joins or ends an interval, a search and a move
//! in the list of intervals.

use super::flip::{BORDER, Mesh};
use super::input::NONE;
use crate::math::predicates::orient2d;
use glam::DVec2;

/// Work space of [`Sweep::triangulate`].
#[derive(Default)]
pub(crate) struct Sweep {
    /// By vertex: its neighbours in its loop.
    next: Vec<u32>,
    prev: Vec<u32>,
    /// The vertices from left to right, and the place of each there.
    order: Vec<u32>,
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
            self.meet(points, self.order[at])?;
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
            self.next.extend(start + 1..end);
            self.next.push(start);
            self.prev.push(end - 1);
            self.prev.extend(start..end - 1);
            // The two segments of a loop of two vertices cancel.
            if end - start > 2 {
                self.order.extend(start..end);
            }
        }
        let left_of = |&a: &u32, &b: &u32| {
            let (p, q) = (points[a as usize], points[b as usize]);
            p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(a.cmp(&b))
        };
        self.order.sort_unstable_by(left_of);
        self.rank.clear();
        self.rank.resize(n as usize, 0);
        for (rank, &v) in self.order.iter().enumerate() {
            self.rank[v as usize] = rank as u32;
        }
        self.bounds.clear();
        self.bounds.resize(n as usize, NONE);
        self.intervals.clear();
        self.cut.clear();
        self.nodes.clear();
        self.mesh.clear();
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
