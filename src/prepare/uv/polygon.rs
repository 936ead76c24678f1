//! Closed polygons and points -> how often they wind around them; a tile's loops as polygons, for estimates that need a
//! few per cent, not exact signs.

use super::uv_curve::{SAME_SHARE, UvCurve, UvSample};
use crate::math::boxes::{BoxTree, around};
use crate::prepare::surface::decompose::BezierPatches;
use glam::DVec2;
use std::cell::{Cell, OnceCell};

/// Winding number of a closed polygon about `q`.
pub(crate) fn winding_about(p: &[DVec2], q: DVec2) -> i32 {
    let Some(&last) = p.last() else { return 0 };
    let (mut before, mut below, mut winding) = (last, last.y <= q.y, 0);
    for &corner in p {
        let is_below = corner.y <= q.y;
        if is_below != below {
            winding += crossed([before, corner], q);
        }
        (before, below) = (corner, is_below);
    }
    winding
}

/// The contribution of a side to the winding number about `q`: 1 if it passes upwards to the right of `q`, -1 if
/// downwards.
fn crossed([a, b]: [DVec2; 2], q: DVec2) -> i32 {
    if (a.y <= q.y) == (b.y <= q.y) {
        return 0;
    }
    let left = (b - a).perp_dot(q - a);
    if a.y <= q.y { i32::from(left > 0.0) } else { -i32::from(left < 0.0) }
}

/// Polygons with at most this many sides are scanned without a tree.
const FEW: usize = 64;

/// Queries answered by a scan. A tree pays from some sixty on.
const SCANS: u32 = 32;

/// A closed polygon.
pub(crate) struct Polygon {
    pub(crate) points: Vec<DVec2>,
    /// Lower and upper corner of its box.
    pub(crate) bounds: [DVec2; 2],
    /// Boxes of the sides, built by the first query that needs them.
    tree: OnceCell<BoxTree<DVec2>>,
    /// Queries within the box that were scanned.
    scans: Cell<u32>,
}

impl Polygon {
    pub(crate) fn new(points: Vec<DVec2>) -> Self {
        let bounds = around(points.iter().copied());
        Self { points, bounds, tree: OnceCell::new(), scans: Cell::new(0) }
    }

    /// Whether the winding number about `q` is not 0.
    ///
    /// Cost: linear for up to 64 sides, and for the first 32 queries. Beyond that, the sides that a ray to the right
    /// meets, plus O(n log n) once.
    pub(crate) fn holds(&self, q: DVec2) -> bool {
        if q.cmplt(self.bounds[0]).any() || q.cmpgt(self.bounds[1]).any() {
            return false;
        }
        let (n, scans) = (self.points.len(), self.scans.get());
        if n <= FEW || scans < SCANS {
            self.scans.set(SCANS.min(scans + 1));
            return winding_about(&self.points, q) != 0;
        }
        let side = |k: usize| [self.points[k], self.points[(k + 1) % n]];
        let sides = || (0..n).map(side).map(|[a, b]| [a.min(b), a.max(b)]).collect::<Vec<_>>();
        let mut winding = 0;
        let tree = self.tree.get_or_init(|| BoxTree::new(&sides()));
        tree.meeting([q, DVec2::new(f64::INFINITY, q.y)], |k| winding += crossed(side(k), q));
        winding != 0
    }
}

/// Appends points of a pcurve over `range`, without the last: twice as many as it has pieces, at most `most`; one for
/// an isoparametric line and, if `flat`, for any straight line.
pub(crate) fn points_along(uv: &UvCurve, range: (f64, f64), most: usize, flat: bool, out: &mut Vec<DVec2>) {
    let (from, to) = range;
    let n = match uv {
        UvCurve::Hermite(samples) if flat && is_straight(samples) => 1,
        UvCurve::Hermite(samples) => (2 * (samples.len() - 1)).min(most),
        UvCurve::Iso { .. } => 1,
    };
    let mut hint = 0;
    out.extend((0..n).map(|k| uv.point(from + (to - from) * k as f64 / n as f64, &mut hint)));
}

