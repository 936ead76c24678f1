//! Loops in a plane -> strictly positive triangles with the same boundary, by a sweep; or a refusal.
//!
//! Method: Hertel and Mehlhorn, "Fast triangulation of simple polygons", 1983. A line passes over the vertices roughly
//! along the longer side of their box, here from left to right. What it cuts of the region is intervals between two
//! segments. The part of an interval's region that has no triangles yet ends on the left in a chain, which turns away
//! from it at every inner vertex. Each vertex that the line meets extends a chain, and cuts off the triangles that are
//! positive. A vertex that points to the left, into an interval, splits it: its partner is the last vertex of that
//! interval. One that points to the right joins two.
//!
//! Diagonals and triangles are cut off chains, so the boundary of all triangles is the loops, whatever the input: that
//! all are positive is the only thing to prove, and it is checked. Simple loops, with holes and islands to any depth,
//! always pass. Cost: a sort, and searches in the list of intervals: one per split, and one per interval that has begun
//! since the last split and is still open. If there are many fewer splits from right to left, the line moves that way.

use super::flip::{BORDER, Mesh};
use super::input::NONE;
use super::order::Order;
use super::runs::{Place, Runs};
use crate::math::predicates::orient2d;
use glam::DVec2;

/// How the line leans, and whether another sweep follows where there are too many flips. A line along columns of holes
/// meets a whole column at once. The first vertex gets the triangles of all that is between two columns, and to move
/// these along takes flips in proportion to the square of their number.
///
/// Fractions approximate no number worse than the golden ratio (Hurwitz, 1891). If the rows and columns of a lattice
/// are along the box, at a simple ratio, then no line along which it has many holes is near the line of the sweep.
/// Columns of other lattices may be along the first line. No lattice that was tried has long columns along both.
pub(super) const SWEEPS: [(f64, bool); 2] = [(1.0 - PER_GOLDEN, true), (-PER_GOLDEN, false)];

/// One over the golden ratio, which is the golden ratio less one.
const PER_GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Work space of [`Sweep::triangulate`].
#[derive(Default)]
pub(crate) struct Sweep {
    order: Order,
    points: Vec<DVec2>,
    links: Vec<Link>,
    /// By vertex, the interval bounded by the segment that starts from it.
    bounded: Vec<u32>,
    intervals: Vec<Interval>,
    /// By interval, the ends of the segment below: the search needs nothing else.
    lines: Vec<[DVec2; 2]>,
    /// The intervals that were open at the last split, from below. Only a split needs their order.
    cut: Runs,
    /// Intervals that began since then.
    began: Vec<u32>,
    /// Intervals that ended since then.
    ended: Vec<u32>,
    nodes: Vec<Node>,
    mesh: Mesh,
}

/// A vertex's neighbours in its loop.
#[derive(Clone, Copy)]
struct Link {
    from: u32,
    to: u32,
}

/// A stretch of the sweep line inside the region.
#[derive(Clone, Copy)]
struct Interval {
    /// Where the segment above starts, which runs to the left.
    above: u32,
    /// The ends of the chain: nodes of the left ends of both segments. `low` is [`NONE`] once the interval has ended.
    low: u32,
    high: u32,
    /// The node of the last vertex that the line met in this interval.
    last: u32,
}

/// A vertex of a chain.
#[derive(Clone, Copy)]
struct Node {
    point: DVec2,
    vertex: u32,
    lower: u32,
    upper: u32,
    /// The side, of a triangle on the left, of the edge to the node above.
    edge: u32,
}

/// The loops wind otherwise than once or never around some point, or touch where the sweep cannot tell how.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NotSimple;

impl Sweep {
    /// Triangulates the region to the left of loops of points: loop k has the `ids` from `starts[k]` to the next
    /// start, or to the end.
    pub(crate) fn triangulate(
        &mut self,
        points: &[DVec2],
        ids: &[u32],
        starts: &[u32],
    ) -> Result<&mut Mesh, NotSimple> {
        for (lean, may_stop) in SWEEPS {
            self.load(points, ids, starts, lean);
            for v in 0..self.links.len() as u32 {
                self.meet(v)?;
            }
            if self.mesh.flip(&self.points, may_stop) {
                break;
            }
        }
        self.mesh.rename(|v| ids[self.order.vertex(v) as usize]);
        Ok(&mut self.mesh)
    }

