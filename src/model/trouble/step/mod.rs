//! Diagnostics of the STEP reader: what it could not read, and what it did instead.

mod curve;
pub use curve::CurveTrouble;

mod fit;
pub use fit::FitTrouble;

mod solid;
pub use solid::{BodyRefusal, SolidTrouble};

mod placement;
pub use placement::PlacementTrouble;

mod trouble;
pub use trouble::{StepCause, StepTrouble};

mod syntax;
pub use syntax::{SyntaxError, SyntaxFault, SyntaxRepair};

mod outcome;
pub use outcome::{StepOutcome, SyntaxCut};
