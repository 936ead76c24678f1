//! Findings about a face, before they have a face number and a severity.

use crate::model::{DiagnosticKind, EdgeId, Part};
use glam::DVec3;

/// A finding about a face, and where it applies.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Finding {
    pub(crate) edge: Option<EdgeId>,
    pub(crate) place: Option<DVec3>,
    pub(crate) what: DiagnosticKind,
}

impl Finding {
    pub(crate) fn new(place: Option<DVec3>, what: impl Into<DiagnosticKind>) -> Self {
        Self { edge: None, place, what: what.into() }
    }

    /// A finding about an edge, at its start.
    pub(crate) fn at_edge(part: &Part, edge: u32, what: impl Into<DiagnosticKind>) -> Self {
        let start = part.vertices.get(part.edges[edge as usize].start.index());
        Self { edge: Some(EdgeId(edge)), ..Self::new(start.copied(), what) }
    }
}
