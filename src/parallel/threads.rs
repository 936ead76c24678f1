//! Threads of the library's own, for callers that have no pool.

use super::cores::{cores, stay_on};
use super::error::StartError;
use crate::control::Jobs;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// A pool of threads, which end when it is dropped. Several sessions can share one.
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

    fn spawn(&self, job: Box<dyn FnOnce() + Send>) {
        self.0.spawn(job);
    }
}
