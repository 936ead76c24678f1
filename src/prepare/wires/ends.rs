//! A coedge -> its start and end vertices.

use crate::model::{Coedge, Part, VertexId};

/// Start and end vertex in the coedge's own direction; `None` if the part has no such edge.
pub(crate) fn ends(part: &Part, c: &Coedge) -> Option<[VertexId; 2]> {
    let edge = part.edges.get(c.edge.index())?;
    Some(if c.reversed { [edge.end, edge.start] } else { [edge.start, edge.end] })
}
