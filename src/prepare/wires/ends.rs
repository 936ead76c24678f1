//! An edge in either direction -> its start and end vertices.

use crate::model::{Coedge, EdgeId, Part, VertexId};

/// Start and end vertex of an edge, or of its reverse; `None` if the part has no such edge.
pub(crate) fn ends(part: &Part, edge: EdgeId, reversed: bool) -> Option<[VertexId; 2]> {
    part.edges.get(edge.index()).map(|edge| edge.ends(reversed))
}

/// [`ends`] of each coedge; `None` if the part lacks one of the edges.
pub(crate) fn ends_of_all(part: &Part, coedges: &[Coedge]) -> Option<Vec<[VertexId; 2]>> {
    coedges.iter().map(|c| ends(part, c.edge, c.reversed)).collect()
}
