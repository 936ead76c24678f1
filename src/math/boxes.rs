//! Boxes in space -> the pairs that overlap, by a self-join of a tree that halves the boxes by their centres.

use glam::{DVec2, DVec3};

/// Lower and upper corner.
pub(crate) type Aabb = [DVec3; 2];

/// A point of which each coordinate has a minimum and a maximum.
pub(crate) trait Corner: Copy {
    /// The box that contains no point.
    const NOTHING: [Self; 2];
    /// The smallest box that contains both another and `self`.
    fn added(self, to: [Self; 2]) -> [Self; 2];
}

macro_rules! corner {
    ($($point:ident),*) => {
        $(impl Corner for $point {
            const NOTHING: [Self; 2] = [Self::INFINITY, Self::NEG_INFINITY];
            fn added(self, [low, high]: [Self; 2]) -> [Self; 2] {
                [low.min(self), high.max(self)]
            }
        })*
    };
}
corner!(DVec2, DVec3);

/// Lower and upper corner of the smallest box around points; `[+∞, -∞]` without any.
pub(crate) fn around<P: Corner>(points: impl IntoIterator<Item = P>) -> [P; 2] {
    points.into_iter().fold(P::NOTHING, |all, p| p.added(all))
}

/// Most boxes per leaf.
const LEAF: usize = 8;

struct BoxNode {
    bounds: Aabb,
    /// Its boxes are `order[from..to]`.
    from: usize,
    to: usize,
    /// Index of the first of its two children, which are adjacent; `None` for a leaf.
    halves: Option<usize>,
}

/// Calls `each` once for every pair of boxes that overlap or touch, lower index first. The order depends on the boxes
/// alone.
///
/// Cost: O(n log n) to build the tree, then about linear in the number of pairs unless boxes are long and diagonal.
pub(crate) fn overlapping(boxes: &[Aabb], each: &mut impl FnMut(usize, usize)) {
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    let mut nodes = vec![BoxNode { bounds: bounds(boxes, &order), from: 0, to: order.len(), halves: None }];
    let mut next = 0;
    while next < nodes.len() {
        let (from, to) = (nodes[next].from, nodes[next].to);
        if to - from > LEAF {
            let middle = (from + to) / 2;
            let centre = |k: usize| boxes[k][0] + boxes[k][1];
            let of_node = &mut order[from..to];
            let [low, high] = around(of_node.iter().map(|&k| centre(k)));
            let spread = high - low;
            let axis = (0..3).max_by(|&a, &b| spread[a].total_cmp(&spread[b])).unwrap_or(0);
            of_node.select_nth_unstable_by(middle - from, |&a, &b| {
                centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.cmp(&b))
            });
            nodes[next].halves = Some(nodes.len());
            for (from, to) in [(from, middle), (middle, to)] {
                nodes.push(BoxNode { bounds: bounds(boxes, &order[from..to]), from, to, halves: None });
            }
        }
        next += 1;
    }
    let mut pairs = vec![(0, 0)];
    while let Some((a, b)) = pairs.pop() {
        let [p, q] = [&nodes[a], &nodes[b]];
        if !meet(&p.bounds, &q.bounds) {
            continue;
        }
        match (p.halves, q.halves) {
            (Some(half), _) if a == b => pairs.extend([(half, half), (half + 1, half + 1), (half, half + 1)]),
            (Some(half), None) => pairs.extend([(half, b), (half + 1, b)]),
            (Some(half), Some(_)) if p.to - p.from >= q.to - q.from => pairs.extend([(half, b), (half + 1, b)]),
            (_, Some(half)) => pairs.extend([(a, half), (a, half + 1)]),
            (None, None) => {
                for i in p.from..p.to {
                    let first = if a == b { i + 1 } else { q.from };
                    for &l in &order[first..q.to] {
                        let k = order[i];
                        if meet(&boxes[k], &boxes[l]) {
                            each(k.min(l), k.max(l));
                        }
                    }
                }
            }
        }
    }
}

fn bounds(boxes: &[Aabb], of: &[usize]) -> Aabb {
    of.iter().fold(DVec3::NOTHING, |[low, high], &k| [low.min(boxes[k][0]), high.max(boxes[k][1])])
}

fn meet(a: &Aabb, b: &Aabb) -> bool {
    a[0].cmple(b[1]).all() && b[0].cmple(a[1]).all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;

    #[test]
    fn finds_the_pairs_that_brute_force_finds() {
        let mut random = SplitMix(7);
        for count in [0, 1, 2, 9, 300] {
            let mut point = || DVec3::from([(); 3].map(|()| random.unit()));
            let mut boxes: Vec<Aabb> = (0..count).map(|_| [point(), 0.2 * point()]).map(|[p, s]| [p, p + s]).collect();
            // Duplicates, so that the halves of a node have equal centres.
            boxes.extend(boxes.first().copied().into_iter().cycle().take(count));
            let mut found = Vec::new();
            overlapping(&boxes, &mut |a, b| found.push((a, b)));
            found.sort_unstable();
            let all = (0..boxes.len()).flat_map(|a| (a + 1..boxes.len()).map(move |b| (a, b)));
            let expected: Vec<_> = all.filter(|&(a, b)| meet(&boxes[a], &boxes[b])).collect();
            assert_eq!(found, expected);
        }
    }
}
