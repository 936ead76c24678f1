//! What functions return, and the words that go with a failure.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use trimtess::control::StartError;
use trimtess::frame::PlanError;
use trimtess::import::step::StepError;
use trimtess::model::ModelError;
use trimtess::parallel::{EditError, FrameError};
use trimtess::prepare::PrepareError;

/// What every function returns. Errors are below 0; `tt_last_error` has the words.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum tt_status {
    /// Done.
    TT_OK = 0,
    /// Not made yet: `tt_session_finish_within` waited for as long as it was told.
    TT_PENDING = 1,
    /// An argument is null, of an unknown size or kind, out of range, NaN, or not UTF-8. Nothing has changed.
    TT_ERROR_ARGUMENT = -1,
    /// A handle is null, was freed, or is of another kind. Nothing has changed.
    TT_ERROR_HANDLE = -2,
    /// Another call uses the object: of another thread, or the call that this callback belongs to. Nothing has changed.
    TT_ERROR_BUSY = -3,
    /// The file cannot be read, or is no STEP file.
    TT_ERROR_READ = -4,
    /// A limit is exceeded. The words name it.
    TT_ERROR_LIMIT = -5,
    /// The work was cancelled.
    TT_ERROR_CANCELLED = -6,
    /// What was built is not a valid model.
    TT_ERROR_MODEL = -7,
    /// A callback returned another number than 0, or gave no memory.
    TT_ERROR_CALLBACK = -8,
    /// A tile does not fit the grid of 16 bits that the layout asks for, or the grid is too coarse for the tolerance.
    TT_ERROR_GRID = -9,
    /// The system refused a thread.
    TT_ERROR_THREADS = -10,
    /// An internal error ended the session. It can only be freed.
    TT_ERROR_LOST = -11,
    /// An internal error. The words should be reported, with the file that caused it.
    TT_ERROR_PANIC = -12,
}

use tt_status::{
    TT_ERROR_ARGUMENT, TT_ERROR_BUSY, TT_ERROR_CALLBACK, TT_ERROR_CANCELLED, TT_ERROR_GRID, TT_ERROR_HANDLE,
    TT_ERROR_LIMIT, TT_ERROR_LOST, TT_ERROR_MODEL, TT_ERROR_PANIC, TT_ERROR_READ, TT_ERROR_THREADS, TT_OK,
};

impl From<()> for tt_status {
    fn from((): ()) -> Self {
        TT_OK
    }
}

/// A status below 0 with its words.
#[derive(Debug)]
pub(crate) struct Failure {
    status: tt_status,
    words: String,
}

impl Failure {
    pub(crate) fn new(status: tt_status, words: impl Into<String>) -> Self {
        Self { status, words: words.into() }
    }

    pub(crate) fn argument(words: impl Into<String>) -> Self {
        Self::new(TT_ERROR_ARGUMENT, words)
    }

    pub(crate) fn handle(words: impl Into<String>) -> Self {
        Self::new(TT_ERROR_HANDLE, words)
    }

    pub(crate) fn busy(words: impl Into<String>) -> Self {
        Self::new(TT_ERROR_BUSY, words)
    }

    pub(crate) fn panic(message: &str) -> Self {
        Self::new(TT_ERROR_PANIC, format!("internal error: {message}; please report it with the file that caused it"))
    }

    /// An index of `name` that is out of range.
    pub(crate) fn index(name: &str, index: u64, count: usize) -> Self {
        Self::argument(format!("no {name} {index}; there are {count}"))
    }
}

/// A row by its index. `name` is what a row is.
pub(crate) fn row<'a, T>(rows: &'a [T], name: &str, index: impl Into<u64>) -> Result<&'a T, Failure> {
    let index = index.into();
    let found = usize::try_from(index).ok().and_then(|index| rows.get(index));
    found.ok_or_else(|| Failure::index(name, index, rows.len()))
}

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// Keeps the words of a failure for this thread.
pub(crate) fn tell(failure: Failure) -> tt_status {
    // A thread that is ending has no words left.
    let _ = LAST.try_with(|last| *last.borrow_mut() = without_nul(failure.words));
    failure.status
}

/// A text of C, with a space for each NUL: names in files may have some.
pub(crate) fn without_nul(text: String) -> CString {
    let mut bytes = text.into_bytes();
    bytes.iter_mut().filter(|byte| **byte == 0).for_each(|byte| *byte = b' ');
    CString::new(bytes).unwrap_or_default()
}

/// Words of the last failure on this thread, UTF-8; empty if there was none. Never null. Valid until a call on this
/// thread fails, or the thread ends.
#[unsafe(no_mangle)]
pub extern "C" fn tt_last_error() -> *const c_char {
    LAST.try_with(|last| last.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

macro_rules! failures {
    ($($error:ty: $status:expr;)*) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                let status: fn(&$error) -> tt_status = $status;
                Self::new(status(&error), error.to_string())
            }
        })*
    };
}

failures! {
    StepError: |error| match error {
        StepError::TooLarge { .. }
        | StepError::TooMuchMemory { .. }
        | StepError::TooManyEntities { .. }
        | StepError::TooManyInstances { .. }
        | StepError::TooManyOccurrences { .. } => TT_ERROR_LIMIT,
        StepError::FitTolerance { .. } => TT_ERROR_ARGUMENT,
        StepError::Cancelled => TT_ERROR_CANCELLED,
        _ => TT_ERROR_READ,
    };
    PrepareError: |error| match error {
        PrepareError::BorderTolerance { .. } => TT_ERROR_ARGUMENT,
        PrepareError::Cancelled => TT_ERROR_CANCELLED,
        _ => TT_ERROR_LIMIT,
    };
    PlanError: |_| TT_ERROR_CANCELLED;
    ModelError: |_| TT_ERROR_MODEL;
    StartError: |_| TT_ERROR_THREADS;
    FrameError: |error| match error {
        FrameError::View { .. } | FrameError::Plan(_) => TT_ERROR_ARGUMENT,
        FrameError::Sink(_) => TT_ERROR_CALLBACK,
        FrameError::Grid(_) => TT_ERROR_GRID,
        FrameError::Cancelled => TT_ERROR_CANCELLED,
        _ => TT_ERROR_LOST,
    };
    EditError: |error| if matches!(error, EditError::Lost { .. }) { TT_ERROR_LOST } else { TT_ERROR_ARGUMENT };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_with_nul_are_told_whole() {
        assert_eq!(without_nul("part \0 of 2\0".to_owned()).as_c_str(), c"part   of 2 ");
    }
}
