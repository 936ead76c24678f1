//! The files of one run: refused before reading where two are the same, written together or not at all. Where a signal
//! ends the process, no temporary file stays.

use crate::Failure;
use serde::Serialize;
use std::fmt::Display;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use trimtess::out;

/// What a run writes: files, then text to standard output.
#[derive(Default)]
pub(crate) struct Outputs {
    files: out::Outputs,
    is_watched: bool,
    text: String,
}

impl Outputs {
    /// Writes a file that appears when the run succeeds.
    pub(crate) fn write(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        self.files().write(path, write).map(drop).map_err(Failure::cannot)
    }

    /// As [`write`](Self::write), a report in a line of JSON.
    pub(crate) fn write_json(&mut self, path: &Path, report: &impl Serialize) -> Result<(), Failure> {
        let text = json(report)?;
        self.write(path, |file| file.write_all(text.as_bytes()))
    }

    /// Prints a report in a line of JSON once all files are there.
    pub(crate) fn tell_json(&mut self, report: &impl Serialize) -> Result<(), Failure> {
        self.tell(&json(report)?);
        Ok(())
    }

    /// The files that appear when the run succeeds. Signals are watched from now on: before there is a temporary file,
    /// the thread for that would only compete with the work.
    pub(crate) fn files(&mut self) -> &mut out::Outputs {
        if !self.is_watched {
            watch_signals();
            self.is_watched = true;
        }
        &mut self.files
    }

    /// Prints to standard output once all files are there.
    pub(crate) fn tell(&mut self, text: &str) {
        self.text.push_str(text);
    }

    /// Gives all files their names, then prints.
    pub(crate) fn publish(self) -> Result<(), Failure> {
        self.files.publish().map_err(Failure::cannot)?;
        if self.text.is_empty() { Ok(()) } else { crate::tell(&self.text) }
    }
}

fn json(report: &impl Serialize) -> Result<String, Failure> {
    Ok(serde_json::to_string(report).map_err(|e| Failure::Cannot(format!("the report: {e}")))? + "\n")
}

/// The files that a command line names.
#[derive(Default)]
pub(crate) struct Named<'a> {
    pub(crate) inputs: Vec<&'a Path>,
    /// Each with its name for messages.
    pub(crate) outputs: Vec<(&'static str, &'a Path)>,
}

impl<'a> Named<'a> {
    /// Adds an optional output.
    pub(crate) fn output(mut self, name: &'static str, path: Option<&'a PathBuf>) -> Self {
        self.outputs.extend(path.map(|path| (name, path.as_path())));
        self
    }

    /// Fails if the folder of an output does not exist, if two outputs are the same file, or an output is an input.
    /// Devices and pipes may have several roles.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        self.outputs.iter().try_for_each(|(_, path)| require_folder(path))?;
        let same = |one: &Path, what: &dyn Display| {
            Err(Failure::Usage(format!("{}: {what} cannot be the same file", one.display())))
        };
        let mut known: Vec<(&str, Identity)> = Vec::new();
        for (name, path) in &self.outputs {
            let identity = Identity::of(path);
            if let Some((other, _)) = known.iter().find(|(_, known)| known.is(&identity)) {
                return same(path, &format!("the {other} and the {name}"));
            }
            known.push((name, identity));
        }
        for path in &self.inputs {
            let identity = Identity::of(path);
            if let Some((name, _)) = known.iter().find(|(_, known)| known.is(&identity)) {
                return same(path, &format!("the input and the {name}"));
            }
        }
        Ok(())
    }
}

/// What tells files from each other: links to one file have the same target, hard links the same number.
struct Identity {
    target: PathBuf,
    number: Option<(u64, u64)>,
    is_device: bool,
}

impl Identity {
    fn of(path: &Path) -> Self {
        let target = out::target_of(path);
        let known = std::fs::metadata(&target).ok();
        #[cfg(unix)]
        let number = {
            use std::os::unix::fs::MetadataExt;
            known.as_ref().map(|known| (known.dev(), known.ino()))
        };
        #[cfg(not(unix))]
        let number = None;
        Self { target, number, is_device: known.is_some_and(|known| !known.is_file() && !known.is_dir()) }
    }

    fn is(&self, other: &Self) -> bool {
        let linked = self.number.is_some() && self.number == other.number;
        !self.is_device && (linked || self.target == other.target)
    }
}

/// Fails if the folder of `output` does not exist.
fn require_folder(output: &Path) -> Result<(), Failure> {
    match output.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(Failure::Cannot(format!("{}: folder {} does not exist", output.display(), folder.display())))
        }
        _ => Ok(()),
    }
}

/// Starts a thread that waits for signals. Without one, killed runs leave temporary files, and nothing else is wrong.
#[cfg(unix)]
fn watch_signals() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::emulate_default_handler;
    // Not SIGHUP: a handler would undo nohup.
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else { return };
    let wait = move || {
        for signal in signals.forever() {
            trimtess::out::remove_temporaries(|| {
                let _ = emulate_default_handler(signal);
            });
        }
    };
    let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(wait);
}

/// Elsewhere the system removes nothing, and there are no such signals.
#[cfg(not(unix))]
fn watch_signals() {}
