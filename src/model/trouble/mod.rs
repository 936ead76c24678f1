//! Kinds of diagnostics as data: enums with numbers, messages and codes.
//!
//! `Display` alone writes the messages. Codes are stable; `docs/diagnostics.md` lists them all.

#[macro_use]
mod codes;

mod region_error;

mod step;
pub use face_error::FaceError;
pub use region_error::RegionError;
pub use step::{
    BodyRefusal, CurveTrouble, FitTrouble, PlacementTrouble, SolidTrouble, StepCause, StepOutcome, StepTrouble,
    SyntaxCut, SyntaxError, SyntaxFault, SyntaxRepair,
};

mod face_error;

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
