//! Why an occurrence of a file cannot be placed.

/// Why an occurrence of a file cannot be placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlacementTrouble {
    /// The product definition to place is not in the file.
    #[error("the product definition to place is not in the file")]
    NoDefinition,
    /// The mapped representation has no bodies.
    #[error("the mapped representation #{representation} has no bodies")]
    NoBodies {
        /// The representation's entity number.
        representation: u64,
    },
    /// The transformation is not invertible.
    #[error("the transformation is not invertible")]
    NotInvertible,
}
