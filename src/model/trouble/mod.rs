//! Kinds of diagnostics as data: enums with numbers, messages and codes.
//!
//! `Display` alone writes the messages. Codes are stable; `docs/diagnostics.md` lists them all.

/// Implements `code` and `codes`: a stable code for each variant, and the list of all. Neither can miss one. Variants
/// that wrap another such enum pass on its code; they follow the semicolon, with the type that they wrap.
macro_rules! codes {
    ($of:ident { $($pattern:pat => $code:literal),* $(; $($inner:ident in $outer:pat => $held:expr),*)? }) => {
        impl $of {
            /// The stable code, as in reports and `docs/diagnostics.md`.
            #[must_use]
            pub fn code(&self) -> &'static str {
                match self {
                    $($pattern => $code,)*
                    $($($outer => $held.code(),)*)?
                }
            }

            /// All codes, in the order of the variants.
            #[must_use]
            pub fn codes() -> Vec<&'static str> {
                let own: &[&'static str] = &[$($code),*];
                let inner: Vec<Vec<&'static str>> = vec![$($($inner::codes()),*)?];
                [own, &inner.concat()].concat()
            }
        }
    };
}

mod step;
pub use step::{
    BodyRefusal, CurveTrouble, FitTrouble, PlacementTrouble, SolidTrouble, StepCause, StepTrouble, SyntaxError,
    SyntaxFault, SyntaxRepair,
};

mod step_outcome;
pub use step_outcome::{StepOutcome, SyntaxCut};

mod face;
pub use face::{FaceError, FaceTrouble, RegionError, TileTrouble, TrimTrouble};

mod topology;
pub use topology::{BorderTrouble, ShellTrouble, WireTrouble};
