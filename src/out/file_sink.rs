//! Batches to a file: collects a frame, writes it when the frame is complete.

#[cfg(feature = "glb")]
use super::glb::glb_levels;
#[cfg(feature = "glb")]
use super::glb_levels::GlbLevel;
#[cfg(feature = "glb")]
use super::glb_options::GlbOptions;
use super::pending::{Outputs, PendingFile, cannot_write};
use super::plain::{Pieces, write_alone};
use super::rounding::Rounding;
use super::{Format, UnknownFormat};
use crate::control::{Call, Control, Rayon};
use crate::mesh::{Batch, EdgeLine, FrameView, MemorySink, MeshLists, MeshSink, Scene, SinkError, TileMesh};
use std::io;
use std::path::{Path, PathBuf};

/// Writes a finished frame to `path` atomically. Returns what rounding to the format's numbers cost. The file is made
/// on [rayon's threads](crate::control::Rayon).
///
/// # Errors
/// If the file cannot be created, written or renamed. An existing file at `path` is then unchanged.
pub fn save<'a>(frame: impl Into<FrameView<'a>>, path: &Path, format: Format) -> Result<Rounding, SinkError> {
    save_within(frame, path, format, f64::INFINITY)
}

/// As [`save`], unless rounding to the format's numbers moves a vertex by more than `most` millimetres.
///
/// # Errors
/// As [`save`]; and [`RoundedTooFar`](super::RoundedTooFar) as the cause, before the file is created.
pub fn save_within<'a>(
    frame: impl Into<FrameView<'a>>,
    path: &Path,
    format: Format,
    most: f64,
) -> Result<Rounding, SinkError> {
    let mut outputs = Outputs::default();
    let (rounding, _) = save_pending(frame, path, format, most, &mut outputs)?;
    outputs.publish()?;
    Ok(rounding)
}

/// As [`save_within`], to a file that appears when `outputs` are published. Returns its temporary name as well.
///
/// # Errors
/// As [`save_within`].
pub fn save_pending<'a>(
    frame: impl Into<FrameView<'a>>,
    path: &Path,
    format: Format,
    most: f64,
    outputs: &mut Outputs,
) -> Result<(Rounding, PathBuf), SinkError> {
    let frame = frame.into();
    made(path, outputs, |call| format.make(call, &frame, most))
}

/// Writes the pieces that `make` makes on rayon's threads. Returns what it does with them, and the temporary name.
fn made<R>(
    path: &Path,
    outputs: &mut Outputs,
    make: impl FnOnce(Call<'_>) -> io::Result<(Pieces, R)>,
) -> Result<(R, PathBuf), SinkError> {
    let control = Control::default();
    let (pieces, made) = make(Call::new(&Rayon, &control)).map_err(|cause| cannot_write(path, cause))?;
    let temporary = outputs.write(path, |file| pieces.iter().try_for_each(|piece| file.write_all(piece)))?;
    Ok((made, temporary))
}

/// Writes a GLB with levels of detail (MSFT_lod): each node has coarser nodes, and the share of the screen below which
/// each replaces it. `frame` was made within `chord` millimetres; `coarser` are finest first. Returns what rounding costs
/// in each level, beginning with `frame`, and the temporary name of the file, which appears when `outputs` are published.
///
/// At its share, the chord tolerance of a level is a pixel on a screen of 1920 by 1080. Readers that do not know the
/// extension draw `frame`. Where a part has no triangles in a level, it has those of the level before.
///
/// # Errors
/// As [`save_within`], for each level; and [`UnfitLevel`](super::UnfitLevel) as the cause.
#[cfg(feature = "glb")]
pub fn save_levels<'a>(
    (frame, chord): (impl Into<FrameView<'a>>, f64),
    coarser: &[GlbLevel<'_>],
    path: &Path,
    (options, most): (GlbOptions, f64),
    outputs: &mut Outputs,
) -> Result<(Vec<Rounding>, PathBuf), SinkError> {
    let frame = frame.into();
    made(path, outputs, |call| {
        super::glb_levels::check(frame.scene, chord, coarser)
            .map_err(|unfit| io::Error::new(io::ErrorKind::InvalidInput, unfit))?;
        glb_levels(call, &frame, coarser, (options, most))
    })
}

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
/// does not tell; [`save`] returns the [`Rounding`], and [`save_within`] limits it.
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
        let frame = FrameView::from(&self.frame);
        pending.publish(|file| write_alone(file, |call| self.format.make(call, &frame, f64::INFINITY)).map(drop))?;
        self.frame = MemorySink::default();
        Ok(())
    }

    fn abort(&mut self) {
        self.pending = None;
        self.frame = MemorySink::default();
    }
}
