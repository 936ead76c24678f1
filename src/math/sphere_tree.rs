//! Points in space -> their order along a Hilbert curve, on which neighbours are near each other; spheres in that order
//! -> a tree that finds those that pass a test which larger spheres pass, too: frustum culling.
//!
//! Index: J. Skilling, *Programming the Hilbert curve*, AIP Conf. Proc. 707 (2004), 381. Tree: Kamel & Faloutsos, "On
//! packing R-trees", CIKM 1993.

use super::boxes::{Tree, around};
use glam::DVec3;

/// Bits per axis of a Hilbert index: three axes fill 63 of 64 bits.
const BITS: u32 = 21;

/// Indices of `points`, sorted along a Hilbert curve that fills the cube around them. Points that are not finite have a
/// place, too.
pub(crate) fn along_curve(points: impl Iterator<Item = DVec3> + Clone) -> Vec<usize> {
    let [low, high] = around(points.clone());
    let steps = f64::from((1_u32 << BITS) - 1);
    let side = (high - low).max_element();
    let scale = if side > 0.0 { steps / side } else { 0.0 };
    let of_point = |(index, point): (usize, DVec3)| {
        let cell = ((point - low) * scale).clamp(DVec3::ZERO, DVec3::splat(steps));
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0..2^21 above")]
        let axes = [cell.x as u32, cell.y as u32, cell.z as u32];
        (hilbert_index(axes, BITS), index)
    };
    let mut keyed: Vec<(u64, usize)> = points.enumerate().map(of_point).collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, index)| index).collect()
}

/// Position of a lattice cell along the Hilbert curve that fills a cube of `2^bits` cells a side.
///
/// `axes` are below `2^bits`, `1 ≤ bits ≤ 21`. Cells with consecutive indices share a side.
fn hilbert_index(mut axes: [u32; 3], bits: u32) -> u64 {
    // Undo, from the coarsest level down, the reflections and axis exchanges that the curve makes in each octant ...
    for level in (1..bits).rev() {
        let bit = 1_u32 << level;
        let finer = bit - 1;
        for k in 0..3 {
            if axes[k] & bit == 0 {
                let differing = (axes[0] ^ axes[k]) & finer;
                axes[0] ^= differing;
                axes[k] ^= differing;
            } else {
                axes[0] ^= finer;
            }
        }
    }
    // ... which leaves a Gray code whose digits are the axes' bits, level by level.
    axes[1] ^= axes[0];
    axes[2] ^= axes[1];
    let mut correction = 0;
    for level in 1..bits {
        if axes[2] & (1 << level) != 0 {
            correction ^= (1_u32 << level) - 1;
        }
    }
    (0..bits).rev().fold(0, |index, level| {
        axes.iter().fold(index, |index, axis| (index << 1) | u64::from(((axis ^ correction) >> level) & 1))
    })
}

/// A ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sphere {
    pub(crate) centre: DVec3,
    pub(crate) radius: f64,
}

impl Sphere {
    /// All of space, for what is not finite.
    const ALL: Self = Self { centre: DVec3::ZERO, radius: f64::INFINITY };

    /// No ball, at the same place: no search finds it, and it makes no node larger.
    pub(crate) fn emptied(self) -> Self {
        Self { radius: f64::NEG_INFINITY, ..self }
    }

    fn is_empty(&self) -> bool {
        self.radius < 0.0
    }

    /// A ball; all of space if any of its numbers is not finite.
    pub(crate) fn new(centre: DVec3, radius: f64) -> Self {
        if centre.is_finite() && radius.is_finite() { Self { centre, radius } } else { Self::ALL }
    }

    /// A ball that contains all of these. Empty if they are.
    fn around(children: &[Self]) -> Self {
        /// Share of the radius by which it is enlarged, for rounding.
        const ROUNDING: f64 = 1e-12;
        if children.iter().any(|child| child.radius == f64::INFINITY) {
            return Self::ALL;
        }
        if children.iter().all(Self::is_empty) {
            return children[0].emptied();
        }
        let low = children.iter().fold(DVec3::INFINITY, |low, c| low.min(c.centre - c.radius));
        let high = children.iter().fold(DVec3::NEG_INFINITY, |high, c| high.max(c.centre + c.radius));
        let centre = 0.5 * (low + high);
        let reach = children.iter().map(|c| centre.distance(c.centre) + c.radius).fold(0.0, f64::max);
        Self::new(centre, reach * (1.0 + ROUNDING))
    }
}

/// A tree of spheres, numbered in the order given.
#[derive(Debug)]
pub(crate) struct SphereTree {
    /// The number of each leaf.
    numbers: Vec<u32>,
    /// The leaf of each sphere.
    places: Vec<u32>,
    tree: Tree<Sphere>,
    /// Spheres replaced since the leaves were ordered.
    replaced: usize,
}

