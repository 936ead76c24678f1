//! Long work -> progress for its caller, and a request to stop it.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A stage of the way from a file to a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Stage {
    /// Reading. Counts parts, once the syntax is parsed.
    Read,
    /// Preparing. Counts faces, each part once.
    Prepare,
    /// Tessellating. Counts tiles, each part once.
    Tessellate,
}

impl Stage {
    /// The stage in one word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Prepare => "prepare",
            Self::Tessellate => "tessellate",
        }
    }
}

/// How far a stage has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// The stage.
    pub stage: Stage,
    /// What is done, from 0 to `total`.
    pub done: u64,
    /// What there is to do.
    pub total: u64,
}

type Observer = Box<dyn Fn(Progress) + Send + Sync>;

/// The caller's end of long work: hears of its progress, and asks it to stop. Clones share one request.
///
/// ```
/// use trimtess::control::Control;
/// use trimtess::{model::shapes, prepare};
///
/// let control = Control::default();
/// control.cancel(); // usually from another thread
/// let model = shapes::by_name("washer").unwrap_or_default();
/// let error = prepare::prepare_controlled(&model, &prepare::PrepareOptions::DEFAULT, &control).err();
/// assert_eq!(error, Some(prepare::PrepareError::Cancelled));
/// ```
#[derive(Clone, Default)]
pub struct Control(Arc<Shared>);

#[derive(Default)]
struct Shared {
    cancelled: AtomicBool,
    observer: Option<Observer>,
}

impl Control {
    /// A control whose `observer` hears of progress: at most once per part, face or tile, from the threads that do the
    /// work, and not in order. It should return at once.
    #[must_use]
    pub fn observed_by(observer: impl Fn(Progress) + Send + Sync + 'static) -> Self {
        Self(Arc::new(Shared { observer: Some(Box::new(observer)), ..Shared::default() }))
    }

    /// Asks the work to stop. It ends with an error after the piece of text, part, face or tile in hand.
    pub fn cancel(&self) {
        self.0.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether the work was asked to stop.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.cancelled.load(Ordering::Relaxed)
    }

    /// Reports progress.
    pub(crate) fn report(&self, stage: Stage, done: u64, total: u64) {
        if let Some(observer) = &self.0.observer {
            observer(Progress { stage, done, total });
        }
    }
}

impl fmt::Debug for Control {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Control").field("cancelled", &self.is_cancelled()).finish_non_exhaustive()
    }
}