/// Whether there is one piece, and its slopes have the direction of its chord, to [`SAME_SHARE`].
fn is_straight(samples: &[UvSample]) -> bool {
    let [a, b] = samples else { return false };
    let chord = b.uv - a.uv;
    chord != DVec2::ZERO && [a.d, b.d].iter().all(|d| chord.perp_dot(*d).abs() <= SAME_SHARE * chord.dot(*d))
}

/// The area of closed polygons, each point as often as they wind around it.
pub(crate) fn area(loops: &[Vec<DVec2>]) -> f64 {
    let fan = |l: &[DVec2]| l.windows(2).map(|w| (w[0] - l[0]).perp_dot(w[1] - l[0])).sum::<f64>();
    loops.iter().map(|l| 0.5 * fan(l)).sum()
}

/// The region of a tile, as polygons.
pub(crate) struct TileRegion<'a> {
    pub(crate) patches: &'a BezierPatches,
    pub(crate) min: DVec2,
    pub(crate) max: DVec2,
    pub(crate) loops: Vec<Vec<DVec2>>,
}

impl TileRegion<'_> {
    /// The total winding number of the loops about `uv`. Meshes cover a point as often, reversed where it is negative.
    pub(crate) fn winding(&self, uv: DVec2) -> i32 {
        self.loops.iter().map(|l| winding_about(l, uv)).sum()
    }

    /// Cell size and cell centres of an even lattice over the tile with `per_piece` cells per Bézier piece and
    /// direction (at most 16 pieces count). Centres may lie outside the loops.
    pub(crate) fn lattice(&self, per_piece: usize) -> (DVec2, impl Iterator<Item = DVec2> + '_) {
        let count = |breaks: &[f64], a: f64, b: f64| {
            per_piece * breaks.windows(2).filter(|w| w[1] > a && w[0] < b).count().clamp(1, 16)
        };
        let nu = count(&self.patches.breaks_u, self.min.x, self.max.x);
        let nv = count(&self.patches.breaks_v, self.min.y, self.max.y);
        let step = (self.max - self.min) / DVec2::new(nu as f64, nv as f64);
        let middles = (0..nu)
            .flat_map(move |i| (0..nv).map(move |j| self.min + step * DVec2::new(i as f64 + 0.5, j as f64 + 0.5)));
        (step, middles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;

    #[test]
    fn the_tree_gives_the_winding_of_a_linear_scan() {
        let mut random = SplitMix(3);
        let mut unit = || random.unit();
        for count in [3, 64, 65, 1000] {
            // Self-crossing, with corners on a grid: many have the same y as others and as the points.
            let mut corner = || DVec2::new((40.0 * unit()).floor(), (40.0 * unit()).floor());
            let points: Vec<DVec2> = (0..count).map(|_| corner()).collect();
            let polygon = Polygon::new(points.clone());
            for _ in 0..500 {
                let q = corner() + DVec2::new(0.5, 0.0);
                assert_eq!(polygon.holds(q), winding_about(&points, q) != 0, "{count} corners, {q}");
            }
            assert!(polygon.scans.get() <= SCANS, "{count} corners");
        }
    }

    #[test]
    fn areas_count_as_often_as_loops_wind_around_them() {
        let square = |side: f64| vec![DVec2::ZERO, DVec2::X * side, DVec2::splat(side), DVec2::Y * side];
        let hole: Vec<DVec2> = square(2.0).into_iter().rev().map(|p| p + DVec2::ONE).collect();
        for (loops, expected) in [
            (vec![square(4.0), hole], 12.0),
            (vec![square(4.0), square(2.0)], 20.0),
            (vec![Vec::new(), vec![DVec2::ONE]], 0.0),
        ] {
            assert_eq!(area(&loops), expected);
        }
    }
}
