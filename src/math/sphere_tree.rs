//! Spheres in space -> a tree that finds those that pass a test which larger spheres pass, too: frustum culling.
//! The leaves are ordered along a Hilbert curve (Kamel & Faloutsos, "On packing R-trees", CIKM 1993).

use super::hilbert;
use super::tree::Tree;
use glam::DVec3;

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
        let order = hilbert::along_curve(spheres.iter().map(|sphere| sphere.centre));
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
