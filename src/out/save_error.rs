//! Why a file is not written.

use super::levels::UnfitLevel;
use super::rounding::RoundedTooFar;
use super::single::BeyondSingle;
use crate::mesh::SinkError;
use std::io;

/// Why a mesh was not written. A path then has the file that it had before.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SaveError {
    /// The work was [cancelled](crate::control::Control::cancel).
    #[error("writing was cancelled")]
    Cancelled,
    /// Rounding to the format's numbers moves a vertex too far. Nothing was written.
    #[error(transparent)]
    RoundedTooFar(#[from] RoundedTooFar),
    /// A position overflows the format's single precision. Nothing was written.
    #[error(transparent)]
    BeyondSingle(#[from] BeyondSingle),
    /// The levels of detail are not of one scene, or the format has no levels. Nothing was written.
    #[error(transparent)]
    UnfitLevel(#[from] UnfitLevel),
    /// The format cannot count as many. Nothing was written.
    #[error("{count} {of} exceed the limit of the format, {most}")]
    TooMany {
        /// Number of them.
        count: u64,
        /// What the format counts: "vertices", "triangles" or "bytes".
        of: &'static str,
        /// Maximum number.
        most: u64,
    },
    /// A file cannot be created, written or renamed.
    #[error(transparent)]
    File(#[from] SinkError),
    /// The caller's [`Write`](std::io::Write) refused.
    #[error("cannot write: {0}")]
    Io(io::Error),
}

impl From<io::Error> for SaveError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Checks that the format can count as many.
pub(super) fn counted(count: u64, of: &'static str) -> Result<u32, SaveError> {
    u32::try_from(count).map_err(|_| SaveError::TooMany { count, of, most: u32::MAX.into() })
}
