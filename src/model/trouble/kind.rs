//! All kinds of diagnostics, by stage.

use super::border::BorderTrouble;
use super::face::FaceTrouble;
use super::face_error::FaceError;
use super::shell::ShellTrouble;
use super::step::{StepOutcome, StepTrouble};
use super::tile::TileTrouble;
use super::wire::WireTrouble;
use crate::model::PartId;

/// Kind of a diagnostic, with numbers: one enum per stage.
///
/// `Display` writes the message; [`code`](Self::code) is a stable name for programs. Lengths are millimetres in the
/// part's coordinates.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DiagnosticKind {
    /// Prepare: an instance refers to a part that does not exist and was left out.
    #[error("instance \"{instance}\" refers to part {}; the model has {parts}", .part.0)]
    NoPart {
        /// The instance's name.
        instance: String,
        /// The part that it refers to.
        part: PartId,
        /// How many parts there are.
        parts: usize,
    },
    /// The STEP reader.
    #[error(transparent)]
    Step(#[from] StepOutcome),
    /// Prepare: a face.
    #[error(transparent)]
    Face(#[from] FaceTrouble),
    /// Prepare: a face's wires.
    #[error(transparent)]
    Wire(#[from] WireTrouble),
    /// Prepare: edges that lie together.
    #[error(transparent)]
    Border(#[from] BorderTrouble),
    /// Prepare: a shell.
    #[error(transparent)]
    Shell(#[from] ShellTrouble),
    /// Frame: a tile or an edge.
    #[error("{first}{}", more_like_it(*.others))]
    Tile {
        /// The first tile of the face with this kind of trouble.
        first: TileTrouble,
        /// How many more tiles of the face have it.
        others: u32,
    },
}

codes!(DiagnosticKind {
    Self::NoPart { .. } => "instance-without-part";
    StepOutcome in Self::Step(step) => step,
    FaceTrouble in Self::Face(face) => face,
    WireTrouble in Self::Wire(wire) => wire,
    BorderTrouble in Self::Border(border) => border,
    ShellTrouble in Self::Shell(shell) => shell,
    TileTrouble in Self::Tile { first, .. } => first
});

/// So many more tiles, if there are any.
fn more_like_it(others: u32) -> String {
    if others == 0 { String::new() } else { format!("; {others} more tiles like it") }
}

impl From<TileTrouble> for DiagnosticKind {
    fn from(first: TileTrouble) -> Self {
        Self::Tile { first, others: 0 }
    }
}

impl DiagnosticKind {
    /// Why a face could not be meshed as stated, if it has no tiles or is filled in space.
    #[must_use]
    pub fn face_error(&self) -> Option<&FaceError> {
        match self {
            Self::Face(FaceTrouble::Unusable(error) | FaceTrouble::Filled { cause: error, .. }) => Some(error),
            _ => None,
        }
    }

    /// Why an instance of a STEP file was not read, whether the reader or prepare reports it.
    #[must_use]
    pub fn step_trouble(&self) -> Option<&StepTrouble> {
        match (self, self.face_error()) {
            (Self::Step(step), _) => step.trouble(),
            (_, Some(FaceError::Refused(cause))) => Some(&cause.trouble),
            _ => None,
        }
    }
}
