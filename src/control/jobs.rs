//! Where work runs: on threads of the library, on rayon's or an engine's pool, or on the caller's thread alone.

use rayon::prelude::*;
use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};
use std::num::NonZeroUsize;
use std::thread::{self, JoinHandle};

/// A job that a pool runs once.
pub type Job = Box<dyn FnOnce() + Send>;

/// Threads that run work: [`Threads`] of the library, the rayon pool that the caller is in
/// ([`Rayon`]), the caller's thread ([`Alone`]), or an engine's pool behind a few lines.
///
/// Reading and preparing are loops ([`for_each`](Self::for_each)), frames are jobs ([`spawn`](Self::spawn)). Results
/// never depend on the number of threads, nor on when and in which order they do what.
///
/// A job waits only for work that another thread has begun, and meanwhile runs at most helpers of its session. So a
/// pool of one thread suffices, and pools may run jobs while a job or a loop of the caller's waits.
///
/// ```
/// use trimtess::control::{Control, Job, Jobs, Priority};
/// use trimtess::{model::shapes, prepare};
///
/// /// A pool with queues by priority, and scoped tasks.
/// struct Engine(rayon::ThreadPool);
///
/// impl Jobs for Engine {
///     fn width(&self) -> usize {
///         self.0.current_num_threads()
///     }
///
///     fn spawn(&self, priority: Priority, job: Job) {
///         match priority {
///             Priority::Helper => self.0.spawn(job),
///             _ => self.0.spawn_fifo(job),
///         }
///     }
///
///     fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
///         self.0.scope(|scope| (0..count).for_each(|k| scope.spawn(move |_| body(k))));
///     }
/// }
///
/// let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build()?;
/// let model = shapes::by_name("washer").unwrap_or_default();
/// let options = prepare::PrepareOptions::DEFAULT;
/// let prepared = prepare::prepare_on(&Engine(pool), &model, &options, &Control::default())?;
/// assert_eq!(prepared.parts.len(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Jobs: Send + Sync {
    /// How many threads can work at the same time, the caller's included while it makes a frame or helps. 0 counts
    /// as 1.
    ///
    /// A pool of one thread per core has that number. One that leaves a core to the caller has one more than it has
    /// threads.
    fn width(&self) -> usize;

    /// Runs `job` once, on any thread, now or later. A pool may drop the job instead, at the price of time: whoever
    /// waits for it does its work, and whoever only asks spawns it again.
    fn spawn(&self, priority: Priority, job: Job);

    /// Calls `body` once with each number below `count`, on any threads and in any order. Returns when all calls have.
    ///
    /// `body` may call this again while all threads of the pool are in the outer loop. The inner loop must end then: a
    /// thread that waits has to make calls itself, as in rayon and other pools that steal work. The default makes all
    /// calls on this thread. `body` does not panic. If a number is left out, the caller does its work afterwards.
    fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
        (0..count).for_each(body);
    }
}

/// What a job is for. A pool that knows priorities runs the larger one first: a `Helper` before a `Frame`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Priority {
    /// Begins a frame, ahead of the call that waits for it. That call makes the frame if no thread has begun it.
    Frame,
    /// Frees what a plan, or a frame that was taken back, leaves. Nobody waits for it.
    Free,
    /// Joins in a frame that is being made, and has nothing left to do once it is made.
    Helper,
}

/// How many threads can work at the same time, at least 1.
pub(crate) fn width(jobs: &dyn Jobs) -> usize {
    jobs.width().max(1)
}

/// No threads: all work is done by the caller, before the call returns.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Jobs for Alone {
    fn width(&self) -> usize {
        1
    }

    fn spawn(&self, _: Priority, job: Job) {
        job();
    }
}

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

/// Threads of a session whose caller makes frames, or helps, as one of them. So one less is started, but at least one,
/// for frames that are begun. One more would look for work on a core that another one needs (decision 084).
#[derive(Debug)]
pub(crate) struct WithCaller {
    others: Threads,
    width: usize,
}

impl WithCaller {
    /// With `count` threads at work, the caller's among them; 0 as in [`Threads::start`].
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub(crate) fn start(count: usize) -> Result<Self, StartError> {
        let asked = if count > 0 { count } else { default_count() };
        let others = Threads::start((asked - 1).max(1))?;
        // A pool may have fewer than were asked for.
        let width = asked.min(others.width() + 1);
        Ok(Self { others, width })
    }
}

/// As many threads as rayon starts by default.
fn default_count() -> usize {
    let told = std::env::var("RAYON_NUM_THREADS").ok().and_then(|count| count.parse().ok());
    let cores = || thread::available_parallelism().map_or(1, NonZeroUsize::get);
    told.filter(|&count| count > 0).unwrap_or_else(cores)
}

impl Jobs for WithCaller {
    fn width(&self) -> usize {
        self.width
    }

    fn spawn(&self, priority: Priority, job: Job) {
        self.others.spawn(priority, job);
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
    fn the_caller_counts_among_the_threads_of_a_session() {
        for (count, others) in [(1, 1), (2, 1), (3, 2)] {
            let threads = WithCaller::start(count).expect("threads");
            assert_eq!((threads.width(), threads.others.width()), (count, others));
        }
        let threads = WithCaller::start(0).expect("threads");
        assert_eq!(threads.width(), Rayon.width());
        assert_eq!(threads.others.width(), (threads.width() - 1).max(1));
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