    /// The triangles of the last call.
    pub(crate) fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    fn load(&mut self, points: &[DVec2], ids: &[u32], starts: &[u32], lean: f64) {
        let ends = starts.iter().skip(1).copied().chain([ids.len() as u32]);
        // The two segments of a loop of two vertices cancel.
        let loops = starts.iter().copied().zip(ends).filter(|(start, end)| end - start > 2);
        self.order.sort(points, ids, loops.clone(), lean);
        let count = self.order.len();
        self.points.resize(count, DVec2::ZERO);
        self.links.resize(count, Link { from: 0, to: 0 });
        for (start, end) in loops {
            let vertices = start as usize..end as usize;
            let ranks = &self.order.ranks()[vertices.clone()];
            let mut from = ranks[ranks.len() - 1];
            let after = ranks[1..].iter().chain(&ranks[..1]);
            for ((&rank, &to), &id) in ranks.iter().zip(after).zip(&ids[vertices]) {
                self.points[rank as usize] = points[id as usize];
                self.links[rank as usize] = Link { from, to };
                from = rank;
            }
        }
        self.bounded.clear();
        self.bounded.resize(count, NONE);
        self.intervals.clear();
        self.lines.clear();
        self.cut.clear();
        self.began.clear();
        self.ended.clear();
        self.nodes.clear();
        self.mesh.clear();
    }

    /// Moves the line over vertex `v`.
    #[inline(always)]
    fn meet(&mut self, v: u32) -> Result<(), NotSimple> {
        let Link { from, to } = self.links[v as usize];
        match (from < v, to < v) {
            (true, false) => {
                let interval = self.bounded_by(from)?;
                self.extend_low(interval, v, BORDER);
                self.lines[interval as usize] = [v, to].map(|v| self.points[v as usize]);
                self.bounded[v as usize] = interval;
            }
            (false, true) => {
                let interval = self.bounded_by(v)?;
                self.extend_high(interval, v, BORDER);
                self.intervals[interval as usize].above = from;
                self.bounded[from as usize] = interval;
            }
            (true, true) => {
                let (over, under) = (self.bounded_by(from)?, self.bounded_by(v)?);
                self.ended.push(over);
                if over == under {
                    self.finish(over, v)?;
                } else {
                    self.join(under, over, v);
                }
            }
            (false, false) => {
                let [before, at, after] = [from, v, to].map(|v| self.points[v as usize]);
                let turn = orient2d(before, at, after);
                if turn > 0.0 {
                    self.start(v, [from, to]);
                } else if turn < 0.0 {
                    self.split(v, [from, to])?;
                } else {
                    return Err(NotSimple);
                }
            }
        }
        Ok(())
    }

    /// The interval bounded by the segment that starts from `v`.
    fn bounded_by(&self, v: u32) -> Result<u32, NotSimple> {
        let interval = self.bounded[v as usize];
        if interval == NONE { Err(NotSimple) } else { Ok(interval) }
    }

    /// The place after the intervals whose lower segment is below vertex `v`.
    fn place_of(&self, v: u32) -> Place {
        let point = self.points[v as usize];
        self.cut.after(self.order.height(point), |interval| {
            let [from, to] = self.lines[interval as usize];
            orient2d(from, to, point) > 0.0
        })
    }

    /// Makes `cut` the intervals that the line cuts now.
    fn update_cut(&mut self) {
        while let Some(old) = self.ended.pop() {
            self.cut.remove(old);
        }
        while let Some(new) = self.began.pop() {
            let (low, line) = (self.intervals[new as usize].low, self.lines[new as usize]);
            if low == NONE {
                continue;
            }
            // At the later of their starts, both segments are there.
            let first = self.nodes[low as usize].vertex;
            let place = self.cut.after(self.order.height(line[0]), |other| {
                let other_line = self.lines[other as usize];
                if self.nodes[self.intervals[other as usize].low as usize].vertex < first {
                    side(other_line, line) > 0.0
                } else {
                    side(line, other_line) < 0.0
                }
            });
            self.cut.insert(place, new, self.order.height(line[0]));
        }
    }

    /// Begins an interval at a vertex that points to the left, out of the region.
    fn start(&mut self, v: u32, [from, to]: [u32; 2]) {
        let line = [v, to].map(|v| self.points[v as usize]);
        let node = self.add_node(Node { point: line[0], vertex: v, lower: NONE, upper: NONE, edge: BORDER });
        let interval = self.intervals.len() as u32;
        self.lines.push(line);
        self.intervals.push(Interval { above: from, low: node, high: node, last: node });
        self.bounded[v as usize] = interval;
        self.bounded[from as usize] = interval;
        self.began.push(interval);
    }

