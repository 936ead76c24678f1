//! Why an occurrence of a file cannot be placed.

use std::fmt;

/// Why an occurrence of a file cannot be placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PlacementTrouble {
    /// The product definition that it places is not in the file.
    NoDefinition,
    /// The representation that it maps holds no bodies.
    NoBodies {
        /// The representation's entity number.
        representation: u64,
    },
    /// Its transformation cannot be inverted.
    NotInvertible,
}

impl fmt::Display for PlacementTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDefinition => write!(f, "the product definition that it places is not in the file"),
            Self::NoBodies { representation } => {
                write!(f, "the mapped representation #{representation} holds no bodies")
            }
            Self::NotInvertible => write!(f, "a transformation that cannot be inverted"),
        }
    }
}
