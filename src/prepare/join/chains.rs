//! Chains of faces -> their sums over each shell: whether the mesh can be closed at all.
//!
//! A chain counts for each edge the uses along its direction minus those against it. A mesh is closed because the
//! chains of its faces cancel, whatever its loops do in (u,v).

use crate::math::keyed::summed_by_pair;
use crate::model::EdgeId;
use crate::prepare::wires::boundary::{Chain, sign};

/// The sum of a shell's chains on one edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sum {
    pub(crate) shell: u32,
    pub(crate) edge: u32,
    pub(crate) sum: i32,
    /// Number of uses in either direction.
    pub(super) uses: u32,
    /// The first and the last face that use it.
    pub(crate) faces: [u32; 2],
}

impl Sum {
    /// Whether the number of uses is odd, so that no orientation of the faces makes the sum 0.
    pub(crate) fn is_free(&self) -> bool {
        self.uses % 2 == 1
    }

    /// The other one of two faces.
    pub(super) fn other(&self, face: usize) -> usize {
        let [first, last] = self.faces.map(|face| face as usize);
        if first == face { last } else { first }
    }
}

/// A face's chain and orientation.
pub(crate) struct TurnedFace<'a> {
    pub(crate) face: usize,
    pub(crate) shell: u32,
    pub(crate) reversed: bool,
    pub(crate) chain: &'a [(u32, i32)],
}

/// Sums the chains of faces, given in ascending order, by shell and edge. Returns the sums that are not 0, ascending.
/// The part has so many `edges`.
pub(crate) fn sums<'a>(edges: usize, faces: impl Iterator<Item = TurnedFace<'a>>) -> Vec<Sum> {
    let of_face = |face: TurnedFace<'a>| {
        let TurnedFace { face, shell, reversed, chain } = face;
        let use_of = move |&(edge, count): &(u32, i32)| Sum {
            shell,
            edge,
            sum: count * sign(reversed),
            uses: count.unsigned_abs(),
            faces: [u32::try_from(face).unwrap_or(u32::MAX); 2],
        };
        chain.iter().map(use_of)
    };
    let add = |sum: &mut Sum, next: &Sum| {
        sum.sum += next.sum;
        sum.uses += next.uses;
        sum.faces[1] = next.faces[0];
    };
    let mut sums = summed_by_pair(edges, faces.flat_map(of_face), |sum| (sum.shell, sum.edge), add);
    sums.retain(|sum| sum.sum != 0);
    sums
}

/// Whether a part is closed, as known before any mesh is made.
#[derive(Clone, Debug, Default)]
pub(crate) struct Closedness {
    /// Edges that their shell uses an odd number of times.
    pub(crate) free_edges: Vec<EdgeId>,
    /// Other edges on which the faces of a shell do not cancel.
    pub(crate) not_orientable: Vec<EdgeId>,
    /// Whether all shells' faces cancel on all edges, and all loops are closed chains of vertices.
    pub(crate) closed: bool,
}

impl Closedness {
    /// Classifies the edges of `sums`. `loops_close`: whether all loops of the part are closed.
    pub(crate) fn of(sums: &[Sum], loops_close: bool) -> Self {
        let of_kind = |free: bool| {
            let mut edges: Vec<EdgeId> = sums.iter().filter(|s| s.is_free() == free).map(|s| EdgeId(s.edge)).collect();
            edges.sort_unstable();
            edges.dedup();
            edges
        };
        Self { free_edges: of_kind(true), not_orientable: of_kind(false), closed: loops_close && sums.is_empty() }
    }

    /// Marks the edges of faces that got no tiles as free.
    pub(crate) fn lose(&mut self, faces: impl Iterator<Item = Chain>) {
        for chain in faces {
            self.closed = false;
            self.free_edges.extend(chain.into_iter().map(|(edge, _)| EdgeId(edge)));
        }
        self.free_edges.sort_unstable();
        self.free_edges.dedup();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;

    #[test]
    fn sums_are_those_of_all_uses_by_shell_and_edge() {
        let mut draw = SplitMix(2);
        for _ in 0..50 {
            let mut pick = |n: u64| u32::try_from(draw.below(n)).expect("small");
            let mut face = |_| {
                let chain: Vec<_> = (0..5).map(|_| (pick(20), if pick(2) == 0 { 1 } else { -2 })).collect();
                (pick(3), pick(2) == 0, chain)
            };
            let faces: Vec<_> = (0..40).map(&mut face).collect();
            let turned = faces.iter().enumerate().map(|(face, (shell, reversed, chain))| TurnedFace {
                face,
                shell: *shell,
                reversed: *reversed,
                chain,
            });
            let got = sums(20, turned);
            let mut expected = Vec::new();
            for (shell, edge) in (0..3).flat_map(|shell| (0..20).map(move |edge| (shell, edge))) {
                let of = faces.iter().enumerate().filter(|(_, face)| face.0 == shell);
                let uses: Vec<(usize, i32)> = of
                    .flat_map(|(k, (_, reversed, chain))| {
                        let of_edge = chain.iter().filter(|used| used.0 == edge);
                        of_edge.map(move |used| (k, used.1 * sign(*reversed)))
                    })
                    .collect();
                let sum: i32 = uses.iter().map(|used| used.1).sum();
                if let ([first, ..], true) = (&uses[..], sum != 0) {
                    let count: u32 = uses.iter().map(|used| used.1.unsigned_abs()).sum();
                    let ends = [first.0, uses[uses.len() - 1].0].map(|k| u32::try_from(k).expect("small"));
                    expected.push((shell, edge, sum, count, ends));
                }
            }
            let got: Vec<_> = got.iter().map(|s| (s.shell, s.edge, s.sum, s.uses, s.faces)).collect();
            assert_eq!(got, expected);
        }
    }
}
