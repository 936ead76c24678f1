//! A closed polygon and a point -> whether the polygon winds around it. Polygons with many sides use a tree.

use super::uv_loop::{crossed, winding_about};
use crate::math::boxes::{BoxTree, around};
use glam::DVec2;
use std::cell::{Cell, OnceCell};

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
}