    /// Splits the interval at a vertex that points to the left, into it. Its chain is split at its last vertex, from
    /// which a diagonal leads to `v`.
    fn split(&mut self, v: u32, [from, to]: [u32; 2]) -> Result<(), NotSimple> {
        self.update_cut();
        let place = self.place_of(v);
        let (lower, upper) = (self.cut.before(place).ok_or(NotSimple)?, self.intervals.len() as u32);
        let Interval { above, high, last, .. } = self.intervals[lower as usize];
        let of_upper = Node { lower: NONE, ..self.nodes[last as usize] };
        let Node { upper: onward, edge, .. } = of_upper;
        let twin = self.add_node(of_upper);
        self.nodes[last as usize].upper = NONE;
        self.link(twin, onward, edge);
        let line = [v, to].map(|v| self.points[v as usize]);
        let high_of_upper = if onward == NONE { twin } else { high };
        self.lines.push(line);
        self.intervals.push(Interval { above, low: twin, high: high_of_upper, last: twin });
        let interval = &mut self.intervals[lower as usize];
        (interval.above, interval.high) = (from, last);
        self.bounded[from as usize] = lower;
        self.bounded[above as usize] = upper;
        self.bounded[v as usize] = upper;
        self.cut.insert(place, upper, self.order.height(line[0]));
        let diagonal = self.mesh.add_edge();
        self.extend_high(lower, v, diagonal);
        self.extend_low(upper, v, diagonal);
        Ok(())
    }

    /// Joins two intervals that meet at a vertex which points to the right, into the region.
    fn join(&mut self, under: u32, over: u32, v: u32) {
        let point = self.points[v as usize];
        let Interval { above, low, high, .. } = self.intervals[over as usize];
        let (lower, lower_edge) = self.cut_high(self.intervals[under as usize].high, (v, point), BORDER);
        let (upper, edge) = self.cut_low(low, (v, point), BORDER);
        let joint = self.add_node(Node { point, vertex: v, lower, upper, edge });
        self.link(lower, joint, lower_edge);
        self.nodes[upper as usize].lower = joint;
        let interval = &mut self.intervals[under as usize];
        (interval.above, interval.high, interval.last) = (above, high, joint);
        self.bounded[above as usize] = under;
        self.intervals[over as usize].low = NONE;
    }

    /// Cuts off all triangles that are left in an interval that ends at `v`.
    fn finish(&mut self, interval: u32, v: u32) -> Result<(), NotSimple> {
        let low = self.intervals[interval as usize].low;
        let (last, _) = self.cut_low(low, (v, self.points[v as usize]), BORDER);
        self.intervals[interval as usize].low = NONE;
        if self.nodes[last as usize].upper == NONE { Ok(()) } else { Err(NotSimple) }
    }

    /// Appends `v` below a chain, after it has cut off what triangles it can. `edge` leads from the lowest node to `v`.
    #[inline(always)]
    fn extend_low(&mut self, interval: u32, v: u32, edge: u32) {
        let point = self.points[v as usize];
        let (low, edge) = self.cut_low(self.intervals[interval as usize].low, (v, point), edge);
        let node = self.add_node(Node { point, vertex: v, lower: NONE, upper: low, edge });
        self.nodes[low as usize].lower = node;
        let interval = &mut self.intervals[interval as usize];
        (interval.low, interval.last) = (node, node);
    }

    /// Cuts off the triangles between `v` and a chain from its lowest node on. Returns the lowest node that is left and
    /// its edge to `v`.
    #[inline(always)]
    fn cut_low(&mut self, mut low: u32, (v, point): (u32, DVec2), mut edge: u32) -> (u32, u32) {
        let mut b = self.nodes[low as usize];
        while b.upper != NONE {
            let a = self.nodes[b.upper as usize];
            if orient2d(a.point, b.point, point) <= 0.0 {
                break;
            }
            edge = self.mesh.add([a.vertex, b.vertex, v], [b.edge, edge]);
            (low, b) = (b.upper, a);
        }
        (low, edge)
    }

    /// Appends `v` above a chain, as [`Self::extend_low`] does below.
    #[inline(always)]
    fn extend_high(&mut self, interval: u32, v: u32, edge: u32) {
        let point = self.points[v as usize];
        let (high, edge) = self.cut_high(self.intervals[interval as usize].high, (v, point), edge);
        let node = self.add_node(Node { point, vertex: v, lower: high, upper: NONE, edge: BORDER });
        self.link(high, node, edge);
        let interval = &mut self.intervals[interval as usize];
        (interval.high, interval.last) = (node, node);
    }

