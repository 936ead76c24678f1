//! Paths to files written atomically: a temporary file in the same folder, renamed when it is complete.
//!
//! Readers of the path see the old content or all of the new. A killed process leaves the temporary file, hidden and
//! ending in `.part` where the name leaves room; [`remove_temporaries`] is for handlers of signals.

use crate::mesh::SinkError;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Large enough that a write call costs less than filling the buffer. Memory of a larger one is paged in for small
/// files.
const BUFFER_BYTES: usize = 1 << 13;

/// Maximum number of temporary names tried. Names are taken if an earlier process of the same id left files.
const NAMES: u32 = 1000;

/// Maximum number of links that are followed from one path, as on Linux.
const LINKS: u32 = 40;

/// The temporary files of this process. Locked while one is created, renamed or removed.
static TEMPORARIES: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn temporaries() -> MutexGuard<'static, Vec<PathBuf>> {
    TEMPORARIES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files of this process, then runs `then`, which should end the process: until it returns, no
/// file can be created or replaced. Files that are being published together are published first.
pub fn remove_temporaries(then: impl FnOnce()) {
    let mut known = temporaries();
    for path in known.drain(..) {
        // Nobody is left to report failures to.
        let _ = fs::remove_file(path);
    }
    then();
}

/// The file that writing to `path` replaces: all links are followed, also to files that do not exist yet.
#[must_use]
pub fn target_of(path: &Path) -> PathBuf {
    if let Ok(known) = fs::canonicalize(path) {
        return known;
    }
    let mut target = path.to_owned();
    // Links of /proc to pipes name no file, and opening them works.
    let mut left = if fs::metadata(path).is_ok() { 0 } else { LINKS };
    while left > 0
        && let Ok(link) = fs::read_link(&target)
    {
        // A relative link starts in its folder; an absolute one replaces the path.
        target = target.parent().unwrap_or(Path::new("")).join(link);
        left -= 1;
    }
    let folder = target.parent().map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    match (folder.and_then(|folder| fs::canonicalize(folder).ok()), target.file_name()) {
        (Some(folder), Some(name)) if fs::metadata(&target).is_err() => folder.join(name),
        _ => target,
    }
}

/// A file under a temporary name in the folder of its final path. Removed if dropped before it is published.
#[derive(Debug)]
struct PendingFile {
    path: PathBuf,
    /// `None` for devices and pipes, which are written in place.
    temporary: Option<PathBuf>,
}

/// Writes a file atomically: runs `write` on a temporary file, then renames it to `path`.
///
/// Symbolic links are followed, and a file that is replaced keeps its mode. Devices and pipes are written in place.
///
/// # Errors
/// Errors of `write`, and failures to create, write or rename the file. No temporary file is left behind.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), SinkError> {
    let mut outputs = Outputs::default();
    outputs.write(path, write)?;
    outputs.publish()
}

/// The error of a file that could not be written.
pub(super) fn cannot_write(path: &Path, cause: io::Error) -> SinkError {
    SinkError::new(format!("cannot write {}", path.display()), cause)
}

/// Files that appear together or not at all. Dropped before [`Outputs::publish`], they leave nothing.
///
/// Devices and pipes are written in place, at once.
#[derive(Debug, Default)]
pub struct Outputs {
    files: Vec<PendingFile>,
}

impl Outputs {
    /// Writes a file under a temporary name, which is returned. `path` itself is not touched yet.
    ///
    /// # Errors
    /// Errors of `write`, and failures to create or write the file.
    pub fn write(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<PathBuf, SinkError> {
        let (pending, file) = PendingFile::create(path)?;
        let mut writer = BufWriter::with_capacity(BUFFER_BYTES, file);
        let written = write(&mut writer).and_then(|()| writer.flush());
        // Some systems cannot rename or remove open files.
        drop(writer);
        written.map_err(|cause| cannot_write(&pending.path, cause))?;
        let place = pending.temporary.as_ref().unwrap_or(&pending.path).clone();
        self.files.push(pending);
        Ok(place)
    }

    /// Removes the file that was written last.
    pub(super) fn remove_last(&mut self) {
        self.files.pop();
    }

    /// Gives all files their names. If one cannot have it, those that were replaced come back and new ones go; file
    /// systems without hard links cannot bring files back.
    ///
    /// # Errors
    /// If a file cannot be renamed.
    pub fn publish(mut self) -> Result<(), SinkError> {
        let files = std::mem::take(&mut self.files);
        let mut known = temporaries();
        let mut published: Vec<(&Path, Previous)> = Vec::new();
        let mut failed = None;
        for file in &files {
            let Some(temporary) = &file.temporary else { continue };
            let previous = if files.len() > 1 { Previous::of(&file.path) } else { Previous::Unknown };
            if let Err(cause) = fs::rename(temporary, &file.path) {
                previous.forget();
                failed = Some(cannot_write(&file.path, cause));
                break;
            }
            known.retain(|path| path != temporary);
            published.push((&file.path, previous));
        }
        for (path, previous) in published.into_iter().rev() {
            if failed.is_some() { previous.restore(path) } else { previous.forget() }
        }
        drop(known); // dropping `files` locks, too
        failed.map_or(Ok(()), Err)
    }
}

/// What was under a name before a file got it.
enum Previous {
    /// Nothing.
    Nothing,
    /// A file, which has this second name as well.
    Kept(PathBuf),
    /// A file that the file system gives no second name, or nobody asked.
    Unknown,
}

impl Previous {
    fn of(path: &Path) -> Self {
        if fs::symlink_metadata(path).is_err() {
            return Self::Nothing;
        }
        let linked = unused_name(path, |backup| fs::hard_link(path, backup));
        linked.map_or(Self::Unknown, |(backup, ())| Self::Kept(backup))
    }

