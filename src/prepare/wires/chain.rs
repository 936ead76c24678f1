//! Integer chains of edges: forward uses minus reversed uses of each edge.

/// Edges with their forward uses minus reversed uses, ascending by edge. No entry is 0.
pub(crate) type Chain = Vec<(u32, i32)>;

/// Sorts uses by edge, sums those of the same edge and drops zeros.
pub(crate) fn summed(mut uses: Chain) -> Chain {
    uses.sort_unstable_by_key(|use_| use_.0);
    uses.dedup_by(|next, first| {
        let same = next.0 == first.0;
        first.1 += if same { next.1 } else { 0 };
        same
    });
    uses.retain(|use_| use_.1 != 0);
    uses
}
