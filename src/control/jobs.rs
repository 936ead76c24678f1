//! Where work runs: on threads of the library, on an engine's pool, or on the caller's thread alone.

/// A job that a pool runs once.
pub type Job = Box<dyn FnOnce() + Send>;

/// Threads that run work: [`Threads`](super::Threads) of the library, the rayon pool that the caller is in
/// ([`Rayon`](super::Rayon)), the caller's thread ([`Alone`]), or an engine's pool behind a few lines.
///
/// Reading and preparing are loops ([`for_each`](Self::for_each)), frames are jobs ([`spawn`](Self::spawn)). Results
/// never depend on the number of threads, nor on when and in which order they do what.
///
/// A job waits only for work that another thread has begun, and runs no other job meanwhile. So a pool of one thread
/// suffices, and pools may run jobs while a job or a loop of the caller's waits.
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
    /// How many jobs can run at the same time. 0 counts as 1.
    fn width(&self) -> usize;

    /// Runs `job` once, on any thread, now or later. A pool may drop the job instead, at the price of time: whoever waits
    /// for it does its work, and whoever only asks spawns it again.
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

/// What a job is for. A pool that knows priorities runs a `Helper` before a `Frame`, the larger one first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Priority {
    /// Begins a frame, ahead of the call that waits for it. That call makes the frame if no thread has begun it.
    Frame,
    /// Joins in a frame that is being made, and has nothing left to do once it is made; or frees what a frame that was
    /// taken back leaves.
    Helper,
}

/// How many jobs can run at the same time, at least 1.
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
