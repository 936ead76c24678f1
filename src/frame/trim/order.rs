//! Loops -> the order in which a sweep line meets their vertices, and the way that it moves.

use crate::math::lanes::{larger, smaller};
use crate::math::predicates::across;
use glam::DVec2;
use std::ops::RangeInclusive;

/// Where vertices are along the way of a line, and where points are on the line.
#[derive(Default)]
pub(crate) struct Order {
    /// By rank, which is the order in which the line meets the vertices: the vertex in its low half, and its coordinate
    /// along the way of the line in the other.
    keys: Vec<u64>,
    /// By vertex, its rank.
    ranks: Vec<u32>,
    /// The direction in which heights grow: along the line, or across the mean slope of segments if there are many.
    up: DVec2,
}

/// Magnitudes of coordinates, other than 0, with which [`across`] neither overflows nor underflows.
const SAFE: RangeInclusive<f64> = 1e-140..=1e140;

/// Fewest vertices for which a look at all loops decides which way the line moves, and what heights are.
const FEW: usize = 500;

/// The line moves the other way if that saves more than a split per this many vertices.
const PER_SPLIT: usize = 16;

impl Order {
    /// Puts the vertices of loops into the order in which the line meets them. `loops` are ranges of `ids`, each of at
    /// least three.
    ///
    /// The line moves along the longer side of their box: the triangles that it leaves are wider that way, and fewer of
    /// them are flipped. It may lean: it meets a point later by `lean` times the point's place along `up`. The order is
    /// exact where magnitudes of coordinates are 0 or [`SAFE`]. Elsewhere places are rounded.
    pub(crate) fn sort(
        &mut self,
        points: &[DVec2],
        ids: &[u32],
        loops: impl Iterator<Item = (u32, u32)> + Clone,
        lean: f64,
    ) {
        let point = |v: u32| points[ids[v as usize] as usize];
        let bounds = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = (0..ids.len() as u32).map(point).fold(bounds, |(low, high), p| {
            let axis = |k: usize| (smaller(p[k], low[k]), larger(p[k], high[k]));
            let [x, y] = [0, 1].map(axis);
            (DVec2::new(x.0, y.0), DVec2::new(x.1, y.1))
        });
        // Turned by a right angle if it is tall.
        let size = high - low;
        let right = if size.y > size.x { DVec2::Y } else { DVec2::X };
        let up = right.perp();
        self.up = up - right * lean;
        let way = right + up * lean;
        // Differences from a corner of the box are rounded to a share of its size, wherever it is: places are off by
        // less than 3e-6 of a step.
        let most = (way * size).max(DVec2::ZERO).element_sum();
        let least = (way * size).min(DVec2::ZERO).element_sum();
        let steps = f64::from(u32::MAX) / (most - least);
        self.keys.clear();
        for (start, end) in loops.clone() {
            let key = |v: u32| u64::from(((way.dot(point(v) - low) - least) * steps) as u32) << 32 | u64::from(v);
            self.keys.extend((start..end).map(key));
        }
        self.keys.sort_unstable();
        // Vertices of equal and of consecutive steps are sorted exactly: rounding can move a vertex into the next step.
        for near in self.keys.chunk_by_mut(|a, b| (b >> 32) - (a >> 32) < 2).filter(|near| near.len() > 1) {
            let is_safe = |x: f64| x == 0.0 || SAFE.contains(&x.abs());
            let safe = near.iter().map(|&key| point(key as u32)).all(|p| is_safe(p.x) && is_safe(p.y));
            near.sort_unstable_by(|&a, &b| {
                let [p, q] = [a, b].map(|key| point(key as u32));
                // Signs that are not exact contradict each other, and then a sort may panic.
                let along =
                    if safe { across(q, p, self.up).total_cmp(&0.0) } else { way.dot(p).total_cmp(&way.dot(q)) };
                along.then_with(|| up.dot(p).total_cmp(&up.dot(q))).then(a.cmp(&b))
            });
        }
        self.ranks.resize(ids.len(), 0);
        self.number();
        if self.keys.len() >= FEW {
            self.look_ahead(point, way, loops);
        }
    }

    /// Ranks the vertices by the order of their keys.
    fn number(&mut self) {
        for (&key, rank) in self.keys.iter().zip(0..) {
            self.ranks[key as u32 as usize] = rank;
        }
    }

