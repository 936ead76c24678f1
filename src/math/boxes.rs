//! Boxes in the plane and in space, and static trees that are searched from the root: [`Tree`] of anything that can
//! contain others, [`BoxTree`] for the boxes that meet a query box.
//!
//! Boxes are packed by sort-tile-recursive (Leutenegger, Lopez & Edgington, "STR: a simple and efficient algorithm for
//! R-tree packing", ICDE 1997).

use glam::{DVec2, DVec3};
use std::ops::{Add, Index};

/// Lower and upper corner.
pub(crate) type Aabb = [DVec3; 2];

/// A point of which each coordinate has a minimum and a maximum.
pub(crate) trait Corner: Copy + Add<Output = Self> + Index<usize, Output = f64> {
    /// Number of coordinates.
    const AXES: usize;
    /// The box that contains no point.
    const NOTHING: [Self; 2];
    /// The smallest box that contains both another and `self`.
    fn added(self, to: [Self; 2]) -> [Self; 2];
    /// Whether two boxes overlap or touch.
    fn meet(a: &[Self; 2], b: &[Self; 2]) -> bool;
}

macro_rules! corner {
    ($($point:ident: $axes:literal),*) => {
        $(impl Corner for $point {
            const AXES: usize = $axes;
            const NOTHING: [Self; 2] = [Self::INFINITY, Self::NEG_INFINITY];
            fn added(self, [low, high]: [Self; 2]) -> [Self; 2] {
                [low.min(self), high.max(self)]
            }
            fn meet(a: &[Self; 2], b: &[Self; 2]) -> bool {
                !(a[0].cmpgt(b[1]).any() || a[1].cmplt(b[0]).any())
            }
        })*
    };
}
corner!(DVec2: 2, DVec3: 3);

/// Lower and upper corner of the smallest box around points; `[+∞, -∞]` without any.
pub(crate) fn around<P: Corner>(points: impl IntoIterator<Item = P>) -> [P; 2] {
    points.into_iter().fold(P::NOTHING, |all, p| p.added(all))
}

/// The smallest box around two boxes.
pub(crate) fn joined(a: Aabb, b: Aabb) -> Aabb {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// The squared distance of a point from a box; 0 within.
pub(crate) fn distance_squared([low, high]: Aabb, p: DVec3) -> f64 {
    p.distance_squared(p.clamp(low, high))
}

/// Children per node.
const FAN: usize = 8;

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

    /// Calls `found` with the place of each leaf that passes. `passes` must be true for every node that contains one
    /// for which it is true. The order depends on the tree only.
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

    /// The place of the leaf of least `distance`, the first of those with the same. `distance` of a node is at most
    /// that of any that it contains.
    ///
    /// Cost: about logarithmic in their number, unless many are about as near. The search is that of R-trees (N.
    /// Roussopoulos, S. Kelley, F. Vincent, *Nearest neighbor queries*, 1995): nearest node first, none further than
    /// the best leaf.
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

/// A static tree of boxes, numbered in the order given.
pub(crate) struct BoxTree<P> {
    /// The number of each leaf.
    numbers: Vec<u32>,
    tree: Tree<[P; 2]>,
}

impl<P: Corner> BoxTree<P> {
    /// Builds the tree from lower and upper corners. Cost: O(n log n), 45 bytes per box in the plane.
    pub(crate) fn new(boxes: &[[P; 2]]) -> Self {
        let mut numbers: Vec<u32> = (0..u32::try_from(boxes.len()).unwrap_or(u32::MAX)).collect();
        tile(boxes, &mut numbers, 0);
        let leaves = numbers.iter().map(|&k| boxes[k as usize]).collect();
        Self { numbers, tree: Tree::new(leaves, |of| around(of.as_flattened().iter().copied())) }
    }

    /// Calls `found` with the number of each box that overlaps or touches `query`. The order depends on the tree only.
    pub(crate) fn meeting(&self, query: [P; 2], mut found: impl FnMut(usize)) {
        self.tree.find(|node| P::meet(node, &query), |place| found(self.numbers[place] as usize));
    }
}

/// Orders boxes by their middles: slices across `axis`, each ordered by the axes after it.
fn tile<P: Corner>(boxes: &[[P; 2]], numbers: &mut [u32], axis: usize) {
    let middle = |k: &u32| (boxes[*k as usize][0] + boxes[*k as usize][1])[axis];
    numbers.sort_unstable_by(|a, b| middle(a).total_cmp(&middle(b)));
    let nodes = numbers.len().div_ceil(FAN);
    let slices = match P::AXES - axis {
        1 => return,
        2 => (nodes as f64).sqrt(),
        _ => libm::cbrt(nodes as f64),
    };
    let slice = FAN * nodes.div_ceil(slices.ceil().max(1.0) as usize).max(1);
    numbers.chunks_mut(slice).for_each(|slice| tile(boxes, slice, axis + 1));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;

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

    /// `point`: coordinates from 0 to a size.
    fn assert_finds<P: Corner>(random: &mut SplitMix, point: impl Fn(&mut SplitMix, f64) -> P) {
        for count in [0, 1, 2, 7, 8, 9, 63, 64, 65, 1000] {
            let mut some = |size: f64| {
                let low = point(random, 1.0);
                [low, low + point(random, size)]
            };
            let mut boxes: Vec<[P; 2]> = (0..count).map(|_| some(0.1)).collect();
            // Some twice: the parts of a node then have equal middles.
            boxes.extend_from_within(..count / 2);
            let tree = BoxTree::new(&boxes);
            // Boxes, and some without an upper end.
            for query in (0..50).map(|k| some(if k % 2 == 0 { 0.4 } else { f64::INFINITY })) {
                let mut got = Vec::new();
                tree.meeting(query, |k| got.push(k));
                got.sort_unstable();
                let want: Vec<usize> = (0..boxes.len()).filter(|&k| P::meet(&boxes[k], &query)).collect();
                assert_eq!(got, want, "{count}");
            }
        }
    }

    #[test]
    fn finds_the_boxes_that_a_linear_scan_finds() {
        let mut random = SplitMix(1);
        assert_finds(&mut random, |random, size| DVec2::new(random.unit(), random.unit()) * size);
        assert_finds(&mut random, |random, size| DVec3::from([(); 3].map(|()| random.unit())) * size);
    }
}
