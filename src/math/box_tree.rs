//! Boxes in the plane -> a tree that finds those that meet a query box. Sort-tile-recursive packing (Leutenegger, Lopez
//! & Edgington, "STR: a simple and efficient algorithm for R-tree packing", ICDE 1997).

use glam::DVec2;

/// Children per node.
const FAN: usize = 8;

/// A static tree of boxes, numbered in the order given.
pub(crate) struct BoxTree {
    /// The number of each box of the lowest level.
    numbers: Vec<u32>,
    /// From the boxes themselves up to the root. Each node bounds the next [`FAN`] nodes of the level below.
    levels: Vec<Vec<[DVec2; 2]>>,
}

impl BoxTree {
    /// Builds the tree from lower and upper corners. Cost: O(n log n), 45 bytes per box.
    pub(crate) fn new(boxes: &[[DVec2; 2]]) -> Self {
        let middle = |k: &u32| boxes[*k as usize][0] + boxes[*k as usize][1];
        let mut numbers: Vec<u32> = (0..u32::try_from(boxes.len()).unwrap_or(u32::MAX)).collect();
        numbers.sort_unstable_by(|a, b| middle(a).x.total_cmp(&middle(b).x));
        let nodes = numbers.len().div_ceil(FAN);
        let slices = (nodes as f64).sqrt().ceil().max(1.0) as usize;
        for slice in numbers.chunks_mut(FAN * nodes.div_ceil(slices).max(1)) {
            slice.sort_unstable_by(|a, b| middle(a).y.total_cmp(&middle(b).y));
        }
        let mut levels: Vec<Vec<[DVec2; 2]>> = vec![numbers.iter().map(|&k| boxes[k as usize]).collect()];
        while let Some(below) = levels.last().filter(|level| level.len() > 1) {
            let whole = |of: &[[DVec2; 2]]| of[1..].iter().fold(of[0], |[l, h], b| [l.min(b[0]), h.max(b[1])]);
            levels.push(below.chunks(FAN).map(whole).collect());
        }
        Self { numbers, levels }
    }

    /// Calls `found` with the number of each box that overlaps or touches the box from `low` to `high`. The order
    /// depends on the tree only.
    pub(crate) fn meeting(&self, [low, high]: [DVec2; 2], mut found: impl FnMut(usize)) {
        let mut open: Vec<(usize, usize)> = Vec::new();
        let top = self.levels.len() - 1;
        open.extend((0..self.levels[top].len()).map(|node| (top, node)));
        while let Some((level, node)) = open.pop() {
            let [l, h] = self.levels[level][node];
            if l.cmpgt(high).any() || h.cmplt(low).any() {
                continue;
            }
            if level == 0 {
                found(self.numbers[node] as usize);
            } else {
                let below = self.levels[level - 1].len();
                open.extend((FAN * node..(FAN * (node + 1)).min(below)).map(|child| (level - 1, child)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;

    #[test]
    fn finds_the_boxes_that_a_linear_scan_finds() {
        let mut random = SplitMix(1);
        let mut unit = || random.unit();
        for count in [0, 1, 2, 7, 8, 9, 63, 64, 65, 1000] {
            let boxes: Vec<[DVec2; 2]> = (0..count)
                .map(|_| {
                    let low = DVec2::new(unit(), unit());
                    [low, low + DVec2::new(unit(), unit()) * 0.1]
                })
                .collect();
            let tree = BoxTree::new(&boxes);
            for _ in 0..50 {
                let low = DVec2::new(unit(), unit());
                // A box, or a ray.
                let high = if unit() < 0.5 { low + DVec2::splat(0.2) } else { DVec2::new(f64::INFINITY, low.y) };
                let mut got = Vec::new();
                tree.meeting([low, high], |k| got.push(k));
                got.sort_unstable();
                let meets = |b: &[DVec2; 2]| b[0].cmple(high).all() && b[1].cmpge(low).all();
                let want: Vec<usize> = (0..count).filter(|&k| meets(&boxes[k])).collect();
                assert_eq!(got, want, "{count}");
            }
        }
    }
}
