//! Findings about a face, before they have a face number and a severity.

use crate::model::{DiagnosticKind, EdgeId};
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
}