    /// Undoes the renaming as far as possible: the error that led here is reported.
    fn restore(self, path: &Path) {
        let _ = match self {
            Self::Nothing => fs::remove_file(path),
            Self::Kept(backup) => fs::rename(backup, path),
            Self::Unknown => Ok(()),
        };
    }

    fn forget(self) {
        if let Self::Kept(backup) = self {
            let _ = fs::remove_file(backup);
        }
    }
}

/// Tries `create` with unused names in the folder of `path` until it succeeds. Where the file system has no room for
/// more characters than `path` has, the names are no longer than its name.
fn unused_name<T>(path: &Path, create: impl Fn(&Path) -> io::Result<T>) -> io::Result<(PathBuf, T)> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let name = path.file_name();
    let name = name.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"))?;
    let mut taken = io::Error::from(io::ErrorKind::AlreadyExists);
    let mut is_short = false;
    for _ in 0..NAMES {
        let serial = COUNT.fetch_add(1, Ordering::Relaxed);
        let mut temporary = path.with_file_name(if is_short { short(name, serial) } else { long(name, serial) });
        let mut created = create(&temporary);
        if !is_short && created.as_ref().is_err_and(|error| error.kind() == io::ErrorKind::InvalidFilename) {
            is_short = true;
            temporary = path.with_file_name(short(name, serial));
            created = create(&temporary);
        }
        match created {
            Ok(made) => return Ok((temporary, made)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => taken = error,
            Err(error) => return Err(error),
        }
    }
    Err(taken)
}

/// A temporary name that says for which file.
fn long(name: &OsStr, serial: u32) -> OsString {
    let mut hidden = OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}-{serial}.part", std::process::id()));
    hidden
}

/// A temporary name that is not longer than `name`, as long as that has more characters than the number has digits.
fn short(name: &OsStr, serial: u32) -> OsString {
    let digits = format!(".{:x}{serial:x}.part", std::process::id());
    let room = name.len().clamp(2, digits.len());
    OsString::from(if room == digits.len() { digits } else { format!("{serial:0room$x}") })
}

impl PendingFile {
    /// Creates it, or opens the device or pipe.
    fn create(path: &Path) -> Result<(Self, File), SinkError> {
        let fail = |cause| SinkError::new(format!("cannot create {}", path.display()), cause);
        // Keep a link and replace its target.
        let path = target_of(path);
        let known = match fs::metadata(&path) {
            Err(cause) if cause.kind() == io::ErrorKind::NotFound => None,
            // Such as links that lead to each other.
            known => Some(known.map_err(fail)?),
        };
        if known.as_ref().is_some_and(|known| !known.is_file()) {
            let file = OpenOptions::new().write(true).open(&path).map_err(fail)?;
            return Ok((Self { path, temporary: None }, file));
        }
        let mut temporaries = temporaries();
        let create = |temporary: &Path| OpenOptions::new().write(true).create_new(true).open(temporary);
        let (temporary, file) = unused_name(&path, create).map_err(fail)?;
        temporaries.push(temporary.clone());
        drop(temporaries);
        if let Some(known) = known {
            // Before there is content. Some file systems have no modes.
            let _ = fs::set_permissions(&temporary, known.permissions());
        }
        Ok((Self { path, temporary: Some(temporary) }, file))
    }
}

impl Drop for PendingFile {
    fn drop(&mut self) {
        if let Some(temporary) = &self.temporary {
            let mut known = temporaries();
            if let Some(at) = known.iter().position(|path| path == temporary) {
                known.swap_remove(at);
                // Nobody is left to report failures to.
                let _ = fs::remove_file(temporary);
            }
        }
    }
}
