//! FILE on the command line -> a model: a STEP file, or `builtin:NAME`.

use crate::Failure;
use std::path::{Path, PathBuf};
use trimtess::import::step::{self, StepOptions};
use trimtess::model::{Model, shapes};

/// What FILE names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Input {
    /// A file on disk.
    File(PathBuf),
    /// A shape that the crate makes.
    Builtin(String),
}

/// Reads the argument: `builtin:NAME` or a path.
pub(crate) fn parse(text: &str) -> Result<Input, std::convert::Infallible> {
    Ok(match text.strip_prefix("builtin:") {
        Some(name) => Input::Builtin(name.to_owned()),
        None => Input::File(PathBuf::from(text)),
    })
}

impl Input {
    /// Whether the list of built-in shapes was asked for instead of one of them.
    pub(crate) fn is_list(&self) -> bool {
        *self == Self::Builtin("list".into())
    }

    /// The model that it names.
    pub(crate) fn read(&self) -> Result<Model, Failure> {
        match self {
            Self::Builtin(name) => builtin(name),
            Self::File(path) => file(path),
        }
    }

    /// A short name, for messages and reports.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Builtin(name) => format!("builtin:{name}"),
            Self::File(path) => path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
        }
    }
}

/// The names of the built-in shapes, one a line.
pub(crate) fn builtin_list() -> String {
    shapes::NAMES.iter().map(|name| format!("builtin:{name}\n")).collect()
}

fn builtin(name: &str) -> Result<Model, Failure> {
    shapes::by_name(name)
        .ok_or_else(|| Failure::Usage(format!("there is no builtin:{name}; `builtin:list` as FILE lists them")))
}

fn file(path: &Path) -> Result<Model, Failure> {
    let cannot = |what: String| Failure::Cannot(format!("{}: {what}", path.display()));
    let bytes = std::fs::read(path).map_err(|e| cannot(e.to_string()))?;
    let mut model = step::read(&bytes, &StepOptions::default()).map_err(|e| cannot(e.to_string()))?;
    if model.name.is_empty() {
        model.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    }
    Ok(model)
}
