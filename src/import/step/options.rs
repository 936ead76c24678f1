//! Options of the STEP reader, and why it rejects a file.

use crate::control::Control;
use crate::model::SyntaxError;
use std::path::PathBuf;

/// Limits and tolerances of the STEP reader.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepOptions {
    /// Largest sampled error of B-splines that approximate curves and surfaces without an exact form, millimetres:
    /// offsets of B-splines, curves in the parameters of a curved surface. Where a hundred-thousandth of their size is
    /// less, they are refined to that, as far as pieces of reasonable length allow. Positive and finite. Default 0.001.
    pub fit_tolerance: f64,
    /// Maximum length of a file, bytes. Default 2 GiB.
    pub max_bytes: u64,
    /// Maximum number of syntax errors that are cut out before the file is rejected. Default 16.
    pub max_syntax_repairs: usize,
    /// Maximum number of instances (`#n=…`) in a file. Default 50 million.
    pub max_entities: u64,
    /// Maximum number of placed parts and assemblies in the expanded assembly tree. Default 1 million.
    pub max_instances: u64,
    /// Maximum memory for reading, bytes. Estimated at [`BYTES_PER_BYTE`] per byte before it is read, by the items of
    /// its lists before it is parsed, and by its faces, edges and occurrences after that. Default 16 GiB.
    pub max_memory: u64,
    /// Whether to read supplemental geometry: the items of `CONSTRUCTIVE_GEOMETRY_REPRESENTATION`s, and surfaces next
    /// to shapes. It helps construction and is not part of the shape. `false` (the default) leaves it out, with a note
    /// per representation. `true` reads bounded items into their part; surfaces without bounds get a warning.
    pub supplemental: bool,
}

/// Typical peak memory of reading, bytes per byte of the file. Long lists of short values take up to 130.
pub const BYTES_PER_BYTE: u64 = 10;

impl StepOptions {
    /// The defaults documented at the fields.
    pub const DEFAULT: Self = Self {
        fit_tolerance: 1e-3,
        max_bytes: 2 << 30,
        max_syntax_repairs: 16,
        max_entities: 50_000_000,
        max_instances: 1_000_000,
        max_memory: 16 << 30,
        supplemental: false,
    };
}

options! {
    StepOptions:
    with_fit_tolerance(fit_tolerance: f64);
    with_max_bytes(max_bytes: u64);
    with_max_syntax_repairs(max_syntax_repairs: usize);
    with_max_entities(max_entities: u64);
    with_max_instances(max_instances: u64);
    with_max_memory(max_memory: u64);
    with_supplemental(supplemental: bool);
}

/// Why a file cannot be read at all.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// [`StepOptions::fit_tolerance`] is out of range.
    #[error("the fit tolerance is {asked} mm, not positive and finite (StepOptions::fit_tolerance)")]
    FitTolerance {
        /// Its value.
        asked: f64,
    },
    /// The file cannot be opened or read.
    #[error("cannot read {}: {error}", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        error: std::io::Error,
    },
    /// The file is longer than [`StepOptions::max_bytes`].
    #[error("the file has {bytes} bytes or more, the limit is {limit} (StepOptions::max_bytes)")]
    TooLarge {
        /// Its length; for a device or pipe, the bytes read so far.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// Reading would take more memory than [`StepOptions::max_memory`].
    #[error("reading the file takes about {needed} bytes of memory, the limit is {limit} (StepOptions::max_memory)")]
    TooMuchMemory {
        /// Estimated memory, bytes; for a device or pipe, of the bytes read so far.
        needed: u64,
        /// The limit, bytes.
        limit: u64,
    },
    /// The file has more instances than [`StepOptions::max_entities`].
    #[error("the file has {entities} instances, the limit is {limit} (StepOptions::max_entities)")]
    TooManyEntities {
        /// How many the whole file has.
        entities: u64,
        /// The limit.
        limit: u64,
    },
    /// The assembly has more occurrences than [`StepOptions::max_instances`]. They are not counted to the end.
    #[error("the assembly places more than {limit} parts and assemblies, the limit (StepOptions::max_instances)")]
    TooManyInstances {
        /// The limit.
        limit: u64,
    },
    /// Assemblies nested in each other place more parts and assemblies than a file of its length may. They are not
    /// counted to the end.
    #[error(
        "#{entity}: assemblies nested in each other place more than {limit} parts and assemblies, the limit for a file \
         of its size"
    )]
    TooManyOccurrences {
        /// The instance that places the first one beyond the limit.
        entity: u64,
        /// The limit: so many per byte of the file, and a constant.
        limit: u64,
    },
    /// The work was [cancelled](crate::control::Control::cancel).
    #[error("reading was cancelled")]
    Cancelled,
    /// The bytes are not Part 21 text.
    #[error("not a STEP file but {looks_like}")]
    NotStep {
        /// What the bytes look like, and what to do about it.
        looks_like: &'static str,
    },
    /// The syntax has more errors than [`StepOptions::max_syntax_repairs`], or one that cannot be cut out.
    #[error("{error} ({repairs} syntax errors before it were cut out); export the file again or correct the line")]
    Syntax {
        /// The error.
        error: SyntaxError,
        /// How many errors were cut out before.
        repairs: usize,
    },
}

/// Fails once the work is cancelled.
pub(super) fn proceed(control: &Control) -> Result<(), StepError> {
    if control.is_cancelled() { Err(StepError::Cancelled) } else { Ok(()) }
}
