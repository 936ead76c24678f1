//! Integer chains of edges: how often each is used along its direction, less how often against it.

/// Edges with how often they are used along their direction, less how often against it: ascending, none of them 0.
pub(crate) type Chain = Vec<(u32, i32)>;

/// Adds up what a chain has of each edge.
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
