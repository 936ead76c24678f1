//! What can be wrong with a model and its mesh, as data: a kind with numbers, its words and its code.
//!
//! The words of a kind come from its `Display` alone. Codes are stable; `docs/diagnostics.md` lists them all.

#[macro_use]
mod codes;

mod face_error;
mod region_error;
mod step;
pub use face_error::FaceError;
pub use region_error::RegionError;
pub use step::{
    BodyRefusal, CurveTrouble, FitTrouble, PlacementTrouble, SolidTrouble, SplineTrouble, StepCause, StepOutcome,
    StepTrouble, SyntaxCut,
};

mod trim;
pub use trim::TrimTrouble;

mod face;
pub use face::FaceTrouble;

mod wire;
pub use wire::WireTrouble;

mod border;
pub use border::BorderTrouble;

mod shell;
pub use shell::ShellTrouble;

mod tile;
pub use tile::TileTrouble;

mod kind;
pub use kind::DiagnosticKind;
