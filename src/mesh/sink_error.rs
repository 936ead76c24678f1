//! Why a sink cannot take a frame.

use std::fmt;

/// Why a sink failed, usually I/O.
#[derive(Debug)]
pub struct SinkError {
    /// What the sink was doing (a path, a buffer).
    pub context: String,
    /// The cause.
    pub cause: std::io::Error,
}

impl fmt::Display for SinkError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.context, self.cause)
    }
}

impl std::error::Error for SinkError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.cause)
    }
}
