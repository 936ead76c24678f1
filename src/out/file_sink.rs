//! Batches to a file: collects a frame, writes it when the frame is complete.

use super::levels::MeshLevel;
use super::pending::{PendingFile, cannot_write};
use super::save::Made;
use super::{Format, SaveOptions, UnknownFormat};
use crate::control::{Alone, Call, Control};
use crate::mesh::{Batch, EdgeLine, MemorySink, MeshLists, MeshSink, Scene, SinkError, TileMesh};
use std::io;
use std::path::{Path, PathBuf};

/// Creates a sink that writes `path` in the format of its extension. The file system is first touched by `begin`.
///
/// What rounding costs is not reported, see [`FileSink`].
///
/// # Errors
/// If the extension is missing or unknown.
pub fn open(path: &Path) -> Result<FileSink, UnknownFormat> {
    Ok(FileSink::new(path, Format::of_path(path)?))
}

/// Collects a frame and writes it at `end`, on the caller's thread. Holds all triangles until then, because file
/// headers contain counts and instances share the triangles of their part.
///
/// Rounding to the format's numbers may leave out triangles and whole faces, as in STL far from the origin. The sink
/// does not tell; [`save_on`](super::save_on) returns the [`Rounding`](super::Rounding), limits it, and can be
/// cancelled.
#[derive(Debug)]
pub struct FileSink {
    path: PathBuf,
    format: Format,
    frame: MemorySink,
    pending: Option<PendingFile>,
}

impl FileSink {
    /// Creates a sink that writes `format` to `path`, whatever its extension.
    #[must_use]
    pub fn new(path: &Path, format: Format) -> Self {
        Self { path: path.to_owned(), format, frame: MemorySink::default(), pending: None }
    }
}

impl MeshSink for FileSink {
    /// No format stores more.
    fn reads(&self) -> MeshLists {
        MeshLists::NONE
    }

    /// Creates the temporary file, so that a folder that cannot be written to is reported before any work is done.
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.pending = Some(PendingFile::create(&self.path)?);
        self.frame.begin(scene)
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        // They come all the same if another sink passes them on, and would take a third of the memory.
        let TileMesh { uvs, lines, origins, .. } = &mut batch.mesh;
        (*uvs, *lines, *origins) = Default::default();
        self.frame.batch(batch)
    }

    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError> {
        self.frame.edge_line(line)
    }

    fn end(&mut self) -> Result<(), SinkError> {
        let pending = match self.pending.take() {
            Some(pending) => pending,
            None => PendingFile::create(&self.path)?,
        };
        let (control, frame) = (Control::default(), (&self.frame).into());
        let level = [MeshLevel { frame, chord: 0.0 }];
        let made = Made::of(Call::new(&Alone, &control), &level, &SaveOptions::new(self.format));
        let Made { making, pieces, .. } =
            made.map_err(|failure| cannot_write(&self.path, io::Error::new(io::ErrorKind::InvalidData, failure)))?;
        pending.publish(|file| making.write(pieces, file))?;
        self.frame = MemorySink::default();
        Ok(())
    }

    fn abort(&mut self) {
        self.pending = None;
        self.frame = MemorySink::default();
    }
}
