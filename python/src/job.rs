//! Long work -> a thread of its own, while the caller's thread waits for it without the interpreter's lock, reports
//! progress and hears signals.

use crate::errors;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::Duration;
use trimtess::control::{Control, Threads};

/// How often signals are heard: work that Ctrl-C ends has most of 50 ms for the tiles in hand. Faster, and threads of
/// other Python code wait for the lock.
pub(crate) const HEARD_EVERY: Duration = Duration::from_millis(10);

/// Waits between two reports of progress.
const WAITS_PER_REPORT: u32 = 5;

/// Stack of the thread that starts the work, as those of [`Threads`].
const STACK: usize = 8 << 20;

/// Maximum number of threads that can be asked for, as in the program: starting more takes longer than any file.
const MOST_WORKERS: usize = 1024;

/// The number of threads that `workers` asks for, 0 if not given.
pub(crate) fn threads(py: Python<'_>, workers: Option<usize>) -> PyResult<usize> {
    match workers.unwrap_or(0) {
        count if count <= MOST_WORKERS => Ok(count),
        count => Err(errors::out_of_range(py, "workers", count, &format!("from 0 to {MOST_WORKERS}"))),
    }
}

/// Whether the work has ended.
#[derive(Default)]
struct Ended(Mutex<bool>, Condvar);

impl Ended {
    fn set(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.1.notify_all();
    }

    /// Waits until the work has ended, at most [`HEARD_EVERY`]. Returns whether it has.
    fn wait(&self) -> bool {
        let ended = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.1.wait_timeout_while(ended, HEARD_EVERY, |ended| !*ended);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

/// How far the work is: done and total.
#[derive(Default)]
struct Counts(AtomicU64, AtomicU64);

/// A stage of work, and how to run it.
pub(crate) struct Job<'py> {
    pub(crate) py: Python<'py>,
    /// Name of the stage, for `progress`.
    pub(crate) stage: &'static str,
    /// Called with the stage, what is done and what there is to do, once that is known; on the caller's thread.
    pub(crate) progress: Option<Bound<'py, PyAny>>,
    /// Threads at most; 0 as for [`Threads::start`].
    pub(crate) workers: usize,
}

impl Job<'_> {
    /// Runs `work` in a pool of threads of its own. They have ended when this returns: a process may fork between
    /// calls.
    ///
    /// If a signal handler or `progress` raises, the work is cancelled, and the exception is returned once it has
    /// ended. A panic becomes an exception.
    pub(crate) fn run<T: Send>(&self, work: impl FnOnce(&Control) -> T + Send) -> PyResult<T> {
        let (ended, counts) = (Ended::default(), Arc::<Counts>::default());
        let observed = Arc::clone(&counts);
        let control = Control::observed_by(move |progress| {
            observed.0.store(progress.done, Ordering::Relaxed);
            observed.1.store(progress.total, Ordering::Relaxed);
        });
        let pool = Threads::start(self.workers).map_err(|failure| errors::no_threads(self.py, &failure))?;
        thread::scope(|scope| {
            let run = || {
                let done = catch_unwind(AssertUnwindSafe(|| pool.run(|| work(&control))));
                // Here its threads are awaited without the interpreter's lock.
                drop(pool);
                ended.set();
                done
            };
            let builder = thread::Builder::new().name(format!("trimtess-{}", self.stage)).stack_size(STACK);
            let started = builder.spawn_scoped(scope, run);
            let started = started.map_err(|e| errors::no_threads(self.py, &format!("cannot start a thread: {e}")))?;
            let (mut raised, mut waits) = (None, 0);
            while !self.py.detach(|| ended.wait()) {
                if raised.is_some() {
                    continue;
                }
                waits += 1;
                let report = || if waits % WAITS_PER_REPORT == 0 { self.report(&counts) } else { Ok(()) };
                raised = self.py.check_signals().and_then(|()| report()).err();
                raised.iter().for_each(|_| control.cancel());
            }
            let done = started.join().unwrap_or_else(Err);
            // Signals that came meanwhile are the interpreter's, which looks for them after this call.
            match (raised, done) {
                (Some(raised), _) => Err(raised),
                (None, Ok(done)) => self.report(&counts).map(|()| done),
                (None, Err(panic)) => Err(errors::internal(self.py, message(&*panic))),
            }
        })
    }

    fn report(&self, counts: &Counts) -> PyResult<()> {
        let Some(progress) = &self.progress else { return Ok(()) };
        let (done, total) = (counts.0.load(Ordering::Relaxed), counts.1.load(Ordering::Relaxed));
        // Reading counts parts once the syntax is parsed: callers may divide by the total.
        if total > 0 { progress.call1((self.stage, done, total)).map(drop) } else { Ok(()) }
    }
}

fn message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    format!("internal error: {text}; please report it with the file that caused it")
}
