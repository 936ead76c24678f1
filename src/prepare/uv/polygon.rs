//! A closed polygon and a point -> whether it winds around it, with a tree of its sides where there are many.

use super::uv_loop::{crossed, winding_about};
use crate::math::box_tree::BoxTree;
use glam::DVec2;
use std::cell::OnceCell;

/// Sides that are looked at one by one.
const FEW: usize = 64;

/// A closed polygon.
pub(crate) struct Polygon {
    pub(crate) points: Vec<DVec2>,
    /// Lower and upper corner of its box.
    pub(crate) bounds: [DVec2; 2],
    /// Of its sides, once a point asks; a few are looked at one by one.
    tree: OnceCell<BoxTree>,
}

impl Polygon {
    pub(crate) fn new(points: Vec<DVec2>) -> Self {
        let bounds = points.iter().fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |b, q| [b[0].min(*q), b[1].max(*q)]);
        Self { points, bounds, tree: OnceCell::new() }
    }

    /// Whether it winds around a point. Cost: its sides, or if they are many those to the right of the point and level with it,
    /// after n log n for the first.
    pub(crate) fn holds(&self, q: DVec2) -> bool {
        if q.cmplt(self.bounds[0]).any() || q.cmpgt(self.bounds[1]).any() {
            return false;
        }
        let n = self.points.len();
        if n <= FEW {
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

    #[test]
    fn holds_what_all_of_its_sides_wind_around() {
        let mut state = 3_u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for count in [3, 64, 65, 1000] {
            // Crossing itself at will, with corners on a grid: many level with others, and with the points.
            let mut corner = || DVec2::new((40.0 * unit()).floor(), (40.0 * unit()).floor());
            let points: Vec<DVec2> = (0..count).map(|_| corner()).collect();
            let polygon = Polygon::new(points.clone());
            for _ in 0..500 {
                let q = corner() + DVec2::new(0.5, 0.0);
                assert_eq!(polygon.holds(q), winding_about(&points, q) != 0, "{count} corners, {q}");
            }
        }
    }
}
