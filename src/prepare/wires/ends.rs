//! A coedge -> the vertices at its ends, in its own direction.

use crate::model::{Coedge, Part, VertexId};

/// Start and end of a coedge; none where it names what is not there.
pub(crate) fn ends(part: &Part, c: &Coedge) -> Option<[VertexId; 2]> {
    let edge = part.edges.get(c.edge.index())?;
    Some(if c.reversed { [edge.end, edge.start] } else { [edge.start, edge.end] })
}
