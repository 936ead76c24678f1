//! Threads of the library's own, and those of rayon.

use super::cores::{cores, stay_on};
use super::jobs::{Job, Jobs, Priority};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::fmt;

/// A pool of threads, which end when it is dropped. Reads, prepares and sessions can share one.
///
/// Has no priorities. A thread without work looks for helpers before it begins the next frame.
#[derive(Debug)]
pub struct Threads(ThreadPool);

impl Threads {
    /// Starts `count` threads; 0 = one per core available to the process. `pin` pins each to one core, where the system
    /// allows it, for machines that do nothing else; it is ignored without the feature `affinity`.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn start(count: usize, pin: bool) -> Result<Self, StartError> {
        let cores = if pin { cores() } else { Vec::new() };
        let pool = ThreadPoolBuilder::new()
            .num_threads(count)
            .thread_name(|k| format!("trimtess-{k}"))
            .start_handler(move |k| {
                if !cores.is_empty() {
                    stay_on(cores[k % cores.len()]);
                }
            })
            .build();
        pool.map(Self).map_err(|cause| StartError { cause: std::io::Error::other(cause) })
    }
}

impl Jobs for Threads {
    fn width(&self) -> usize {
        self.0.current_num_threads()
    }

    fn spawn(&self, _: Priority, job: Job) {
        self.0.spawn(job);
    }

    fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
        self.0.install(|| Rayon.for_each(count, body));
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
        (0..count).into_par_iter().for_each(body);
    }
}

/// The operating system refused a thread.
#[derive(Debug)]
#[non_exhaustive]
pub struct StartError {
    /// The system's error.
    pub cause: std::io::Error,
}

impl fmt::Display for StartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot start threads: {}", self.cause)
    }
}

impl std::error::Error for StartError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.cause)
    }
}
