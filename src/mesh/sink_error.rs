//! Why a sink cannot take a frame.

/// Why a sink failed, usually I/O.
#[derive(Debug, thiserror::Error)]
#[error("{context}: {cause}")]
#[non_exhaustive]
pub struct SinkError {
    /// What the sink was doing (a path, a buffer).
    pub context: String,
    /// The cause.
    pub cause: std::io::Error,
}

impl SinkError {
    /// An error of a sink that was doing `context` (a path, a buffer).
    ///
    /// ```
    /// use std::io::{Error, ErrorKind};
    /// use trimtess::mesh::SinkError;
    ///
    /// assert_eq!(SinkError::new("vertex buffer", ErrorKind::OutOfMemory).to_string(), "vertex buffer: out of memory");
    /// assert_eq!(SinkError::new("a.obj", Error::other("disk is full")).to_string(), "a.obj: disk is full");
    /// ```
    #[must_use]
    pub fn new(context: impl Into<String>, cause: impl Into<std::io::Error>) -> Self {
        Self { context: context.into(), cause: cause.into() }
    }
}
