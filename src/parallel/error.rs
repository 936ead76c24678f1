//! Why a session does not start, or a frame is not made.

use crate::mesh::{GridTooCoarse, SinkError};
use std::fmt;

/// Why a session did not start: the operating system refused a thread.
#[derive(Debug)]
#[non_exhaustive]
pub struct StartError {
    /// The system's error.
    pub cause: std::io::Error,
}

impl fmt::Display for StartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot start threads: {}", self.cause)
    }
}

impl std::error::Error for StartError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.cause)
    }
}

/// Why a frame was not committed. If the sink was fed, [`MeshSink::abort`](crate::mesh::MeshSink::abort) was called.
#[derive(Debug)]
#[non_exhaustive]
pub enum FrameError {
    /// The system refused a thread.
    Start(StartError),
    /// The sink refused, or panicked.
    Sink(SinkError),
    /// A tile does not fit the grid that the sink's layout asks for. The sink was not touched.
    Grid(GridTooCoarse),
    /// An internal error. The session cannot be used any more.
    Lost {
        /// The message of the panic.
        why: String,
    },
    /// The work was [cancelled](crate::control::Control::cancel).
    Cancelled,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Start(error) => error.fmt(f),
            Self::Sink(error) => error.fmt(f),
            Self::Grid(error) => error.fmt(f),
            Self::Lost { why } => write!(f, "an internal error ended the session: {why}"),
            Self::Cancelled => f.write_str("tessellating was cancelled"),
        }
    }
}

impl std::error::Error for FrameError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Start(error) => Some(error),
            Self::Sink(error) => Some(error),
            Self::Grid(error) => Some(error),
            Self::Lost { .. } | Self::Cancelled => None,
        }
    }
}
