//! An edge that may coincide with another, before they are compared.

use crate::model::{Edge, Part};

/// An edge that may coincide with another.
pub(crate) struct Candidate {
    pub(crate) edge: u32,
    pub(crate) shell: u32,
    pub(crate) tolerance: f64,
    /// A face that uses it.
    pub(crate) face: usize,
    /// Whether it bounds a face without topology, and runs along a side of that face's domain.
    pub(crate) untold: bool,
    pub(crate) side: bool,
    /// Of a face with topology in an open shell: whether the face, seen from outside, has the edge in reverse.
    pub(crate) against: Option<bool>,
}

impl Candidate {
    /// Whether its face may have a common edge with that of another. Faces of an open shell, which nothing orients,
    /// need opposite directions there: sheets on top of each other would become a closed body, and one would be turned
    /// over.
    pub(crate) fn may_adjoin(&self, other: &Self, same_direction: bool) -> bool {
        let (Some(one), Some(other)) = (self.against, other.against) else { return true };
        (one == other) != same_direction
    }
}

/// Whether an edge has a valid curve, range and vertices.
pub(crate) fn is_sound(part: &Part, e: &Edge) -> bool {
    let stated = e.range.0 < e.range.1 && e.curve.check().is_ok();
    let (low, high) = e.curve.domain();
    let ends = [e.start, e.end].map(|v| part.vertices.get(v.index()));
    stated && e.range.0 >= low && e.range.1 <= high && ends.iter().all(|p| p.is_some_and(|p| p.is_finite()))
}
