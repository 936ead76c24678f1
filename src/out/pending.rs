//! Paths to files written atomically: a temporary file in the same folder, renamed when it is complete.
//!
//! Readers of the path see the old content or all of the new. A killed process leaves the temporary file, hidden and
//! ending in `.part`.

use crate::mesh::SinkError;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Large enough that a write call costs less than filling the buffer.
const BUFFER_BYTES: usize = 1 << 20;

/// Maximum number of temporary names tried. Names are taken if an earlier process of the same id left files.
const NAMES: u32 = 1000;

/// A file under a temporary name in the folder of its final path. Removed if dropped before [`PendingFile::publish`].
#[derive(Debug)]
pub(super) struct PendingFile {
    path: PathBuf,
    /// `None` for devices and pipes, which are written in place.
    temporary: Option<PathBuf>,
    writer: Option<BufWriter<File>>,
}

/// Writes a file atomically: runs `write` on a temporary file, then renames it to `path`.
///
/// Symbolic links are followed. Devices and pipes are written in place.
///
/// # Errors
/// Errors of `write`, and failures to create, write or rename the file. No temporary file is left behind.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), SinkError> {
    PendingFile::create(path)?.publish(|file| write(file))
}

impl PendingFile {
    pub(super) fn create(path: &Path) -> Result<Self, SinkError> {
        let context = || format!("cannot create {}", path.display());
        let fail = |cause| SinkError { context: context(), cause };
        // Keep a link and replace its target.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        if let Ok(known) = fs::metadata(&path)
            && !known.is_file()
        {
            let file = OpenOptions::new().write(true).open(&path).map_err(fail)?;
            let writer = Some(BufWriter::with_capacity(BUFFER_BYTES, file));
            return Ok(Self { path, temporary: None, writer });
        }
        let (temporary, file) = Self::beside(&path).map_err(fail)?;
        let writer = Some(BufWriter::with_capacity(BUFFER_BYTES, file));
        Ok(Self { path, temporary: Some(temporary), writer })
    }

    /// Creates a temporary file in the folder of `path`.
    fn beside(path: &Path) -> io::Result<(PathBuf, File)> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = path.file_name();
        let name = name.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"))?;
        let mut taken = io::Error::from(io::ErrorKind::AlreadyExists);
        for _ in 0..NAMES {
            let serial = COUNT.fetch_add(1, Ordering::Relaxed);
            let mut hidden = std::ffi::OsString::from(".");
            hidden.push(name);
            hidden.push(format!(".{}-{serial}.part", std::process::id()));
            let temporary = path.with_file_name(hidden);
            match OpenOptions::new().write(true).create_new(true).open(&temporary) {
                Ok(file) => return Ok((temporary, file)),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => taken = error,
                Err(error) => return Err(error),
            }
        }
        Err(taken)
    }

    /// Runs `write` on the file, then renames it to its final path, replacing any file there.
    pub(super) fn publish(
        mut self,
        write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), SinkError> {
        let Some(mut writer) = self.writer.take() else { return Ok(()) };
        let result = write(&mut writer).and_then(|()| writer.flush());
        drop(writer); // some systems cannot rename open files
        result
            .and_then(|()| self.temporary.as_ref().map_or(Ok(()), |temporary| fs::rename(temporary, &self.path)))
            .map_err(|cause| SinkError { context: format!("cannot write {}", self.path.display()), cause })
    }
}

impl Drop for PendingFile {
    fn drop(&mut self) {
        drop(self.writer.take());
        if let Some(temporary) = &self.temporary {
            // Fails after a rename, when the name is gone. Nobody is left to report other failures to.
            let _ = fs::remove_file(temporary);
        }
    }
}
