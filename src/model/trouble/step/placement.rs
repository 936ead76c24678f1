//! Why an occurrence of a file cannot be placed.

use std::fmt;

/// Why an occurrence of a file cannot be placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PlacementTrouble {
    /// The product definition to place is not in the file.
    NoDefinition,
    /// The mapped representation has no bodies.
    NoBodies {
        /// The representation's entity number.
        representation: u64,
    },
    /// The transformation is not invertible.
    NotInvertible,
}

impl fmt::Display for PlacementTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDefinition => write!(f, "the product definition to place is not in the file"),
            Self::NoBodies { representation } => {
                write!(f, "the mapped representation #{representation} has no bodies")
            }
            Self::NotInvertible => write!(f, "the transformation is not invertible"),
        }
    }
}
