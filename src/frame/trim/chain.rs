//! Directed edges with multiplicities: which do not cancel, and a fingerprint of their sum.
//!
//! A chain is a sum of directed edges in which an edge and its reverse cancel. The boundary of triangles is a chain, and so are
//! loops. A triangulation closes with its neighbours when the two are equal, whatever the vertices' coordinates.

use super::TrimInput;
use crate::mesh::BitMix;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

/// A sum of directed edges.
#[derive(Clone, Default)]
pub(in crate::frame) struct Chain {
    /// By ends in rising order: uses in that direction less uses in the other.
    edges: HashMap<(u32, u32), i32, BuildHasherDefault<BitMix>>,
}

impl Chain {
    /// Adds an edge `times` times. An edge from a vertex to itself has no length and adds nothing.
    pub(in crate::frame) fn add(&mut self, [from, to]: [u32; 2], times: i32) {
        if from != to {
            *self.edges.entry((from.min(to), from.max(to))).or_default() += if from < to { times } else { -times };
        }
    }

    /// Adds the boundary of a triangle `times` times.
    pub(in crate::frame) fn add_triangle(&mut self, [a, b, c]: [u32; 3], times: i32) {
        [[a, b], [b, c], [c, a]].into_iter().for_each(|edge| self.add(edge, times));
    }

    /// Whether all edges cancel.
    pub(in crate::frame) fn is_zero(&self) -> bool {
        self.edges.values().all(|&times| times == 0)
    }

    /// The chain as simple closed walks that sum to it, each a list of three or more distinct vertices. The chain must be
    /// closed: as many edges enter each vertex as leave it. An edge of multiplicity n is part of n walks.
    ///
    /// The walks depend on the chain alone, not on the order in which it was summed.
    pub(super) fn walks(&self) -> Vec<Vec<u32>> {
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for (&(low, high), &times) in &self.edges {
            let edge = if times > 0 { [low, high] } else { [high, low] };
            edges.extend(std::iter::repeat_n(edge, times.unsigned_abs() as usize));
        }
        edges.sort_unstable();
        let first = |v: u32| edges.partition_point(|edge| edge[0] < v);
        // By vertex, where its next unused edge stands.
        let mut next: HashMap<u32, usize> = HashMap::new();
        let mut walks = Vec::new();
        // Vertices of the path so far, and where each of them stands in it.
        let (mut path, mut at): (Vec<u32>, HashMap<u32, usize>) = (Vec::new(), HashMap::new());
        for start in 0..edges.len() {
            let mut here = edges[start][0];
            loop {
                if let Some(from) = at.get(&here).copied() {
                    let walk = path.split_off(from);
                    walk.iter().for_each(|v| _ = at.remove(v));
                    walks.push(walk);
                }
                let edge = next.entry(here).or_insert_with(|| first(here));
                let Some(&[_, to]) = edges.get(*edge).filter(|edge| edge[0] == here) else { break };
                *edge += 1;
                at.insert(here, path.len());
                path.push(here);
                here = to;
            }
        }
        walks
    }
}

/// Whether two sets of triangles have the same boundary.
pub(in crate::frame) fn same_boundary(
    old: impl Iterator<Item = [u32; 3]>,
    new: impl Iterator<Item = [u32; 3]>,
) -> bool {
    let mut chain = Chain::default();
    old.for_each(|t| chain.add_triangle(t, 1));
    new.for_each(|t| chain.add_triangle(t, -1));
    chain.is_zero()
}

/// A number that equal chains share, and that chains which differ share with a chance of 2^-64: the sum of a pseudo-random
/// number for each edge, negative for its reverse (fingerprints as of R. M. Karp and M. O. Rabin, *Efficient randomized
/// pattern-matching algorithms*, 1987). It proves in about eight instructions an edge that triangles have the boundary they
/// should have, where cancelling edges in a table takes ten times that.
#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
pub(super) struct Fingerprint(u64);

impl Fingerprint {
    /// Of the segments of a tile's loops.
    pub(super) fn of_loops(tile: &TrimInput<'_>) -> Self {
        let mut sum = Self::default();
        for l in tile.loops().filter(|l| l.len() > 1) {
            (l.start..l.end - 1).for_each(|v| sum.add(v, v + 1));
            sum.add(l.end - 1, l.start);
        }
        sum
    }

    /// Adds an edge. An edge from a vertex to itself must not be added.
    #[inline(always)]
    pub(super) fn add(&mut self, from: u32, to: u32) {
        let (low, high) = if from < to { (from, to) } else { (to, from) };
        let mut x = (u64::from(low) << 32 | u64::from(high)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93);
        x ^= x >> 32;
        self.0 = self.0.wrapping_add(if from < to { x } else { x.wrapping_neg() });
    }

    /// Takes away the boundary of a triangle or of another polygon.
    pub(super) fn remove(&mut self, polygon: &[u32]) {
        let next = polygon.iter().cycle().skip(1);
        polygon.iter().zip(next).for_each(|(&from, &to)| self.add(to, from));
    }

    #[inline(always)]
    pub(super) fn add_triangle(&mut self, [a, b, c]: [u32; 3]) {
        self.add(a, b);
        self.add(b, c);
        self.add(c, a);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walks_sum_to_the_chain() {
        // Two triangles that share a vertex, one of them twice, and a square run backwards.
        let mut chain = Chain::default();
        chain.add_triangle([0, 1, 2], 1);
        chain.add_triangle([2, 3, 4], 2);
        for (a, b) in [(8, 7), (7, 6), (6, 5), (5, 8)] {
            chain.add([a, b], 1);
        }
        let walks = chain.walks();
        assert_eq!(walks.len(), 4, "{walks:?}");
        for walk in &walks {
            for (k, &v) in walk.iter().enumerate() {
                chain.add([v, walk[(k + 1) % walk.len()]], -1);
            }
            let mut sorted = walk.clone();
            sorted.sort_unstable();
            sorted.dedup();
            assert_eq!(sorted.len(), walk.len(), "{walk:?} is simple");
        }
        assert!(chain.is_zero());
        assert!(chain.walks().is_empty());
    }

    #[test]
    fn fingerprints_of_equal_chains_are_equal() {
        let of = |triangles: &[[u32; 3]]| {
            let mut sum = Fingerprint::default();
            triangles.iter().for_each(|&t| sum.add_triangle(t));
            sum
        };
        assert_eq!(of(&[[0, 1, 2], [0, 2, 3]]), of(&[[1, 2, 3], [1, 3, 0]]), "a square and its other diagonal");
        assert_ne!(of(&[[0, 1, 2]]), of(&[[0, 2, 1]]));
        assert_eq!(of(&[[0, 1, 2], [0, 2, 1]]), Fingerprint::default());
    }
}
