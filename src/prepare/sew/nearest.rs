//! Points along a curve -> the one nearest to a query point, by boxes around runs of points and around runs of boxes.
//! Runs of points along a curve are compact, so no sorting is needed. The search is that of R-trees (N. Roussopoulos,
//! S. Kelley, F. Vincent, *Nearest neighbor queries*, 1995): nearest box first, none further than the best point.

use crate::math::boxes::{Aabb, Corner, around};
use glam::DVec3;

/// Points or boxes per run.
const RUN: usize = 8;

/// Boxes around runs of points, around runs of these boxes, and so on up to one box.
pub(crate) struct Runs(Vec<Vec<Aabb>>);

impl Runs {
    pub(crate) fn new(points: &[(f64, DVec3)]) -> Self {
        let join = |of: &[Aabb]| of.iter().fold(DVec3::NOTHING, |[low, high], b| [low.min(b[0]), high.max(b[1])]);
        let mut levels: Vec<Vec<Aabb>> = vec![points.chunks(RUN).map(|run| around(run.iter().map(|p| p.1))).collect()];
        while let Some(last) = levels.last().filter(|last| last.len() > 1) {
            let next = last.chunks(RUN).map(join).collect();
            levels.push(next);
        }
        Self(levels)
    }

    /// Index of the nearest of `points`, from which this was made; the first of those equally near.
    ///
    /// Cost: about logarithmic in their number, unless the curve runs around `p`.
    pub(crate) fn nearest(&self, points: &[(f64, DVec3)], p: DVec3) -> usize {
        let mut best = (f64::INFINITY, 0);
        // All of a run are opened at once, mostly one run per level.
        let mut open = Vec::with_capacity(RUN * self.0.len());
        open.push((0.0, self.0.len() - 1, 0));
        while let Some((off, level, run)) = open.pop() {
            if off > best.0 {
                continue;
            }
            let of_run = RUN * run..;
            if level == 0 {
                for (k, point) in of_run.zip(points.iter().skip(RUN * run).take(RUN)) {
                    let off = point.1.distance_squared(p);
                    if off < best.0 || off == best.0 && k < best.1 {
                        best = (off, k);
                    }
                }
                continue;
            }
            let first = open.len();
            let below = self.0[level - 1].iter().skip(RUN * run).take(RUN);
            open.extend(of_run.zip(below).map(|(k, b)| (p.distance_squared(p.clamp(b[0], b[1])), level - 1, k)));
            // The nearest is last, so it is searched next.
            open[first..].sort_by(|a, b| b.0.total_cmp(&a.0));
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_is_that_of_a_linear_search() {
        for count in [1, 2, 8, 9, 65, 1000] {
            let at = |k: usize| {
                let t = k as f64 / count as f64;
                (t, DVec3::new((19.0 * t).sin(), (7.0 * t).cos(), (3.0 * t).sin()))
            };
            // Each point twice, so that there are ties.
            let points: Vec<(f64, DVec3)> = (0..count).chain(0..count).map(at).collect();
            let runs = Runs::new(&points);
            for k in 0..200 {
                let p = 1.5 * DVec3::new((0.7 * f64::from(k)).sin(), (1.9 * f64::from(k)).sin(), 0.1);
                let far = |k: &usize| points[*k].1.distance_squared(p);
                let expected = (0..points.len()).min_by(|a, b| far(a).total_cmp(&far(b)));
                assert_eq!(Some(runs.nearest(&points, p)), expected);
            }
        }
    }
}
