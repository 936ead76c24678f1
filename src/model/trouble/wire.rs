//! Repairs of wires that do not close.

/// Repair of a wire that does not close, or of an edge that misses its vertex.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WireTrouble {
    /// The edges of a wire close only in another order and were reordered.
    #[error("the {edges} edges of a wire close only in another order{}; they were reordered", reversed(*.turned))]
    Reordered {
        /// How many edges it has.
        edges: usize,
        /// How many of them were reversed.
        turned: usize,
    },
    /// Gaps were closed by moving vertices. A note within the part's tolerance, a warning beyond.
    #[error(
        "gaps of up to {width_mm:.3e} mm in its wires were closed by moving vertices, {} the tolerance of \
         {tolerance_mm:.1e} mm",
        if .width_mm <= .tolerance_mm { "within" } else { "beyond" }
    )]
    VerticesMoved {
        /// The widest gap, millimetres.
        width_mm: f64,
        /// The part's tolerance, millimetres.
        tolerance_mm: f64,
    },
    /// Gaps were bridged by straight lines in (u,v).
    #[error("a wire has a gap of {width_mm:.3e} mm{}; it was bridged by a straight line in (u,v)", widest_of(*.gaps))]
    Bridged {
        /// The widest gap, millimetres.
        width_mm: f64,
        /// How many gaps the face has.
        gaps: usize,
    },
    /// Edges across gaps have no counterpart in another face; the gaps were filled.
    #[error("{edges} edges across gaps of wires have no counterpart and were filled")]
    BridgesFilled {
        /// How many edges.
        edges: usize,
    },
    /// A face of a closed surface runs along all its edges as its neighbours do; its wires were reversed.
    #[error(
        "the face runs along all of its {edges} edges as its neighbours do, not against them; its wires were reversed"
    )]
    AgainstNeighbours {
        /// How many edges.
        edges: usize,
    },
    /// A face of a closed surface is in a shell whose planes and cylinders all have wires that run clockwise; its wires
    /// were reversed, too.
    #[error("the wires of all {faces} planes and cylinders of its shell run clockwise; its wires were reversed, too")]
    AgainstPlanes {
        /// How many planes and cylinders.
        faces: usize,
    },
    /// A face of a closed surface is in a shell whose only plane or cylinder has wires that run clockwise: one of the two
    /// may be the other side of its wires.
    #[error(
        "the wires of the only plane or cylinder of its shell run clockwise; it may be the other side of its wires"
    )]
    SideUnsure,
    /// A face of a closed surface would lie on its neighbours along all its edges; its wires were reversed.
    #[error("the face would lie on its neighbours along all of its {edges} edges; its wires were reversed")]
    FoldsBack {
        /// How many edges.
        edges: usize,
    },
    /// An edge misses its vertex; the mesh uses the vertex.
    #[error("an edge misses its vertex by {gap_mm:.3e} mm; the mesh uses the vertex")]
    EdgeOffVertex {
        /// By how much, millimetres.
        gap_mm: f64,
    },
}

/// How many edges were reversed, if any.
fn reversed(turned: usize) -> String {
    if turned == 0 { String::new() } else { format!(", {turned} of them reversed") }
}

/// That a gap is the widest of several.
fn widest_of(gaps: usize) -> String {
    if gaps > 1 { format!(", the widest of {gaps}") } else { String::new() }
}

codes!(WireTrouble {
    Self::Reordered { .. } => "wire-out-of-order",
    Self::VerticesMoved { .. } => "wire-gaps-closed",
    Self::Bridged { .. } => "wire-gap-bridged",
    Self::BridgesFilled { .. } => "wire-gaps-filled",
    Self::AgainstNeighbours { .. } => "wire-against-neighbours",
    Self::AgainstPlanes { .. } => "wire-against-planes",
    Self::SideUnsure => "wire-side-unsure",
    Self::FoldsBack { .. } => "wire-folds-back",
    Self::EdgeOffVertex { .. } => "edge-misses-vertex"
});