impl SphereTree {
    /// Cost: O(n log n), 45 bytes per sphere.
    pub(crate) fn new(spheres: &[Sphere]) -> Self {
        let order = along_curve(spheres.iter().map(|sphere| sphere.centre));
        let mut places = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, &number)| places[number] = place as u32);
        let tree = Tree::new(order.iter().map(|&number| spheres[number]).collect(), Sphere::around);
        Self { numbers: order.into_iter().map(|number| number as u32).collect(), places, tree, replaced: 0 }
    }

    /// Replaces a sphere, and the nodes above it.
    ///
    /// Cost: O(log n). After as many calls as there are spheres, their order says nothing about their places any more,
    /// and the call makes a new tree.
    pub(crate) fn replace(&mut self, number: usize, sphere: Sphere) {
        self.tree.replace(self.places[number] as usize, sphere, Sphere::around);
        self.replaced += 1;
        if self.replaced > self.numbers.len() {
            let leaves = self.tree.leaves();
            *self = Self::new(&self.places.iter().map(|&place| leaves[place as usize]).collect::<Vec<_>>());
        }
    }

    /// Appends to `found` the numbers of the spheres that pass and are not empty, ascending. `passes` must be true for
    /// every sphere that contains one for which it is true.
    pub(crate) fn find(&self, passes: impl Fn(&Sphere) -> bool, found: &mut Vec<u32>) {
        let start = found.len();
        let passes = |sphere: &Sphere| !sphere.is_empty() && passes(sphere);
        self.tree.find(passes, |place| found.push(self.numbers[place]));
        found[start..].sort_unstable();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;

    #[test]
    fn hilbert_curve_visits_every_cell_and_steps_to_neighbours() {
        for bits in 1..=4 {
            let side = 1_u32 << bits;
            let mut cells: Vec<(u64, [u32; 3])> = Vec::new();
            for x in 0..side {
                for y in 0..side {
                    cells.extend((0..side).map(|z| (hilbert_index([x, y, z], bits), [x, y, z])));
                }
            }
            cells.sort_unstable();
            for (expected, (index, _)) in cells.iter().enumerate() {
                assert_eq!(*index, expected as u64, "{bits} bits");
            }
            for pair in cells.windows(2) {
                let step: u32 = (0..3).map(|k| pair[0].1[k].abs_diff(pair[1].1[k])).sum();
                assert_eq!(step, 1, "{bits} bits: {pair:?}");
            }
        }
    }

    fn random(draw: &mut SplitMix) -> Sphere {
        let mut vector = |size: f64| DVec3::from([0; 3].map(|_| draw.range(-size, size)));
        let (centre, kind) = (vector(100.0), vector(1.0).x);
        let sphere = Sphere::new(if centre.x > 99.0 { DVec3::NAN } else { centre }, vector(4.0).x.abs());
        if kind > 0.6 { sphere.emptied() } else { sphere }
    }

    #[test]
    fn finds_the_spheres_that_a_linear_scan_finds_also_after_they_moved_and_were_emptied() {
        let mut draw = SplitMix(1);
        for count in [0, 1, 2, 7, 8, 9, 63, 64, 65, 1000] {
            let mut spheres: Vec<Sphere> = (0..count).map(|_| random(&mut draw)).collect();
            let mut tree = SphereTree::new(&spheres);
            for _ in 0..50 {
                let (normal, at) = (random(&mut draw).centre, draw.range(-80.0, 80.0));
                let passes = |s: &Sphere| normal.is_nan() || normal.normalize().dot(s.centre) + s.radius >= at;
                let mut found = vec![7];
                tree.find(passes, &mut found);
                let is_found = |k: &usize| !spheres[*k].is_empty() && passes(&spheres[*k]);
                let expected = (0..count).filter(is_found).map(|k| k as u32);
                assert!(found[1..].iter().copied().eq(expected), "{count}: {found:?}");
                for _ in 0..count / 10 {
                    let k = draw.below(count as u64) as usize;
                    spheres[k] = random(&mut draw);
                    tree.replace(k, spheres[k]);
                }
            }
        }
    }

    #[test]
    fn a_tree_of_empty_spheres_finds_none_of_them_until_they_are_replaced() {
        let sphere = |k: u32| Sphere::new(DVec3::splat(f64::from(k)), 1.0);
        let mut tree = SphereTree::new(&(0..30).map(|k| sphere(k).emptied()).collect::<Vec<_>>());
        let found = |tree: &SphereTree| {
            let mut found = Vec::new();
            tree.find(|_| true, &mut found);
            found
        };
        assert!(found(&tree).is_empty());
        for k in [3, 29] {
            tree.replace(k as usize, sphere(k));
        }
        assert_eq!(found(&tree), [3, 29]);
        tree.replace(3, sphere(3).emptied());
        assert_eq!(found(&tree), [29]);
    }
}
