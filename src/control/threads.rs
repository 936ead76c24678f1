//! Threads of the library's own, and those of rayon.

use super::jobs::{Job, Jobs, Priority};
use rayon::prelude::*;
use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};
use std::thread::{self, JoinHandle};

/// Stack of a thread, as the main thread has on Linux.
const STACK: usize = 8 << 20;

/// A pool of threads. They have ended once it is dropped. Reads, prepares and sessions can share one.
///
/// Has no priorities. A thread without work looks for helpers before it begins the next frame.
#[derive(Debug)]
pub struct Threads {
    // Dropped before the threads are awaited.
    pool: ThreadPool,
    _ended: Ended,
}

/// Waits for threads. Rayon tells its own to end, and does not wait.
#[derive(Debug)]
struct Ended(Vec<JoinHandle<()>>);

impl Drop for Ended {
    fn drop(&mut self) {
        let others = self.0.drain(..).filter(|handle| handle.thread().id() != thread::current().id());
        // What panicked was told by the work that did.
        others.for_each(|handle| _ = handle.join());
    }
}

impl Threads {
    /// Starts `count` threads; 0 = one per core available to the process, or as many as the environment variable
    /// `RAYON_NUM_THREADS` says.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn start(count: usize) -> Result<Self, StartError> {
        let mut ended = Ended(Vec::new());
        let start = |worker: ThreadBuilder| {
            let thread = thread::Builder::new().name(format!("trimtess-{}", worker.index())).stack_size(STACK);
            ended.0.push(thread.spawn(|| worker.run())?);
            Ok(())
        };
        let pool = ThreadPoolBuilder::new().num_threads(count).spawn_handler(start).build();
        let pool = pool.map_err(|cause| StartError { cause: std::io::Error::other(cause) })?;
        Ok(Self { pool, _ended: ended })
    }

    /// Runs `work` on one of the threads, and waits for it. Within, [`Rayon`] is this pool. A panic reaches the caller.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }
}

impl Jobs for Threads {
    fn width(&self) -> usize {
        self.pool.current_num_threads()
    }

    fn spawn(&self, _: Priority, job: Job) {
        self.pool.spawn(job);
    }

    fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
        self.run(|| Rayon.for_each(count, body));
    }
}

/// The rayon pool that the calling thread belongs to, else rayon's global one: one thread per core, or as many as the
/// environment variable `RAYON_NUM_THREADS` says, which start at the first use and do not end.
///
/// Functions that are not told where to run use it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rayon;

impl Jobs for Rayon {
    fn width(&self) -> usize {
        rayon::current_num_threads()
    }

    fn spawn(&self, _: Priority, job: Job) {
        rayon::spawn(job);
    }

    fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
        // Any call may be taken over by a thread without work.
        (0..count).into_par_iter().with_max_len(1).for_each(body);
    }
}

/// The operating system refused a thread.
#[derive(Debug, thiserror::Error)]
#[error("cannot start threads: {cause}")]
#[non_exhaustive]
pub struct StartError {
    /// The system's error.
    pub cause: std::io::Error,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::Duration;

    /// Tells that its thread has ended, after a while.
    struct Last(Arc<AtomicBool>);

    impl Drop for Last {
        fn drop(&mut self) {
            thread::sleep(Duration::from_millis(20));
            self.0.store(true, Ordering::Relaxed);
        }
    }

    thread_local! {
        static LAST: RefCell<Option<Last>> = const { RefCell::new(None) };
    }

    #[test]
    fn threads_have_ended_once_they_are_dropped_also_by_one_of_them() {
        for within in [false, true] {
            let (has_ended, other) = (Arc::new(AtomicBool::new(false)), Threads::start(1).expect("a thread"));
            let last = Last(Arc::clone(&has_ended));
            other.run(|| LAST.set(Some(last)));
            if within {
                let own = Arc::new(Threads::start(1).expect("a thread"));
                let held = Arc::clone(&own);
                own.spawn(Priority::Frame, Box::new(move || drop((held, other))));
                drop(own);
                while !has_ended.load(Ordering::Relaxed) {
                    thread::yield_now();
                }
            } else {
                drop(other);
            }
            assert!(has_ended.load(Ordering::Relaxed));
        }
    }
}
