//! Batches to a file: collects a frame, writes it when the frame is complete.

use super::pending::PendingFile;
#[cfg(feature = "glb")]
use super::write_glb;
use super::{write_obj, write_ply, write_stl};
use crate::mesh::{Batch, EdgeLine, MemorySink, MeshSink, Scene, SinkError};
use std::fmt;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A mesh file format.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Format {
    /// Binary glTF, see [`write_glb`].
    #[cfg(feature = "glb")]
    Glb,
    /// Binary STL, see [`write_stl`].
    Stl,
    /// Stanford PLY, see [`write_ply`].
    Ply,
    /// Wavefront OBJ, see [`write_obj`].
    Obj,
}

impl Format {
    /// Every format with its file extension.
    pub const ALL: &'static [(&'static str, Self)] = &[
        #[cfg(feature = "glb")]
        ("glb", Self::Glb),
        ("stl", Self::Stl),
        ("ply", Self::Ply),
        ("obj", Self::Obj),
    ];

    /// Returns the format for the extension of `path`, ignoring case.
    ///
    /// # Errors
    /// If the extension is missing or unknown.
    pub fn of_path(path: &Path) -> Result<Self, UnknownFormat> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let known = Self::ALL.iter().find(|(name, _)| *name == extension);
        known.map(|(_, format)| *format).ok_or(UnknownFormat { extension })
    }

    fn write(self, frame: &MemorySink, file: &mut impl Write) -> io::Result<()> {
        match self {
            #[cfg(feature = "glb")]
            Self::Glb => write_glb(frame, file),
            Self::Stl => write_stl(frame, file),
            Self::Ply => write_ply(frame, file),
            Self::Obj => write_obj(frame, file),
        }
    }
}

/// A file name whose extension is missing or not that of a format that can be written.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct UnknownFormat {
    /// The extension in lower case, without its dot. Empty if missing.
    pub extension: String,
}

impl fmt::Display for UnknownFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.extension.as_str() {
            "" => f.write_str("the file name has no extension")?,
            extension => write!(f, "cannot write .{extension} files")?,
        }
        f.write_str("; known are")?;
        for (index, (name, _)) in Format::ALL.iter().enumerate() {
            write!(f, "{} .{name}", if index == 0 { "" } else { "," })?;
        }
        Ok(())
    }
}

impl std::error::Error for UnknownFormat {}

/// Writes a finished frame to `path` atomically.
///
/// # Errors
/// If the file cannot be created, written or renamed. An existing file at `path` is then unchanged.
pub fn save(frame: &MemorySink, path: &Path, format: Format) -> Result<(), SinkError> {
    PendingFile::create(path)?.publish(|file| format.write(frame, file))
}

/// Creates a sink that writes `path` in the format of its extension. The file system is first touched by `begin`.
///
/// # Errors
/// If the extension is missing or unknown.
pub fn open(path: &Path) -> Result<Box<dyn MeshSink>, UnknownFormat> {
    Ok(Box::new(FileSink::new(path, Format::of_path(path)?)))
}

/// Collects a frame and writes it at `end`. Holds all triangles until then, because file headers contain counts and
/// instances share the triangles of their part.
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
    /// Creates the temporary file, so that a folder that cannot be written to is reported before any work is done.
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.pending = Some(PendingFile::create(&self.path)?);
        self.frame.begin(scene)
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        batch.mesh.uvs = Vec::new(); // no format stores these; they take a third of the memory
        batch.mesh.origins = Vec::new();
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
        pending.publish(|file| self.format.write(&self.frame, file))?;
        self.frame = MemorySink::default();
        Ok(())
    }

    fn abort(&mut self) {
        self.pending = None;
        self.frame = MemorySink::default();
    }
}
