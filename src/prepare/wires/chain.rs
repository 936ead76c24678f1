//! Integer chains of edges: forward uses minus reversed uses of each edge.

use crate::math::keyed::sums_by_key;

/// Edges with their forward uses minus reversed uses, ascending by edge. No entry is 0.
pub(crate) type Chain = Vec<(u32, i32)>;

/// Sorts uses by edge, sums those of the same edge and drops zeros.
pub(crate) fn summed(uses: Chain) -> Chain {
    let mut uses = sums_by_key(uses);
    uses.retain(|use_| use_.1 != 0);
    uses
}
