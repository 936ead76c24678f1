//! Threads of calls and sessions: they have ended once the call returns, or the session is freed.

use crate::status::{Failure, tt_status};
use std::num::NonZero;
use std::thread::{self, JoinHandle};
use trimtess::control::Jobs;

/// Stack of a thread, as the main thread has on Linux.
const STACK: usize = 8 << 20;

/// Threads at most, as of the program.
const MOST: usize = 1024;

/// A pool whose threads have ended when it is dropped. Rayon tells its threads to end, and does not wait.
pub(crate) struct Threads {
    // Dropped before the threads are awaited.
    pool: rayon::ThreadPool,
    _ended: Ended,
}

/// Waits for threads.
struct Ended(Vec<JoinHandle<()>>);

impl Drop for Ended {
    fn drop(&mut self) {
        let others = self.0.drain(..).filter(|handle| handle.thread().id() != thread::current().id());
        // A panic of a thread was told by the work that it did.
        others.for_each(|handle| _ = handle.join());
    }
}

impl Threads {
    /// Starts `count` threads; 0 = one per core.
    pub(crate) fn start(count: u32) -> Result<Self, Failure> {
        let cores = || thread::available_parallelism().map_or(1, NonZero::get);
        let count = if count == 0 { cores() } else { at_most(count)? };
        let mut started = Vec::new();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).spawn_handler(|worker| {
            let name = format!("trimtess-{}", worker.index());
            started.push(thread::Builder::new().name(name).stack_size(STACK).spawn(|| worker.run())?);
            Ok(())
        });
        let refused =
            |error| Failure::new(tt_status::TT_ERROR_THREADS, format!("cannot start {count} threads: {error}"));
        let pool = pool.build().map_err(refused)?;
        Ok(Self { pool, _ended: Ended(started) })
    }
}

impl Jobs for Threads {
    fn width(&self) -> usize {
        self.pool.current_num_threads()
    }

    fn spawn(&self, job: Box<dyn FnOnce() + Send>) {
        self.pool.spawn(job);
    }
}

/// Runs `work` on `count` threads; 0 = one per core. A panic of it reaches the caller.
pub(crate) fn run<T: Send>(count: u32, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    Ok(Threads::start(count)?.pool.install(work))
}

/// A number of threads that is not absurd.
pub(crate) fn at_most(count: u32) -> Result<usize, Failure> {
    let count = count as usize;
    if count > MOST {
        return Err(Failure::argument(format!("{count} threads; there may be {MOST}")));
    }
    Ok(count)
}
