//! Directed edges with multiplicities -> the edges that do not cancel.
//!
//! A chain is a sum of directed edges in which an edge and its reverse cancel. The boundary of triangles is a chain,
//! and so are loops. A triangulation closes with its neighbours if the two are equal, regardless of the vertices'
//! coordinates.

use crate::math::BitMix;
use glam::DVec2;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

/// A sum of directed edges.
#[derive(Default)]
pub(crate) struct EdgeSum {
    /// By ends in ascending order: uses in that direction minus uses in the other.
    edges: HashMap<(u32, u32), i32, BuildHasherDefault<BitMix>>,
}

impl EdgeSum {
    /// Adds an edge `times` times. An edge from a vertex to itself has no length and adds nothing.
    pub(crate) fn add(&mut self, [from, to]: [u32; 2], times: i32) {
        if from != to {
            *self.edges.entry((from.min(to), from.max(to))).or_default() += if from < to { times } else { -times };
        }
    }

    /// Adds the boundary of a triangle `times` times.
    pub(crate) fn add_triangle(&mut self, [a, b, c]: [u32; 3], times: i32) {
        [[a, b], [b, c], [c, a]].into_iter().for_each(|edge| self.add(edge, times));
    }

    /// Whether all edges cancel.
    pub(crate) fn is_zero(&self) -> bool {
        self.edges.values().all(|&times| times == 0)
    }

    /// The edges that do not cancel, each as often as it counts, in any order.
    pub(crate) fn edges(&self) -> Vec<[u32; 2]> {
        let of = |(&(low, high), &times): (&(u32, u32), &i32)| {
            let edge = if times > 0 { [low, high] } else { [high, low] };
            std::iter::repeat_n(edge, times.unsigned_abs() as usize)
        };
        self.edges.iter().flat_map(of).collect()
    }

    /// Splits the chain into simple closed walks that sum to it, each a list of three or more distinct vertices. The
    /// chain must be closed: as many edges enter each vertex as leave it. An edge of multiplicity n is part of n walks.
    ///
    /// Where several edges leave a vertex, a walk takes the one that leads back most nearly along the line it came by,
    /// by the positions from `point`. The walk that closes a split segment then lies along the segment. The walks
    /// depend on the chain alone, not on the order in which it was summed.
    pub(crate) fn walks(&self, point: impl Fn(u32) -> DVec2) -> Vec<Vec<u32>> {
        let mut edges = self.edges();
        edges.sort_unstable();
        let mut unused = Unused::of(edges);
        let mut walks = Vec::new();
        // Vertices of the path so far, and the index of each in it.
        let (mut path, mut at): (Vec<u32>, HashMap<u32, usize>) = (Vec::new(), HashMap::new());
        for start in 0..unused.edges.len() {
            let mut here = unused.edges[start][0];
            loop {
                if let Some(from) = at.get(&here).copied() {
                    let walk = path.split_off(from);
                    walk.iter().for_each(|v| _ = at.remove(v));
                    walks.push(walk);
                }
                let came = path.last().map(|&before| point(here) - point(before));
                let bend = |to: u32| came.map_or(0.0, |came| bend(came, point(to) - point(here)));
                let Some(to) = unused.take(here, bend) else { break };
                at.insert(here, path.len());
                path.push(here);
                here = to;
            }
        }
        walks
    }
}

/// Rank of a step `on` after a step `came`: 0 for straight back, nearly 0 for straight on, 1 for a right angle.
fn bend(came: DVec2, on: DVec2) -> f64 {
    /// Puts straight on after straight back, and before any turn larger than rounding.
    const ON: f64 = 1e-9;
    let lengths = came.length() * on.length();
    let sine = if lengths > 0.0 { (came.perp_dot(on) / lengths).abs() } else { 0.0 };
    sine + if came.dot(on) > 0.0 { ON } else { 0.0 }
}

/// Edges in ascending order, some of which are used up.
struct Unused {
    edges: Vec<[u32; 2]>,
    used: Vec<bool>,
    /// By vertex, the first of its edges that may be unused.
    next: HashMap<u32, usize>,
}

impl Unused {
    fn of(edges: Vec<[u32; 2]>) -> Self {
        Self { used: vec![false; edges.len()], edges, next: HashMap::new() }
    }

    /// Takes the unused edge from a vertex whose end has the least `bend`; `None` if there is none. Looks at the first
    /// 16 only: otherwise a vertex with thousands of edges would cost their square.
    fn take(&mut self, from: u32, bend: impl Fn(u32) -> f64) -> Option<u32> {
        const LOOKED_AT: usize = 16;
        let Self { edges, used, next } = self;
        let first = next.entry(from).or_insert_with(|| edges.partition_point(|edge| edge[0] < from));
        while used.get(*first).copied().unwrap_or(false) && edges[*first][0] == from {
            *first += 1;
        }
        let of_vertex = (*first..edges.len()).take_while(|&k| edges[k][0] == from).take(LOOKED_AT);
        let best = of_vertex.filter(|&k| !used[k]).min_by(|&j, &k| bend(edges[j][1]).total_cmp(&bend(edges[k][1])))?;
        used[best] = true;
        Some(edges[best][1])
    }
}

/// Whether two sets of triangles have the same boundary.
pub(crate) fn same_boundary(old: impl Iterator<Item = [u32; 3]>, new: impl Iterator<Item = [u32; 3]>) -> bool {
    let mut chain = EdgeSum::default();
    old.for_each(|t| chain.add_triangle(t, 1));
    new.for_each(|t| chain.add_triangle(t, -1));
    chain.is_zero()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walks_sum_to_the_chain() {
        // Two triangles that share a vertex, one of them twice, and a square run backwards.
        let mut chain = EdgeSum::default();
        chain.add_triangle([0, 1, 2], 1);
        chain.add_triangle([2, 3, 4], 2);
        for (a, b) in [(8, 7), (7, 6), (6, 5), (5, 8)] {
            chain.add([a, b], 1);
        }
        let point = |v: u32| DVec2::from_angle(f64::from(v));
        let walks = chain.walks(point);
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
        assert!(chain.walks(point).is_empty());
    }

    #[test]
    fn split_segments_are_closed_one_by_one() {
        // A closed polygon of collinear and bent segments, each of which is split at its midpoint.
        let points = [(0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (4.0, 2.0), (0.0, 2.0)].map(|(x, y)| DVec2::new(x, y));
        let point = |v: u32| {
            let [k, next] = [v % 5, (v + 1) % 5].map(|k| points[k as usize]);
            if v < 5 { k } else { k.midpoint(next) }
        };
        let mut chain = EdgeSum::default();
        for k in 0..5 {
            chain.add([k, (k + 1) % 5], 1);
            chain.add([k, k + 5], -1);
            chain.add([k + 5, (k + 1) % 5], -1);
        }
        let walks = chain.walks(point);
        assert_eq!(walks.len(), 5, "{walks:?}");
        assert!(walks.iter().all(|walk| walk.len() == 3), "{walks:?}");
    }
}