    /// Cuts off the triangles between `v` and a chain from its highest node on, as [`Self::cut_low`] does.
    #[inline(always)]
    fn cut_high(&mut self, mut high: u32, (v, point): (u32, DVec2), mut edge: u32) -> (u32, u32) {
        let mut b = self.nodes[high as usize];
        while b.lower != NONE {
            let a = self.nodes[b.lower as usize];
            if orient2d(point, b.point, a.point) <= 0.0 {
                break;
            }
            edge = self.mesh.add([v, b.vertex, a.vertex], [edge, a.edge]);
            (high, b) = (b.lower, a);
        }
        (high, edge)
    }

    fn add_node(&mut self, node: Node) -> u32 {
        self.nodes.push(node);
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

/// The side of a line on which another one starts, positive on the left; on which it ends, if it starts on the line.
fn side([from, to]: [DVec2; 2], [start, end]: [DVec2; 2]) -> f64 {
    let turn = orient2d(from, to, start);
    if turn == 0.0 { orient2d(from, to, end) } else { turn }
}

#[cfg(test)]
pub(crate) use tests::{prove, rounds};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;
    use std::f64::consts::TAU;

    /// Wavy loops around centres, each with a number of corners and a radius; clockwise where the number is negative.
    pub(crate) fn rounds(loops: &[(f64, f64, i32, f64)]) -> (Vec<DVec2>, Vec<u32>) {
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

    /// Proves that the boundary of triangles is the loops and that all are positive.
    pub(crate) fn prove(points: &[DVec2], starts: &[u32], triangles: &[[u32; 3]]) {
        let mut sides: Vec<[u32; 2]> = Vec::new();
        for (k, &start) in starts.iter().enumerate() {
            let end = starts.get(k + 1).map_or(points.len() as u32, |&end| end);
            sides.extend((start..end).map(|v| [if v + 1 == end { start } else { v + 1 }, v]));
        }
        for &[a, b, c] in triangles {
            assert!(orient2d(points[a as usize], points[b as usize], points[c as usize]) > 0.0);
            sides.extend([[a, b], [b, c], [c, a]]);
        }
        let mut reverses: Vec<_> = sides.iter().map(|&[a, b]| [b, a]).collect();
        sides.sort_unstable();
        reverses.sort_unstable();
        assert!(sides == reverses, "each side has its reverse");
    }

    /// Sweeps, and proves the triangles.
    fn sweep(points: &[DVec2], starts: &[u32]) -> Result<usize, NotSimple> {
        let mut sweep = Sweep::default();
        let ids: Vec<u32> = (0..points.len() as u32).collect();
        let triangles: Vec<_> = sweep.triangulate(points, &ids, starts)?.triangles().collect();
        prove(points, starts, &triangles);
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
        // Squares with corners along their sides: many vertices lie about on a line, and the line meets them at about
        // one place.
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
        // Along the line, but for rounding, or along the box.
        for lean in [SWEEPS[0].0, 0.0] {
            let along_line = |points: &[DVec2]| points.iter().map(|p| *p - DVec2::X * lean * p.y).collect::<Vec<_>>();
            assert_eq!(sweep(&along_line(&points), &[0, 24]).ok(), Some(48));
            // Teeth that end in one column. The line meets all in a few steps if the comb is wide, else one after the
            // other.
            for (back, count) in [(300.0, 40), (3.0, 40), (300.0, 600)] {
                let teeth = (0..=count).map(|k| DVec2::new(f64::from(k % 2), f64::from(count - k)));
                let ends = [DVec2::new(back, 0.0), DVec2::new(back, f64::from(count))];
                let comb = along_line(&ends.into_iter().chain(teeth).collect::<Vec<_>>());
                let turned: Vec<_> = comb.iter().map(|p| p.perp()).collect();
                let triangles = count as usize + 1;
                assert_eq!([comb, turned].map(|comb| sweep(&comb, &[0]).ok()), [Some(triangles); 2]);
            }
        }
        // Teeth that end exactly along the line, which meets all at once: their heights are powers of two.
        let tooth = |k: u32| {
            let height = if k.is_multiple_of(2) { f64::from(1 << (k / 2)) } else { 1.5 * f64::from(1 << (k / 2)) };
            DVec2::new(f64::from(k % 2) * height - SWEEPS[0].0 * height, height)
        };
        let ends = [DVec2::new(9e4, 0.0), DVec2::new(9e4, 5000.0)];
        let comb: Vec<_> = ends.into_iter().chain((0..=24).rev().map(tooth)).collect();
        assert_eq!(sweep(&comb, &[0]).ok(), Some(25));
    }

    #[test]
    fn a_split_after_intervals_that_began_apart() {
        // Two strips, each with a hole. The line of the steep one, which starts last, is below the other's start.
        let strip = |from: DVec2, slope: f64| {
            [(0.0, 0.0), (20.0, 0.0), (20.0, 1.0), (0.0, 1.0)].map(|(x, y)| from + DVec2::new(x, y + slope * x))
        };
        let hole = |from: DVec2, slope: f64| {
            [0.8, 0.2, 0.5].map(|y| {
                let x = if y == 0.5 { 8.0 } else { 9.0 };
                from + DVec2::new(x, y + slope * x)
            })
        };
        for strips in [[(1.0, 5.0, 0.1), (7.0, 7.0, 1.0)], [(1.0, -5.0, -0.1), (7.0, -7.0, -1.0)]] {
            let mut points = Vec::new();
            for (x, y, slope) in strips {
                points.extend(strip(DVec2::new(x, y), slope));
            }
            let mut starts = vec![0, 4];
            for (x, y, slope) in strips {
                starts.push(points.len() as u32);
                points.extend(hole(DVec2::new(x, y), slope));
            }
            assert_eq!(sweep(&points, &starts).ok(), Some(2 * 7));
        }
    }

    #[test]
    fn a_split_after_intervals_that_begin_where_others_do() {
        // A region whose first corner is a corner of another one, or lies on its border; and a hole in the upper one.
        let touching = [
            [vec![(0.0, 0.0), (20.0, 2.0), (20.0, 8.0)], vec![(0.0, 0.0), (20.0, -8.0), (20.0, -2.0)]],
            [vec![(0.0, 0.0), (5.0, 0.0), (20.0, 3.0), (20.0, 8.0)], vec![(5.0, 0.0), (20.0, -8.0), (20.0, -2.0)]],
            [vec![(0.0, 0.0), (20.0, 0.0), (20.0, 8.0)], vec![(5.0, 0.0), (20.0, -8.0), (20.0, -2.0)]],
        ];
        let hole = vec![(10.0, 3.0), (13.0, 4.0), (13.0, 3.0)];
        for ([upper, lower], up) in touching.iter().flat_map(|loops| [(loops, 1.0), (loops, -1.0)]) {
            for loops in [[upper, lower, &hole], [lower, upper, &hole], [&hole, lower, upper]] {
                let (mut points, mut starts) = (Vec::new(), Vec::new());
                for corners in loops {
                    let start = points.len();
                    starts.push(start as u32);
                    points.extend(corners.iter().map(|&(x, y)| DVec2::new(x, up * y)));
                    if up < 0.0 {
                        points[start..].reverse();
                    }
                }
                let triangles = upper.len() + lower.len() + hole.len() - 2;
                assert_eq!(sweep(&points, &starts).ok(), Some(triangles), "{points:?}");
            }
        }
    }

    #[test]
    fn holes_with_many_teeth_in_any_direction() {
        // Teeth of random depths to the left and to the right: the line moves one way or the other.
        let mut draw = SplitMix(5);
        for (left, right) in [(300, 300), (400, 0), (0, 400), (400, 40), (40, 400)] {
            let mut side = |teeth: u32, sign: f64| {
                let corner = |k: u32| {
                    let x = if k.is_multiple_of(2) { 1.0 } else { 2.0 + 5.0 * draw.unit() };
                    DVec2::new(sign * x, 8.0 * f64::from(k) / f64::from(2 * teeth).max(1.0) - 4.0)
                };
                (0..=2 * teeth).map(corner).chain((teeth == 0).then(|| DVec2::new(sign, 4.0))).collect::<Vec<_>>()
            };
            let (up, down) = (side(left, -1.0), side(right, 1.0));
            let corners = [(-9.0, -5.0), (9.0, -5.0), (9.0, 5.0), (-9.0, 5.0)].map(DVec2::from);
            let mut points: Vec<_> = corners.into_iter().chain(up).chain(down.into_iter().rev()).collect();
            for _ in 0..4 {
                assert_eq!(sweep(&points, &[0, 4]).ok(), Some(points.len()), "{left}, {right}");
                points.iter_mut().for_each(|p| *p = p.perp());
            }
        }
    }

    #[test]
    fn corners_closer_than_the_steps_of_the_order() {
        let hole = |x: f64| (x, 0.0, -24, 1e-12);
        let (points, starts) = rounds(&[(0.0, 0.0, 9, 1.0), hole(0.0), hole(0.1), hole(1e-10)]);
        assert_eq!(sweep(&points, &starts).ok(), Some(7 + 3 * 26));
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
