//! Errors of the library -> exceptions of `trimtess.errors`, with fields.

use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use trimtess::frame::Shortfall;
use trimtess::import::step::StepError;
use trimtess::out::{SaveError, UnknownFormat};
use trimtess::parallel::FrameError;
use trimtess::prepare::PrepareError;

/// An exception of the class `name` of `trimtess.errors`.
pub(crate) fn error(py: Python<'_>, name: &str, message: String, fields: &Bound<'_, PyDict>) -> PyErr {
    let made = || py.import("trimtess.errors")?.getattr(name)?.call((message,), Some(fields));
    made().map_or_else(|failure| failure, PyErr::from_value)
}

/// A refused argument.
pub(crate) fn out_of_range(py: Python<'_>, name: &str, value: impl ToString, expected: &str) -> PyErr {
    let value = value.to_string();
    let message = format!("{name} is {value}, not {expected}");
    let fields = [("name", name), ("value", &value), ("expected", expected)].into_py_dict(py);
    fields.map_or_else(|failure| failure, |fields| error(py, "RangeError", message, &fields))
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
    let fields = PyDict::new(py);
    let set = || {
        fields.set_item("name", name)?;
        fields.set_item("needed", needed)?;
        fields.set_item("limit", limit)
    };
    set().map_or_else(|failure| failure, |()| error(py, "LimitError", message, &fields))
}

/// What went wrong, for a person to report.
pub(crate) fn internal(py: Python<'_>, message: String) -> PyErr {
    error(py, "InternalError", message, &PyDict::new(py))
}

/// The system refused a thread: too many are asked for, or too many run.
pub(crate) fn no_threads(py: Python<'_>, failure: &dyn std::fmt::Display) -> PyErr {
    error(py, "TessellateError", format!("{failure}; pass a smaller workers"), &PyDict::new(py))
}

/// An array would have more rows than its indices have numbers, as `failure` says.
pub(crate) fn too_many(py: Python<'_>, failure: &dyn std::fmt::Display) -> PyErr {
    error(py, "TessellateError", failure.to_string(), &PyDict::new(py))
}

/// Work ends with this only after [`Control::cancel`](trimtess::control::Control::cancel), which has its own exception.
fn cancelled(py: Python<'_>) -> PyErr {
    internal(py, "the work was cancelled".to_owned())
}

/// The number and the words of a system's error; `None` and the message for others.
fn of_system(py: Python<'_>, error: &std::io::Error) -> (Option<i32>, String) {
    let number = error.raw_os_error();
    let words =
        number.and_then(|number| py.import("os").ok()?.call_method1("strerror", (number,)).ok()?.extract().ok());
    (number, words.unwrap_or_else(|| error.to_string()))
}

/// Why a file cannot be read. `source` is its path, if it has one.
pub(crate) fn unread(py: Python<'_>, failure: &StepError, source: Option<&str>) -> PyErr {
    let message = match (failure, source) {
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
        StepError::Io { error, .. } => ("io", Some(of_system(py, error))),
        StepError::NotStep { .. } => ("not-step", None),
        StepError::Syntax { .. } => ("syntax", None),
        _ => ("refused", None),
    };
    let fields = PyDict::new(py);
    let set = || {
        fields.set_item("kind", kind)?;
        fields.set_item("path", source)?;
        let (number, words) = system.map_or((None, None), |(number, words)| (number, Some(words)));
        fields.set_item("errno", number)?;
        fields.set_item("strerror", words)
    };
    set().map_or_else(|failure| failure, |()| error(py, "ReadError", message, &fields))
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
    let fields = [("extension", &failure.extension)].into_py_dict(py);
    fields.map_or_else(|failure| failure, |fields| error(py, "FormatError", failure.to_string(), &fields))
}

/// A refused argument, of which `why` is a sentence.
pub(crate) fn unfit(py: Python<'_>, name: &str, why: &dyn std::fmt::Display, expected: &str) -> PyErr {
    let value = why.to_string();
    let message = format!("{name}: {value}; expected: {expected}");
    let fields = [("name", name), ("value", &value), ("expected", expected)].into_py_dict(py);
    fields.map_or_else(|failure| failure, |fields| error(py, "RangeError", message, &fields))
}

/// Why a file is not written. `helps` says whether moving the scene to the origin would help, and whether a PLY would.
pub(crate) fn unsaved(py: Python<'_>, failure: &SaveError, path: &str, helps: impl FnOnce() -> [bool; 2]) -> PyErr {
    let (rounded, file) = match failure {
        SaveError::Cancelled => return cancelled(py),
        SaveError::UnfitLevel(level) => {
            return unfit(py, "levels", level, "meshes of the same model, each coarser than the one before");
        }
        SaveError::RoundedTooFar(far) => (Some(far), None),
        SaveError::File(failure) => (None, Some(failure)),
        _ => (None, None),
    };
    let is_rounding = matches!(failure, SaveError::RoundedTooFar(_) | SaveError::BeyondSingle(_));
    let fields = PyDict::new(py);
    let mut message = file.map_or_else(|| format!("cannot write {path}: {failure}"), ToString::to_string);
    let set = || {
        fields.set_item("path", path)?;
        if !is_rounding {
            let system = file.map(|failure| of_system(py, &failure.cause));
            fields.set_item("errno", system.as_ref().map(|(number, _)| number))?;
            return fields.set_item("strerror", system.as_ref().map(|(_, words)| words));
        }
        let [recenter, ply] = helps();
        message += if recenter { "; pass recenter=True" } else { "; use a larger tolerance" };
        message += if ply { ", or save as .ply, which has double precision" } else { "" };
        fields.set_item("recenter_helps", recenter)?;
        fields.set_item("moved", rounded.map(|far| far.moved))?;
        fields.set_item("allowed", rounded.map(|far| far.most))?;
        fields.set_item("place", rounded.map(|far| far.place.to_array()))
    };
    let name = if is_rounding { "RoundingError" } else { "SaveError" };
    set().map_or_else(|failure| failure, |()| error(py, name, message, &fields))
}
