//! Errors of the library -> exceptions of `trimtess.errors`, with fields.

use pyo3::prelude::*;
use trimtess::frame::Shortfall;
use trimtess::import::step::StepError;
use trimtess::out::{SaveError, UnknownFormat};
use trimtess::parallel::FrameError;
use trimtess::prepare::PrepareError;

/// An exception of the class of `trimtess.errors` that is named, with the fields that are variables of those names.
macro_rules! error {
    ($py:expr, $class:expr, $message:expr $(, $field:ident)*) => {{
        let made = || -> PyResult<_> {
            let fields = pyo3::types::PyDict::new($py);
            $(fields.set_item(stringify!($field), &$field)?;)*
            $py.import("trimtess.errors")?.getattr($class)?.call(($message,), Some(&fields))
        };
        made().map_or_else(|failure| failure, PyErr::from_value)
    }};
}
pub(crate) use error;

/// A refused argument.
pub(crate) fn out_of_range(py: Python<'_>, name: &str, value: impl ToString, expected: &str) -> PyErr {
    let value = value.to_string();
    error!(py, "RangeError", format!("{name} is {value}, not {expected}"), name, value, expected)
}

/// A refused argument, of which `why` is a sentence.
pub(crate) fn unfit(py: Python<'_>, name: &str, why: &dyn std::fmt::Display, expected: &str) -> PyErr {
    let value = why.to_string();
    error!(py, "RangeError", format!("{name}: {value}; expected: {expected}"), name, value, expected)
}

/// Checks that a number is finite and above 0.
pub(crate) fn positive(py: Python<'_>, name: &str, value: Option<f64>) -> PyResult<Option<f64>> {
    match value {
        Some(number) if !(number.is_finite() && number > 0.0) => {
            Err(out_of_range(py, name, number, "a finite number above 0"))
        }
        other => Ok(other),
    }
}

/// A limit that is exceeded: the name of the argument to raise, what is needed if that was counted, and the limit.
fn limit(py: Python<'_>, name: &str, numbers: (Option<u64>, u64), message: &str) -> PyErr {
    beyond(py, Some(name), numbers, format!("{message}; pass a larger {name} to continue"))
}

/// As [`limit`], with all that the caller may do in the message. No `name`: no argument raises the limit.
fn beyond(py: Python<'_>, name: Option<&str>, (needed, limit): (Option<u64>, u64), message: String) -> PyErr {
    error!(py, "LimitError", message, name, needed, limit)
}

/// What went wrong, for a person to report.
pub(crate) fn internal(py: Python<'_>, message: String) -> PyErr {
    error!(py, "InternalError", message)
}

/// The system refused a thread: too many are asked for, or too many run.
pub(crate) fn no_threads(py: Python<'_>, failure: &dyn std::fmt::Display) -> PyErr {
    error!(py, "TessellateError", format!("{failure}; pass a smaller workers"))
}

/// An array would have more rows than its indices have numbers, as `failure` says.
pub(crate) fn too_many(py: Python<'_>, failure: &dyn std::fmt::Display) -> PyErr {
    error!(py, "TessellateError", failure.to_string())
}

/// Work ends with this only after [`Control::cancel`](trimtess::control::Control::cancel), which has its own exception.
fn cancelled(py: Python<'_>) -> PyErr {
    internal(py, "the work was cancelled".to_owned())
}

/// The number and the words of a system's error; `None` and the message for others.
fn of_system(py: Python<'_>, error: &std::io::Error) -> (Option<i32>, Option<String>) {
    let number = error.raw_os_error();
    let words =
        number.and_then(|number| py.import("os").ok()?.call_method1("strerror", (number,)).ok()?.extract().ok());
    (number, words.or_else(|| Some(error.to_string())))
}

