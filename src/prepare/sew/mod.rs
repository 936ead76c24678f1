//! Adjacent faces with edges of their own -> faces that share edges.

mod overlap;
pub(super) mod pairs;
pub(super) mod sew_edges;
