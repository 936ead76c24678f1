//! Limits and tolerances of reading, and what a file is refused for.

use std::fmt;
use std::path::PathBuf;

/// Limits and tolerances of reading.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepOptions {
    /// How far the B-spline that stands for a curve or surface without an exact form may be from it, millimetres: offsets of
    /// B-splines, curves given in the parameters of a bent surface. Default 0.001.
    pub fit_tolerance: f64,
    /// Files longer than this are refused, bytes. Default 2 GiB.
    pub max_bytes: u64,
    /// How many instances that break the syntax may be cut out before the file is given up. Each costs another pass over
    /// the text. Default 16.
    pub max_syntax_repairs: usize,
    /// Files with more instances (`#n=…`) are refused. Default 50 million.
    pub max_entities: u64,
    /// How many placed parts and assemblies an assembly tree may expand to. Default 1 million.
    pub max_instances: u64,
    /// Files that would take more memory than this are refused, bytes, at [`BYTES_PER_BYTE`] per byte of the file. Default
    /// 16 GiB.
    pub max_memory: u64,
    /// Read supplemental geometry too: the items of `CONSTRUCTIVE_GEOMETRY_REPRESENTATION`s, and surfaces that stand next to
    /// shapes. It is construction help, not part of the shape. `false` (the default) leaves it out with a note per
    /// representation. `true` reads what has bounds into the part that it belongs to; a surface without bounds gets a warning.
    pub supplemental: bool,
}

/// Memory that reading takes at the peak for each byte of the file, about.
pub const BYTES_PER_BYTE: u64 = 10;

impl StepOptions {
    /// What the fields say.
    pub const DEFAULT: Self = Self {
        fit_tolerance: 1e-3,
        max_bytes: 2 << 30,
        max_syntax_repairs: 16,
        max_entities: 50_000_000,
        max_instances: 1_000_000,
        max_memory: 16 << 30,
        supplemental: false,
    };

    /// Sets [`fit_tolerance`](Self::fit_tolerance).
    #[must_use]
    pub const fn with_fit_tolerance(mut self, fit_tolerance: f64) -> Self {
        self.fit_tolerance = fit_tolerance;
        self
    }

    /// Sets [`max_bytes`](Self::max_bytes).
    #[must_use]
    pub const fn with_max_bytes(mut self, max_bytes: u64) -> Self {
        self.max_bytes = max_bytes;
        self
    }

    /// Sets [`max_syntax_repairs`](Self::max_syntax_repairs).
    #[must_use]
    pub const fn with_max_syntax_repairs(mut self, max_syntax_repairs: usize) -> Self {
        self.max_syntax_repairs = max_syntax_repairs;
        self
    }

    /// Sets [`max_entities`](Self::max_entities).
    #[must_use]
    pub const fn with_max_entities(mut self, max_entities: u64) -> Self {
        self.max_entities = max_entities;
        self
    }

    /// Sets [`max_instances`](Self::max_instances).
    #[must_use]
    pub const fn with_max_instances(mut self, max_instances: u64) -> Self {
        self.max_instances = max_instances;
        self
    }

    /// Sets [`max_memory`](Self::max_memory).
    #[must_use]
    pub const fn with_max_memory(mut self, max_memory: u64) -> Self {
        self.max_memory = max_memory;
        self
    }

    /// Sets [`supplemental`](Self::supplemental).
    #[must_use]
    pub const fn with_supplemental(mut self, supplemental: bool) -> Self {
        self.supplemental = supplemental;
        self
    }
}

impl Default for StepOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Why a file gives no model at all.
#[derive(Debug)]
#[non_exhaustive]
pub enum StepError {
    /// The file cannot be opened or read.
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        error: std::io::Error,
    },
    /// The file is longer than [`StepOptions::max_bytes`].
    TooLarge {
        /// Its length; of a device or pipe only what was read of it.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// Reading would take more memory than [`StepOptions::max_memory`].
    TooMuchMemory {
        /// About what it would take, bytes; of a device or pipe only for what was read of it.
        needed: u64,
        /// The limit, bytes.
        limit: u64,
    },
    /// The file has more instances than [`StepOptions::max_entities`].
    TooManyEntities {
        /// How many it has, to its end.
        entities: u64,
        /// The limit.
        limit: u64,
    },
    /// The assembly has more occurrences than [`StepOptions::max_instances`]; how many it has nobody counted.
    TooManyInstances {
        /// The limit.
        limit: u64,
    },
    /// The bytes are not Part 21 text.
    NotStep {
        /// What they look like, and what to do about it.
        looks_like: &'static str,
    },
    /// The syntax is broken in more places than [`StepOptions::max_syntax_repairs`], or where nothing can be cut out.
    Syntax {
        /// The parser's message, with line and column.
        message: String,
        /// How many instances had been cut out before.
        repairs: usize,
    },
}

impl fmt::Display for StepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, error } => write!(f, "cannot read {}: {error}", path.display()),
            Self::TooLarge { bytes, limit } => {
                write!(f, "the file has {bytes} bytes or more, the limit is {limit} (StepOptions::max_bytes)")
            }
            Self::TooMuchMemory { needed, limit } => write!(
                f,
                "reading the file takes about {needed} bytes of memory, the limit is {limit} (StepOptions::max_memory)"
            ),
            Self::TooManyEntities { entities, limit } => {
                write!(f, "the file has {entities} instances, the limit is {limit} (StepOptions::max_entities)")
            }
            Self::TooManyInstances { limit } => write!(
                f,
                "the assembly places more than {limit} parts and assemblies, which is the limit \
                 (StepOptions::max_instances)"
            ),
            Self::NotStep { looks_like } => write!(f, "not a STEP file but {looks_like}"),
            Self::Syntax { message, repairs } => write!(
                f,
                "{message} ({repairs} broken instances left out before it); export the file again or correct that line"
            ),
        }
    }
}

impl std::error::Error for StepError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io { error, .. } => Some(error),
            _ => None,
        }
    }
}