    /// Makes the line move the other way if many splits, which need a search, are joins then. Turns `up` across the
    /// segments: both ends of a segment have one height where all have one slope.
    fn look_ahead(&mut self, point: impl Fn(u32) -> DVec2, right: DVec2, loops: impl Iterator<Item = (u32, u32)>) {
        // How many more splits than joins there are, at least. A vertex that points to the left splits an interval or
        // starts one; an outline has one start more than joins, and a hole one less.
        let mut surplus = 0;
        // Of squares of widths, and of widths times heights: the slope of least squares is their ratio.
        let mut sums = DVec2::ZERO;
        for (start, end) in loops {
            let vertex = |v: u32| (self.ranks[v as usize], point(v));
            let (mut before, mut at) = (vertex(end - 2), vertex(end - 1));
            surplus -= 1;
            for after in (start..end).map(vertex) {
                let step = after.1 - at.1;
                // Rounded: it is a guess. Without branches, which nobody foresees.
                let turn = (at.1 - before.1).perp_dot(step);
                let is_left = (at.0 < before.0) & (at.0 < after.0);
                surplus += i64::from(is_left) * if turn < 0.0 { 1 } else { -1 };
                sums += right.dot(step) * DVec2::new(right.dot(step), self.up.dot(step));
                (before, at) = (at, after);
            }
        }
        self.up -= right * (sums.y / sums.x);
        if surplus > (self.keys.len() / PER_SPLIT) as i64 {
            self.up = -self.up;
            self.keys.reverse();
            self.number();
        }
    }

    /// The number of vertices.
    pub(crate) fn len(&self) -> usize {
        self.keys.len()
    }

    /// The vertex of a rank.
    pub(crate) fn vertex(&self, rank: u32) -> u32 {
        self.keys[rank as usize] as u32
    }

    /// By vertex, its rank.
    pub(crate) fn ranks(&self) -> &[u32] {
        &self.ranks
    }

