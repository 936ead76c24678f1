//! A path to a file that appears under its name only when it is complete.

use crate::mesh::SinkError;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Large enough that a write call costs less than filling it.
const BUFFER_BYTES: usize = 1 << 20;

/// A file under a temporary name in the folder of its final path; dropped before [`PendingFile::publish`], it is removed.
#[derive(Debug)]
pub(super) struct PendingFile {
    path: PathBuf,
    temporary: PathBuf,
    writer: Option<BufWriter<File>>,
}

impl PendingFile {
    pub(super) fn create(path: &Path) -> Result<Self, SinkError> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let context = || format!("cannot create {}", path.display());
        let Some(name) = path.file_name() else {
            let cause = io::Error::new(io::ErrorKind::InvalidInput, "the path names no file");
            return Err(SinkError { context: context(), cause });
        };
        let serial = COUNT.fetch_add(1, Ordering::Relaxed);
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}-{serial}.part", std::process::id()));
        let temporary = path.with_file_name(hidden);
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&temporary)
            .map_err(|cause| SinkError { context: context(), cause })?;
        let writer = Some(BufWriter::with_capacity(BUFFER_BYTES, file));
        Ok(Self { path: path.to_owned(), temporary, writer })
    }

    /// Runs `write` on the file, then gives it its name, replacing what stood there.
    pub(super) fn publish(
        mut self,
        write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), SinkError> {
        let Some(mut writer) = self.writer.take() else { return Ok(()) };
        let result = write(&mut writer).and_then(|()| writer.flush());
        drop(writer); // some systems do not rename open files
        result
            .and_then(|()| fs::rename(&self.temporary, &self.path))
            .map_err(|cause| SinkError { context: format!("cannot write {}", self.path.display()), cause })
    }
}

impl Drop for PendingFile {
    fn drop(&mut self) {
        drop(self.writer.take());
        // After a rename there is nothing left under this name; nobody is left to hear of another failure.
        let _ = fs::remove_file(&self.temporary);
    }
}
