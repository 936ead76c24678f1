//! An edge in either direction -> its start and end vertices.

use crate::model::{EdgeId, Part, VertexId};

/// Start and end vertex of an edge, or of its reverse; `None` if the part has no such edge.
pub(crate) fn ends(part: &Part, edge: EdgeId, reversed: bool) -> Option<[VertexId; 2]> {
    let edge = part.edges.get(edge.index())?;
    Some(if reversed { [edge.end, edge.start] } else { [edge.start, edge.end] })
}