    /// About where a segment that starts from a point is on the line, from below.
    pub(crate) fn height(&self, point: DVec2) -> f32 {
        self.up.dot(point) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::trim::sweep::SWEEPS;
    use crate::sequence::random::SplitMix;

    /// A comb of this many teeth that point to the left and rise; it is wider than tall.
    fn comb(teeth: u32, slope: f64) -> Vec<DVec2> {
        let corner = |k: u32| {
            let x = if k.is_multiple_of(2) { f64::from(k * 7 % 11) } else { 20.0 };
            DVec2::new(x, 4.0 - 4.0 * f64::from(k) / f64::from(2 * teeth) + slope * x)
        };
        let back = [0.0, 4.0].map(|y| DVec2::new(30.0, y + slope * 30.0));
        (0..=2 * teeth).map(corner).chain(back).collect()
    }

    /// The order of one loop, and the points in it.
    fn ordered(points: &[DVec2]) -> (Order, Vec<DVec2>) {
        leaning(points, 0.0)
    }

    fn leaning(points: &[DVec2], lean: f64) -> (Order, Vec<DVec2>) {
        let mut order = Order::default();
        let ids: Vec<u32> = (0..points.len() as u32).collect();
        order.sort(points, &ids, std::iter::once((0, points.len() as u32)), lean);
        assert!(order.ranks().iter().zip(0..).all(|(&rank, v)| order.vertex(rank) == v));
        let along = (0..points.len() as u32).map(|rank| points[order.vertex(rank) as usize]).collect();
        (order, along)
    }

    #[test]
    fn the_line_moves_so_that_teeth_are_joined() {
        let outline = comb(300, 0.0);
        let hole: Vec<_> = outline.iter().rev().copied().collect();
        // Where each tooth starts an interval, and where it would split one.
        for (points, is_reversed) in [(&outline, false), (&hole, true)] {
            for is_tall in [false, true] {
                let points: Vec<_> = points.iter().map(|&p| if is_tall { p.perp() } else { p }).collect();
                let (order, along) = ordered(&points);
                let [right, up] = if is_tall { [DVec2::Y, DVec2::NEG_X] } else { [DVec2::X, DVec2::Y] };
                let place = |p: &DVec2| (right.dot(*p), up.dot(*p));
                let ascends = along.is_sorted_by_key(place);
                let descends = along.iter().rev().is_sorted_by_key(place);
                assert_eq!([ascends, descends], [!is_reversed, is_reversed], "{is_tall}");
                assert_eq!(order.height(up) < 0.0, is_reversed, "{is_tall}");
            }
        }
        // Few are always met from the left, and so is a comb whose teeth are few among its corners.
        let few: Vec<_> = comb(200, 0.0).into_iter().rev().collect();
        let mut smooth: Vec<_> = comb(20, 0.0).into_iter().rev().collect();
        let side = |k: u32| DVec2::new(30.0, f64::from(600 - k) / 150.0);
        smooth.splice(1..1, (1..600).map(side));
        for points in [few, smooth] {
            assert!(ordered(&points).1.is_sorted_by_key(|p| (p.x, p.y)));
        }
    }

    #[test]
    fn heights_follow_segments_of_one_slope() {
        for (slope, lean) in
            [-0.5, 0.0, 0.3].into_iter().flat_map(|slope| [0.0, SWEEPS[0].0, SWEEPS[1].0].map(|lean| (slope, lean)))
        {
            let points = comb(300, slope);
            let (order, _) = leaning(&points, lean);
            let teeth = points[..601].windows(2).map(|ends| order.height(ends[0]) - order.height(ends[1]));
            let most = teeth.fold(0.0, |most: f32, rise| most.max(rise.abs()));
            assert!(most < 0.02, "{slope}, {lean}: {most}");
        }
    }

    #[test]
    fn vertices_of_one_step_are_in_exact_order() {
        // Closer than a share of 2^-32 of the box, in falling order.
        let near = (0..40).map(|k| DVec2::new(1.0 - f64::from(k / 4) * 1e-13, f64::from(k * 7 % 40)));
        let points: Vec<_> = [DVec2::ZERO, DVec2::new(100.0, 0.0)].into_iter().chain(near).collect();
        assert!(ordered(&points).1.is_sorted_by_key(|p| (p.x, p.y)));
    }

    /// Products of such coordinates are rounded to units of 2^-1074, or infinite. An order by their signs has cycles.
    #[test]
    fn coordinates_at_the_ends_of_their_range_have_some_order() {
        let mut draw = SplitMix(11);
        for (size, ends) in [(5e-324, 0.0), (1e-318, 0.0), (5e-324, 1.0), (1e306, 0.0), (5e306, 0.0), (f64::NAN, 1.0)] {
            let near = (0..2000).map(|_| DVec2::from([(); 2].map(|()| (draw.range(-30.0, 30.0)).round() * size)));
            let points: Vec<_> = near.chain([DVec2::splat(ends), DVec2::new(-ends, ends)]).collect();
            for (lean, _) in SWEEPS {
                assert_eq!(leaning(&points, lean).1.len(), points.len());
            }
        }
    }

    #[test]
    fn a_line_that_leans_meets_points_in_exact_order() {
        // Whole units of 2^-54. Places along the line are too long for an `f64`, and many differ by their last bits
        // only, or not at all.
        const UNITS: f64 = (1_u64 << 54) as f64;
        let mut draw = SplitMix(9);
        for lean in SWEEPS.iter().flat_map(|&(lean, _)| [lean, -lean, 0.25]) {
            for is_tall in [false, true] {
                // By eights where a step ends. They are far from the corner of the box and near zero: rounding puts
                // points on both sides of it.
                let step = (100.0 + 2.0 * f64::abs(lean)) / f64::from(u32::MAX);
                let end = |k: u32| f64::from(k / 8 * 100_000 + 2_850_000_000) * step + f64::min(2.0 * lean, 0.0) - 64.0;
                let near = (0..1600).map(|k| {
                    let [part, low, tiny] = [(); 3].map(|()| f64::from((draw.unit() * 8.0) as u32));
                    let y = (low + 1.0) / 8.0 + tiny / UNITS;
                    DVec2::new(end(k) - lean * y + (part - 4.0) * f64::EPSILON * 16.0, y)
                });
                let ends = [DVec2::new(-64.0, 0.0), DVec2::new(36.0, 2.0)];
                let wide = ends.into_iter().chain(near);
                let points: Vec<_> = wide.map(|p| if is_tall { p.perp() } else { p }).collect();
                let (_, along) = leaning(&points, lean);
                let place = |p: &DVec2| {
                    let [x, y] = if is_tall { [p.y, -p.x] } else { [p.x, p.y] }.map(|x| (x * UNITS) as i128);
                    (((x << 54) + (lean * UNITS) as i128 * y), y)
                };
                let places: Vec<_> = along.iter().map(place).collect();
                let first_is_least = places[0] < places[places.len() - 1];
                let wrong = places.windows(2).find(|two| two[0] != two[1] && (two[0] < two[1]) != first_is_least);
                assert_eq!(wrong, None, "{lean}, {is_tall}");
            }
        }
    }
}
