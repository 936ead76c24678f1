//! A path or bytes -> a model.

use crate::errors;
use crate::job::{Job, threads};
use crate::model::Model;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use std::path::PathBuf;
use std::sync::Arc;
use trimtess::control::Rayon;
use trimtess::import::step::{StepOptions, read_file_on, read_on};

/// Where a model is read from.
enum Source {
    Path(PathBuf),
    Bytes(PyBackedBytes),
}

impl Source {
    fn of(source: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(bytes) = source.extract::<PyBackedBytes>() {
            return Ok(Self::Bytes(bytes));
        }
        let path = source.extract::<PathBuf>();
        path.map(Self::Path).map_err(|_| PyTypeError::new_err("source must be a path, bytes or bytearray"))
    }
}

/// Reads a STEP file.
///
/// What cannot be read is left out and told in `Model.diagnostics`; the rest is read all the same.
///
/// Args:
///     source: A path, or the content of a file as bytes or bytearray.
///     name: Name of the model; that of the file without its ending if None.
///     max_memory: Memory of reading at most, bytes (default 16 GiB), estimated before it is taken. Holds for later
///         stages that are given none.
///     max_bytes: Length of the file at most, bytes (default 2 GiB).
///     max_entities: Instances (`#n=`) in the file at most (default 50 million).
///     max_instances: Placed parts and assemblies at most (default 1 million).
///     supplemental: Whether to read construction geometry that has bounds.
///     workers: Threads at most; one per core if None or 0.
///     progress: Called as `progress("read", done, total)` with parts, on this thread.
///
/// Raises:
///     ReadError: The file cannot be read at all.
///     LimitError: A limit is exceeded.
///     RangeError: `workers` is too large.
#[pyfunction]
#[pyo3(signature = (source, *, name=None, max_memory=None, max_bytes=None, max_entities=None, max_instances=None,
                    supplemental=false, workers=None, progress=None))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn read(
    source: &Bound<'_, PyAny>,
    name: Option<String>,
    max_memory: Option<u64>,
    max_bytes: Option<u64>,
    max_entities: Option<u64>,
    max_instances: Option<u64>,
    supplemental: bool,
    workers: Option<usize>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Model> {
    let py = source.py();
    let defaults = StepOptions::DEFAULT;
    let max_memory = max_memory.unwrap_or(defaults.max_memory);
    let options = StepOptions::DEFAULT
        .with_max_memory(max_memory)
        .with_max_bytes(max_bytes.unwrap_or(defaults.max_bytes))
        .with_max_entities(max_entities.unwrap_or(defaults.max_entities))
        .with_max_instances(max_instances.unwrap_or(defaults.max_instances))
        .with_supplemental(supplemental);
    let source = Source::of(source)?;
    let job = Job { py, stage: "read", progress, workers: threads(py, workers)? };
    let read = job.run(|control| match &source {
        Source::Path(path) => read_file_on(&Rayon, path, &options, control),
        Source::Bytes(bytes) => read_on(&Rayon, bytes, &options, control),
    })?;
    let path = match &source {
        Source::Path(path) => Some(path.display().to_string()),
        Source::Bytes(_) => None,
    };
    let mut model = read.map_err(|failure| errors::unread(py, &failure, path.as_deref()))?;
    if let Some(name) = name {
        model.name = name;
    }
    Ok(Model { model: Arc::new(model), max_memory })
}
