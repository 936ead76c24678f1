//! Ends of edges -> shared vertices; edges of a loop -> their directions head to tail.

use super::draft::EdgeDraft;
use super::loops::VertexKey;
use super::values::Map;
use crate::math::graph::DisjointSets;
use glam::DVec3;

/// Merges vertices that are one: those with the same number in the file, and coincident ones of neighbours in a loop.
#[derive(Default)]
pub(super) struct Corners {
    index: Map<VertexKey, usize>,
    merged: DisjointSets,
    pub(super) points: Vec<DVec3>,
}

impl Corners {
    pub(super) fn of(&mut self, key: VertexKey, point: DVec3) -> usize {
        let fresh = self.merged.len();
        let at = *self.index.entry(key).or_insert(fresh);
        if at == fresh {
            self.merged.push();
            self.points.push(point);
        }
        self.root(at)
    }

    /// The corner of a vertex that an edge ends at.
    pub(super) fn find(&mut self, key: VertexKey) -> Option<usize> {
        let at = *self.index.get(&key)?;
        Some(self.root(at))
    }

    pub(super) fn root(&mut self, at: usize) -> usize {
        self.merged.root(at as u32) as usize
    }

    /// Merges two corners; the one that comes first in the file stays.
    pub(super) fn unite(&mut self, a: usize, b: usize) {
        self.merged.join(a as u32, b as u32);
    }

    /// The two corners of a coedge, in loop order.
    pub(super) fn ends(&mut self, edge: &mut EdgeDraft, reversed: bool) -> (usize, usize) {
        let known = edge.corners.unwrap_or_else(|| [0, 1].map(|i| self.of(edge.ends[i], edge.points[i])));
        edge.corners = Some(known);
        let [a, b] = known.map(|at| self.root(at));
        if reversed { (b, a) } else { (a, b) }
    }
}

/// Which edges of a loop, given by their corners, must be reversed to run head to tail, given whether the first is.
/// `None` if the loop is open then.
pub(super) fn head_to_tail(ends: &[(usize, usize)], first: bool) -> Option<Vec<bool>> {
    let Some(&(tail, head)) = ends.first() else { return Some(Vec::new()) };
    let (start, mut at) = if first { (head, tail) } else { (tail, head) };
    let mut turned = Vec::with_capacity(ends.len());
    turned.push(first);
    for &(tail, head) in &ends[1..] {
        turned.push(tail != at);
        at = match at {
            _ if at == tail => head,
            _ if at == head => tail,
            _ => return None,
        };
    }
    (at == start).then_some(turned)
}