/// Why a file cannot be read. `path`: if it has one.
pub(crate) fn unread(py: Python<'_>, failure: &StepError, path: Option<&str>) -> PyErr {
    let message = match (failure, path) {
        (StepError::Io { .. }, _) | (_, None) => failure.to_string(),
        (_, Some(path)) => format!("{path}: {failure}"),
    };
    let (kind, system) = match failure {
        StepError::TooLarge { bytes, limit: most } => {
            return limit(py, "max_bytes", (Some(*bytes), *most), &message);
        }
        StepError::TooMuchMemory { needed, limit: most } => {
            return limit(py, "max_memory", (Some(*needed), *most), &message);
        }
        StepError::TooManyEntities { entities, limit: most } => {
            return limit(py, "max_entities", (Some(*entities), *most), &message);
        }
        StepError::TooManyInstances { limit: most } => {
            return limit(py, "max_instances", (None, *most), &message);
        }
        StepError::TooManyOccurrences { limit: most, .. } => return beyond(py, None, (None, *most), message),
        StepError::Cancelled => return cancelled(py),
        StepError::Io { error, .. } => ("io", Some(error)),
        StepError::NotStep { .. } => ("not-step", None),
        StepError::Syntax { .. } => ("syntax", None),
        _ => ("refused", None),
    };
    let (errno, strerror) = system.map_or((None, None), |failure| of_system(py, failure));
    error!(py, "ReadError", message, kind, path, errno, strerror)
}

/// Why a model cannot be prepared.
pub(crate) fn unprepared(py: Python<'_>, failure: &PrepareError) -> PyErr {
    match failure {
        PrepareError::TooManyPatches { limit: most, needed } => {
            limit(py, "max_patches", (Some(*needed), *most), &failure.to_string())
        }
        PrepareError::TooMuchMemory { limit: most, .. } => limit(py, "max_memory", (None, *most), &failure.to_string()),
        PrepareError::Cancelled => cancelled(py),
        _ => internal(py, failure.to_string()),
    }
}

/// Why the mesh would be coarser than asked. `hint`: what the caller may do, given the argument that sets the limit,
/// and whether the call has that argument.
pub(crate) fn short(py: Python<'_>, failure: &Shortfall, hint: impl FnOnce(&str) -> (String, bool)) -> PyErr {
    if failure.unusable {
        return unfit(py, "the tolerance", failure, "one that a mesh of this model can meet");
    }
    let (name, numbers) = if let Some([needed, limit]) = failure.memory() {
        ("max_memory", (Some(needed), limit))
    } else if failure.density < 1.0 {
        ("max_triangles", (Some(failure.needed), failure.limits.triangles))
    } else {
        ("max_tile_triangles", (None, failure.limits.triangles_per_tile))
    };
    let (hint, has_argument) = hint(name);
    beyond(py, has_argument.then_some(name), numbers, format!("{failure}; {hint}"))
}

/// Why there is no mesh.
pub(crate) fn unmade(py: Python<'_>, failure: &FrameError) -> PyErr {
    match failure {
        FrameError::Cancelled => cancelled(py),
        // The library's own sinks refuse what their indices cannot number.
        FrameError::Sink(_) => too_many(py, failure),
        _ => internal(py, failure.to_string()),
    }
}

/// Why a path names no format.
pub(crate) fn unknown_format(py: Python<'_>, failure: &UnknownFormat) -> PyErr {
    let extension = &failure.extension;
    error!(py, "FormatError", failure.to_string(), extension)
}

/// Why a file is not written. `helps` says whether moving the scene to the origin would help, and whether a PLY would.
pub(crate) fn unsaved(py: Python<'_>, failure: &SaveError, path: &str, helps: impl FnOnce() -> [bool; 2]) -> PyErr {
    let rounded = match failure {
        SaveError::Cancelled => return cancelled(py),
        SaveError::UnfitLevel(level) => {
            return unfit(py, "levels", level, "meshes of the same model, each coarser than the one before");
        }
        SaveError::File(file) => {
            let (errno, strerror) = of_system(py, &file.cause);
            return error!(py, "SaveError", file.to_string(), path, errno, strerror);
        }
        SaveError::RoundedTooFar(far) => Some(far),
        SaveError::BeyondSingle(_) => None,
        _ => return error!(py, "SaveError", format!("cannot write {path}: {failure}"), path),
    };
    let [recenter_helps, ply] = helps();
    let recenter = if recenter_helps { "; pass recenter=True" } else { "; use a larger tolerance" };
    let ply = if ply { ", or save as .ply, which has double precision" } else { "" };
    let moved = rounded.map(|far| far.moved);
    let allowed = rounded.map(|far| far.most);
    let place = rounded.map(|far| far.place.to_array());
    let message = format!("cannot write {path}: {failure}{recenter}{ply}");
    error!(py, "RoundingError", message, path, recenter_helps, moved, allowed, place)
}
