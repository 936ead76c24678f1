//! Diagnostics: a severity, the part, face or edge concerned, and a kind with its numbers.

use super::trouble::{
    BorderTrouble, FaceError, FaceTrouble, ShellTrouble, StepOutcome, StepTrouble, TileTrouble, WireTrouble,
};
use super::{EdgeId, FaceId, PartId};
use glam::DVec3;
use std::fmt;

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

/// Severity of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Nothing is lost; something was repaired or approximated.
    Note,
    /// Something other than geometry is lost (a colour, a name), a face differs from the file, or the mesh is coarser
    /// than asked.
    Warning,
    /// Geometry is lost or may be wrong: a face, a hole, an occurrence, the unit, or the mesh fails its check.
    Error,
}

impl Severity {
    /// The severity in one word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }

    /// Whether a diagnostic of this severity means that the mesh is not what the file states: an error does, a warning
    /// if it concerns a face. The program ends with status 3 then.
    #[must_use]
    pub fn is_fault(self, of_face: bool) -> bool {
        match self {
            Self::Error => true,
            Self::Warning => of_face,
            Self::Note => false,
        }
    }
}

/// Reports something that was not understood, repaired or lost.
///
/// ```
/// use trimtess::model::{Diagnostic, DiagnosticKind, FaceError, FaceId, FaceTrouble, Severity};
///
/// let kind = FaceTrouble::Unusable(FaceError::OffSurface { gap_mm: 2.0, extent_mm: 3.0 });
/// let told = Diagnostic { face: Some(FaceId(4)), ..Diagnostic::new(Severity::Error, kind) };
/// assert_eq!(told.kind.code(), "face-off-surface");
/// assert_eq!(told.to_string(), "edges lie 2.000e0 mm off the surface; the face is 3.000e0 mm across");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// How severe it is.
    pub severity: Severity,
    /// The part concerned.
    pub part: Option<PartId>,
    /// The face concerned (index within the part).
    pub face: Option<FaceId>,
    /// The edge concerned (index within the part).
    pub edge: Option<EdgeId>,
    /// Entity number in the source file, 0 if none.
    pub entity: u64,
    /// Where, in the part's coordinates (millimetres), if it has a place.
    pub place: Option<DVec3>,
    /// What happened and why, with numbers.
    pub kind: DiagnosticKind,
}

impl Diagnostic {
    /// Makes a diagnostic without part, face, edge, entity and place.
    /// `Diagnostic { face, ..Diagnostic::new(severity, kind) }` sets the face.
    #[must_use]
    pub fn new(severity: Severity, kind: impl Into<DiagnosticKind>) -> Self {
        Self { severity, part: None, face: None, edge: None, entity: 0, place: None, kind: kind.into() }
    }

    /// Whether the mesh is not what the file states ([`Severity::is_fault`]).
    #[must_use]
    pub fn is_fault(&self) -> bool {
        self.severity.is_fault(self.face.is_some())
    }
}

/// Writes the message of the kind.
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.kind.fmt(f)
    }
}
