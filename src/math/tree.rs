//! Leaves in an order in which neighbours are near each other -> a tree over runs of them, searched from the root.

/// Children per node.
pub(super) const FAN: usize = 8;

/// A static tree. Each node contains the next [`FAN`] nodes of the level below.
#[derive(Debug)]
pub(crate) struct Tree<N> {
    /// From the leaves up to the root.
    levels: Vec<Vec<N>>,
}

impl<N> Tree<N> {
    /// `around` makes the node that contains some others. Cost: O(n).
    pub(crate) fn new(leaves: Vec<N>, around: impl Fn(&[N]) -> N) -> Self {
        let mut levels = vec![leaves];
        while let Some(below) = levels.last().filter(|level| level.len() > 1) {
            levels.push(below.chunks(FAN).map(&around).collect());
        }
        Self { levels }
    }

    /// The leaves, in the order given.
    pub(super) fn leaves(&self) -> &[N] {
        &self.levels[0]
    }

    /// Replaces a leaf, and the nodes above it.
    pub(super) fn replace(&mut self, mut place: usize, leaf: N, around: impl Fn(&[N]) -> N) {
        self.levels[0][place] = leaf;
        for level in 1..self.levels.len() {
            place /= FAN;
            let below = &self.levels[level - 1];
            self.levels[level][place] = around(&below[FAN * place..below.len().min(FAN * (place + 1))]);
        }
    }

    /// Calls `found` with the place of each leaf that passes. `passes` must be true for every node that contains one for
    /// which it is true. The order depends on the tree only.
    pub(super) fn find(&self, passes: impl Fn(&N) -> bool, mut found: impl FnMut(usize)) {
        let mut open: Vec<(usize, usize)> = Vec::new();
        let top = self.levels.len() - 1;
        open.extend((0..self.levels[top].len()).map(|node| (top, node)));
        while let Some((level, node)) = open.pop() {
            if !passes(&self.levels[level][node]) {
                continue;
            }
            if level == 0 {
                found(node);
            } else {
                let below = self.levels[level - 1].len();
                open.extend((FAN * node..below.min(FAN * (node + 1))).map(|child| (level - 1, child)));
            }
        }
    }

    /// The place of the leaf of least `distance`, the first of those with the same. `distance` of a node is at most that
    /// of any that it contains.
    ///
    /// Cost: about logarithmic in their number, unless many are about as near. The search is that of R-trees (N.
    /// Roussopoulos, S. Kelley, F. Vincent, *Nearest neighbor queries*, 1995): nearest node first, none further than the
    /// best leaf.
    pub(crate) fn nearest(&self, distance: impl Fn(&N) -> f64) -> usize {
        let mut best = (f64::INFINITY, 0);
        // All of a run are opened at once, mostly one run per level.
        let mut open = Vec::with_capacity(FAN * self.levels.len());
        open.push((0.0, self.levels.len() - 1, 0));
        while let Some((least, level, node)) = open.pop() {
            if level == 0 || least > best.0 {
                continue;
            }
            let first = open.len();
            for (child, of_child) in self.levels[level - 1].iter().enumerate().skip(FAN * node).take(FAN) {
                let least = distance(of_child);
                if level > 1 {
                    open.push((least, level - 1, child));
                } else if least < best.0 || least == best.0 && child < best.1 {
                    best = (least, child);
                }
            }
            // The nearest is last, so it is searched next.
            open[first..].sort_by(|a, b| b.0.total_cmp(&a.0));
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::boxes::{Aabb, around, distance_squared};
    use glam::DVec3;

    #[test]
    fn the_nearest_leaf_is_that_of_a_linear_search() {
        for count in [1, 2, 8, 9, 65, 1000] {
            let at = |k: usize| {
                let t = k as f64 / count as f64;
                DVec3::new((19.0 * t).sin(), (7.0 * t).cos(), (3.0 * t).sin())
            };
            // Each point twice, so that there are ties.
            let points: Vec<DVec3> = (0..count).chain(0..count).map(at).collect();
            let leaves: Vec<Aabb> = points.iter().map(|&p| [p, p]).collect();
            let tree = Tree::new(leaves, |of| around(of.as_flattened().iter().copied()));
            for k in 0..200 {
                let p = 1.5 * DVec3::new((0.7 * f64::from(k)).sin(), (1.9 * f64::from(k)).sin(), 0.1);
                let far = |k: &usize| points[*k].distance_squared(p);
                let expected = (0..points.len()).min_by(|a, b| far(a).total_cmp(&far(b)));
                assert_eq!(Some(tree.nearest(|b| distance_squared(*b, p))), expected);
            }
        }
    }
}
