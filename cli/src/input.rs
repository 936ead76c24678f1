//! FILE on the command line -> a model: a STEP file, or `builtin:NAME`.

use crate::Failure;
use clap::builder::{PathBufValueParser, TypedValueParser};
use std::fs::File;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use trimtess::import::step::{self, StepError, StepOptions};
use trimtess::model::Model;

/// The FILE argument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Input {
    /// A file on disk.
    File(PathBuf),
    /// A model of `trimtess-models`.
    Builtin(String),
}

/// Parses `builtin:NAME` or a path. Names of files need not be UTF-8.
pub(crate) fn parser() -> impl TypedValueParser<Value = Input> {
    PathBufValueParser::new().map(|path| match path.to_str().and_then(|text| text.strip_prefix("builtin:")) {
        Some(name) => Input::Builtin(name.to_owned()),
        None => Input::File(path),
    })
}

impl Input {
    /// Whether this is `builtin:list`, which prints the names instead of loading a model.
    pub(crate) fn is_list(&self) -> bool {
        *self == Self::Builtin("list".into())
    }

    /// The file; `None` for built-in models.
    pub(crate) fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Builtin(_) => None,
        }
    }

    pub(crate) fn read(&self, options: &StepOptions) -> Result<Model, Failure> {
        match self {
            Self::Builtin(name) => builtin(name),
            Self::File(path) => file(path, options),
        }
    }

    /// A short name for messages and reports.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Builtin(name) => format!("builtin:{name}"),
            Self::File(path) => path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
        }
    }
}

/// The names of the built-in models, one per line.
pub(crate) fn builtin_list() -> String {
    trimtess_models::names().map(|name| format!("builtin:{name}\n")).collect()
}

fn builtin(name: &str) -> Result<Model, Failure> {
    trimtess_models::by_name(name)
        .ok_or_else(|| Failure::Usage(format!("unknown model builtin:{name}; pass builtin:list to list them")))
}

fn file(path: &Path, options: &StepOptions) -> Result<Model, Failure> {
    step::read_file(path, options).map_err(|error| {
        let raise = match error {
            StepError::TooLarge { .. } => Some("--max-bytes"),
            StepError::TooManyEntities { .. } => Some("--max-entities"),
            StepError::TooManyInstances { .. } => Some("--max-instances"),
            StepError::TooMuchMemory { .. } => Some("--max-memory"),
            _ => None,
        };
        Failure::Cannot(match (&error, raise) {
            (StepError::Io { .. }, _) => error.to_string(),
            (_, Some(option)) => format!("{}: {error}; raise {option} to read it", path.display()),
            _ => format!("{}: {error}", path.display()),
        })
    })
}

/// Reads a file of at most `most` bytes. Devices may have no end.
///
/// # Errors
/// I/O errors, and a longer file.
pub(crate) fn read_at_most(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, format!("longer than {most} bytes")));
    }
    Ok(bytes)
}
