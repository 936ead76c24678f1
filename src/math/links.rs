//! Arcs from node to node -> chains of arcs head to tail.

use std::collections::BTreeMap;

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
    fn chains_go_on_with_the_first_arc() {
        let arcs = [[0, 1], [1, 2], [1, 3], [2, 0], [3, 0], [0, 1]];
        assert_eq!(Links::of(&arcs).closed().expect("closed"), [[0, 1, 3], [2, 4, 5]]);
        let open = Links::of(&[[0, 1], [2, 2], [1, 3]]);
        assert_eq!((open.all_closed, open.chains), (false, vec![vec![0, 2], vec![1]]));
    }
}
