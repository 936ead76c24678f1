//! The door through which triangles leave.

use super::{Batch, Drawn, EdgeLine, Scene};
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

/// Receives frames of triangles.
///
/// Calls come in the order `begin` or `begin_changes`, (`batch` | `edge_line`)*, `drawn`, then `end` or `abort`, all from one thread
/// (the render thread). Batches arrive sorted by (part, tile), then lines by (part, edge), whatever the number of workers.
pub trait MeshSink: Send {
    /// A whole frame starts: what was sent before is void. Tiles without triangles are not sent.
    ///
    /// # Errors
    /// When the sink cannot take the frame; `abort` follows.
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError>;

    /// A frame starts that is the last one that ended, but for what is sent now: batches replace those of their tiles, and have
    /// no triangles where a tile lost all of its; lines replace those of their edges. Parts and what they are made of stay;
    /// their instances may have changed.
    ///
    /// # Errors
    /// When the sink takes whole frames only, as files do and as this method does unless it is implemented; `abort` follows.
    fn begin_changes(&mut self, scene: &Scene) -> Result<(), SinkError> {
        let context = format!("changes of {:?} for a sink of whole frames", scene.name);
        Err(SinkError { context, cause: std::io::ErrorKind::Unsupported.into() })
    }

    /// The triangles of one tile. Instances share their part's batches. A sink that keeps the mesh takes it out
    /// ([`std::mem::take`]); buffers that it leaves are used again for coming tiles.
    ///
    /// # Errors
    /// When the sink cannot take the batch; `abort` follows.
    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError>;

    /// The polyline of one B-rep edge.
    ///
    /// # Errors
    /// When the sink cannot take the line; `abort` follows.
    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError>;

    /// Which tiles are to be drawn, once in each frame that is made for views. Edges between tiles that are drawn are without cracks;
    /// a tile that is not drawn may still be as it was several frames ago. Frames made without views draw everything and do
    /// not say so.
    ///
    /// # Errors
    /// When the sink cannot take it; `abort` follows.
    fn drawn(&mut self, _drawn: &Drawn) -> Result<(), SinkError> {
        Ok(())
    }

    /// The frame is complete: files appear whole now.
    ///
    /// # Errors
    /// When the result cannot be finished; `abort` follows.
    fn end(&mut self) -> Result<(), SinkError>;

    /// The frame will not be completed: leave nothing half-written. A whole frame comes next, if any.
    fn abort(&mut self);
}

/// So that sinks chosen at run time fit where a sink's type is asked for.
impl<S: MeshSink + ?Sized> MeshSink for Box<S> {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        (**self).begin(scene)
    }

    fn begin_changes(&mut self, scene: &Scene) -> Result<(), SinkError> {
        (**self).begin_changes(scene)
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        (**self).batch(batch)
    }

    fn drawn(&mut self, drawn: &Drawn) -> Result<(), SinkError> {
        (**self).drawn(drawn)
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
    /// Which of its tiles are drawn; empty for frames that draw everything.
    pub drawn: Drawn,
    changes: Changes,
}

impl MemorySink {
    /// A frame that draws everything: batches sorted by (part, tile), lines by (part, edge).
    #[must_use]
    pub fn of(scene: Scene, batches: Vec<Batch>, edge_lines: Vec<EdgeLine>) -> Self {
        Self { scene, batches, edge_lines, ..Self::default() }
    }
}

/// What a frame has said so far that is only about changes.
#[derive(Clone, Debug, Default)]
struct Changes {
    only: bool,
    batches: Vec<Batch>,
    edge_lines: Vec<EdgeLine>,
}

/// Sorted rows with those of `new` put in or in place of their own.
fn replaced<T, K: Ord>(old: &mut Vec<T>, new: Vec<T>, key: impl Fn(&T) -> K) {
    let mut out = Vec::with_capacity(old.len() + new.len());
    let mut rest = std::mem::take(old).into_iter().peekable();
    for row in new {
        while let Some(before) = rest.next_if(|r| key(r) < key(&row)) {
            out.push(before);
        }
        rest.next_if(|r| key(r) == key(&row));
        out.push(row);
    }
    out.extend(rest);
    *old = out;
}

impl MeshSink for MemorySink {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        *self = Self { scene: scene.clone(), ..Self::default() };
        Ok(())
    }

    fn begin_changes(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.scene = scene.clone();
        self.changes = Changes { only: true, ..Changes::default() };
        Ok(())
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        let batches = if self.changes.only { &mut self.changes.batches } else { &mut self.batches };
        batches.push(Batch { mesh: std::mem::take(&mut batch.mesh), ..*batch });
        Ok(())
    }

    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError> {
        let lines = if self.changes.only { &mut self.changes.edge_lines } else { &mut self.edge_lines };
        lines.push(line);
        Ok(())
    }

    fn drawn(&mut self, drawn: &Drawn) -> Result<(), SinkError> {
        self.drawn = drawn.clone();
        Ok(())
    }

    fn end(&mut self) -> Result<(), SinkError> {
        let Changes { only, batches, edge_lines } = std::mem::take(&mut self.changes);
        if only {
            replaced(&mut self.batches, batches, |b| (b.part, b.tile));
            replaced(&mut self.edge_lines, edge_lines, |l| (l.part, l.edge));
            self.batches.retain(|batch| !batch.mesh.triangles.is_empty());
        }
        Ok(())
    }

    fn abort(&mut self) {
        *self = Self::default();
    }
}
