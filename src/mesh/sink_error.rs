//! Why a sink cannot take a frame.

/// Why a sink failed, usually I/O.
#[derive(Debug, thiserror::Error)]
#[error("{context}: {cause}")]
pub struct SinkError {
    /// What the sink was doing (a path, a buffer).
    pub context: String,
    /// The cause.
    #[source]
    pub cause: std::io::Error,
}
