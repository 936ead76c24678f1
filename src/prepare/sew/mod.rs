//! Adjacent faces with edges of their own -> faces that share edges.

pub(super) mod uses;
pub(super) mod candidate;
pub(super) mod pairs;
pub(super) mod overlap;
pub(super) mod slivers;
pub(super) mod carry;
pub(super) mod sew_edges;
