//! Defects and repairs of wires, of edges that lie together, and of shells.

use crate::model::{EdgeId, FaceId};

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
    /// A face of a closed surface is in a shell whose only plane or cylinder has wires that run clockwise: one of the
    /// two may be the other side of its wires.
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

/// Outcome of sewing edges of different faces that lie together.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BorderTrouble {
    /// Edges of a shell within its tolerance were merged.
    #[error(
        "{pairs} pairs of edges of its shell, up to {width_mm:.3e} mm apart, were merged (tolerance {tolerance_mm:.1e} \
         mm)"
    )]
    Sewn {
        /// How many pairs.
        pairs: usize,
        /// Largest distance between merged edges, millimetres.
        width_mm: f64,
        /// The tolerance, millimetres.
        tolerance_mm: f64,
    },
    /// Edges on both sides of a face lie within the tolerance; they were not merged.
    #[error("edges on both sides of it, within the tolerance of {tolerance_mm:.1e} mm, were not merged")]
    ThinFace {
        /// The tolerance, millimetres.
        tolerance_mm: f64,
    },
    /// Too many edges lie together; some pairs were not compared.
    #[error("{pairs} pairs of edges of its shell were not compared: more than {limit} lie together")]
    NotCompared {
        /// How many pairs.
        pairs: usize,
        /// Maximum number of partners that each edge is compared with.
        limit: usize,
    },
    /// Borders of faces without topology were merged into shared edges.
    #[error("{pairs} pairs of borders of faces without topology, up to {width_mm:.3e} mm apart, were merged")]
    Joined {
        /// How many pairs.
        pairs: usize,
        /// Largest distance between merged borders, millimetres.
        width_mm: f64,
    },
}

codes!(BorderTrouble {
    Self::Sewn { .. } => "edges-sewn",
    Self::ThinFace { .. } => "face-thinner-than-tolerance",
    Self::NotCompared { .. } => "edges-not-compared",
    Self::Joined { .. } => "borders-joined"
});

/// What is wrong with a shell as a whole.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShellTrouble {
    /// Connected faces of a solid were inside out and were flipped.
    #[error("{faces} connected faces were inside out (volume {volume_mm3:.3e} mm³) and were flipped")]
    InsideOut {
        /// How many faces.
        faces: usize,
        /// The volume that they enclose in the file's orientation, mm³.
        volume_mm3: f64,
    },
    /// Connected faces of a void lie outside of its solid. They bound a body, and point outwards.
    #[error("{faces} connected faces of a void lie outside of its solid and bound a body of their own")]
    VoidOutside {
        /// How many faces.
        faces: usize,
    },
    /// Connected faces of a solid enclose no volume.
    #[error("{faces} connected faces of a solid enclose no volume")]
    NoVolume {
        /// How many faces.
        faces: usize,
    },
    /// The shell of a solid is open.
    #[error("the shell of a solid is open: {free} of its {edges} edges have a face on one side only")]
    Open {
        /// Edges with a face on one side only.
        free: usize,
        /// All edges of the shell.
        edges: usize,
    },
    /// No orientation of the faces makes them run along every shared edge in opposite directions.
    #[error(
        "{edges} edges cannot be oriented: their faces run along them the same way, however they are flipped; the \
         first is edge {} of faces {} and {}",
        .edge.0, .faces[0].0, .faces[1].0
    )]
    NotOrientable {
        /// How many edges.
        edges: usize,
        /// The first of them.
        edge: EdgeId,
        /// The first and the last face that use it.
        faces: [FaceId; 2],
    },
}

codes!(ShellTrouble {
    Self::InsideOut { .. } => "shell-inside-out",
    Self::VoidOutside { .. } => "shell-void-outside",
    Self::NoVolume { .. } => "shell-without-volume",
    Self::Open { .. } => "shell-open",
    Self::NotOrientable { .. } => "shell-not-orientable"
});
