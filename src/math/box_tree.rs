//! Boxes in the plane or in space -> a tree that finds those that meet a query box. Sort-tile-recursive packing
//! (Leutenegger, Lopez & Edgington, "STR: a simple and efficient algorithm for R-tree packing", ICDE 1997).

use super::boxes::{Corner, around};
use super::tree::{FAN, Tree};

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
    use glam::{DVec2, DVec3};

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
