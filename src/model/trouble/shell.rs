//! What is wrong with a shell as a whole.

use crate::model::{EdgeId, FaceId};

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
