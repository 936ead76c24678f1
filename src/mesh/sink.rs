//! The door through which triangles leave.

use super::{Batch, EdgeLine, Scene};
use std::fmt;

/// Why a sink gave up: I/O mostly.
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

/// Receives one frame's triangles. Calls come in the order `begin`, (`batch` | `edge_line`)*, then `end` or `abort`,
/// all from one thread (the render thread). Batches arrive sorted by (part, tile), whatever the number of workers.
pub trait MeshSink: Send {
    /// A frame starts.
    ///
    /// # Errors
    /// When the sink cannot take the frame; `abort` follows.
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError>;

    /// The triangles of one tile. Instances share their part's batches.
    ///
    /// # Errors
    /// When the sink cannot take the batch; `abort` follows.
    fn batch(&mut self, batch: Batch) -> Result<(), SinkError>;

    /// The polyline of one B-rep edge.
    ///
    /// # Errors
    /// When the sink cannot take the line; `abort` follows.
    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError>;

    /// The frame is complete: files appear whole now.
    ///
    /// # Errors
    /// When the result cannot be finished; `abort` follows.
    fn end(&mut self) -> Result<(), SinkError>;

    /// The frame will not be completed: leave nothing half-written.
    fn abort(&mut self);
}

/// So that sinks chosen at run time fit where a sink's type is asked for.
impl<S: MeshSink + ?Sized> MeshSink for Box<S> {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        (**self).begin(scene)
    }

    fn batch(&mut self, batch: Batch) -> Result<(), SinkError> {
        (**self).batch(batch)
    }

    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError> {
        (**self).edge_line(line)
    }

    fn end(&mut self) -> Result<(), SinkError> {
        (**self).end()
    }

    fn abort(&mut self) {
        (**self).abort();
    }
}

/// Keeps everything in memory.
#[derive(Clone, Debug, Default)]
pub struct MemorySink {
    /// The scene of the last frame.
    pub scene: Scene,
    /// Its batches, sorted by (part, tile).
    pub batches: Vec<Batch>,
    /// Its edge polylines, sorted by (part, edge).
    pub edge_lines: Vec<EdgeLine>,
}

impl MeshSink for MemorySink {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.scene = scene.clone();
        self.batches.clear();
        self.edge_lines.clear();
        Ok(())
    }

    fn batch(&mut self, batch: Batch) -> Result<(), SinkError> {
        self.batches.push(batch);
        Ok(())
    }

    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError> {
        self.edge_lines.push(line);
        Ok(())
    }

    fn end(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    fn abort(&mut self) {
        self.batches.clear();
        self.edge_lines.clear();
    }
}
