//! Nodes and arcs -> the sets of nodes that are connected, and the chains that arcs form.

use std::collections::BTreeMap;

/// A partition of the integers `0..len` (Galler and Fischer 1964), with path halving.
#[derive(Clone, Debug, Default)]
pub(crate) struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// Every integer below `count` in a set of its own.
    pub(crate) fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// Number of integers, not of sets.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// Adds the next integer in a set of its own and returns it.
    #[cfg(any(test, feature = "step"))]
    pub(crate) fn push(&mut self) -> u32 {
        let next = self.0.len() as u32;
        self.0.push(next);
        next
    }

    /// The representative of the set that contains `at`.
    pub(crate) fn root(&mut self, at: u32) -> u32 {
        let mut at = at;
        while self.0[at as usize] != at {
            let above = self.0[self.0[at as usize] as usize];
            self.0[at as usize] = above;
            at = above;
        }
        at
    }

    /// Merges two sets. The smaller of their roots becomes the root.
    pub(crate) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// Arcs linked to chains, by their indices.
pub(crate) struct Links {
    pub(crate) chains: Vec<Vec<usize>>,
    /// Whether each chain ends where it starts.
    pub(crate) all_closed: bool,
}

impl Links {
    /// Links arcs, given by start and end, to chains. Each starts with the first arc that is left, and ends where it
    /// started, or where no arc is left. Where several leave a node, the first one that is left goes on.
    pub(crate) fn of<N: Ord>(arcs: &[[N; 2]]) -> Self {
        let mut leaving: BTreeMap<&N, Vec<usize>> = BTreeMap::new();
        for (k, [from, _]) in arcs.iter().enumerate().rev() {
            leaving.entry(from).or_default().push(k);
        }
        let mut used = vec![false; arcs.len()];
        let mut out = Self { chains: Vec::new(), all_closed: true };
        for first in 0..arcs.len() {
            if std::mem::replace(&mut used[first], true) {
                continue;
            }
            let [start, mut at] = arcs[first].each_ref();
            let mut chain = vec![first];
            while at != start {
                let left = leaving.get_mut(at).and_then(|there| {
                    while there.pop_if(|k| used[*k]).is_some() {}
                    there.pop()
                });
                let Some(next) = left else {
                    out.all_closed = false;
                    break;
                };
                used[next] = true;
                chain.push(next);
                at = &arcs[next][1];
            }
            out.chains.push(chain);
        }
        out
    }

    /// The chains, if all are closed.
    pub(crate) fn closed(self) -> Option<Vec<Vec<usize>>> {
        self.all_closed.then_some(self.chains)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_numbers_have_one_root() {
        let mut sets = DisjointSets::new(6);
        sets.join(4, 2);
        sets.join(5, 4);
        assert_eq!((0..6).map(|k| sets.root(k)).collect::<Vec<_>>(), [0, 1, 2, 3, 2, 2]);
        assert_eq!((sets.push(), sets.len()), (6, 7));
    }

    #[test]
    fn chains_go_on_with_the_first_arc() {
        let arcs = [[0, 1], [1, 2], [1, 3], [2, 0], [3, 0], [0, 1]];
        assert_eq!(Links::of(&arcs).closed().expect("closed"), [[0, 1, 3], [2, 4, 5]]);
        let open = Links::of(&[[0, 1], [2, 2], [1, 3]]);
        assert_eq!((open.all_closed, open.chains), (false, vec![vec![0, 2], vec![1]]));
    }
}
