//! Where calls work: on threads that have ended once the call returns, or on the caller's pool.

use crate::border::Caller;
use crate::jobs::{pool, tt_jobs};
use crate::status::Failure;
use std::sync::Arc;
use trimtess::control::{Alone, Jobs, Rayon, Threads};

/// Threads at most, as of the program.
const MOST: usize = 1024;

/// A number of threads, or a pool.
pub(crate) enum Workplace {
    Own(usize),
    Pool(Arc<dyn Jobs>),
}

impl Workplace {
    /// As options state it: `threads` (0 = one per core), or `jobs` if it is not null.
    pub(crate) fn of(c: &Caller, threads: u32, jobs: *const tt_jobs) -> Result<Self, Failure> {
        match pool(c, jobs)? {
            Some(_) if threads > 0 => {
                Err(Failure::argument(format!("options.threads is {threads}, and there are jobs")))
            }
            Some(jobs) => Ok(Self::Pool(jobs)),
            None => Ok(Self::Own(at_most(threads)?)),
        }
    }

    /// Runs `work`. A panic of it reaches the caller.
    pub(crate) fn run<T: Send>(self, work: impl FnOnce(&dyn Jobs) -> T + Send) -> Result<T, Failure> {
        match self {
            Self::Own(1) => Ok(work(&Alone)),
            Self::Own(count) => Ok(Threads::start(count)?.run(|| work(&Rayon))),
            Self::Pool(jobs) => Ok(work(&*jobs)),
        }
    }
}

/// A number of threads that is not absurd.
pub(crate) fn at_most(count: u32) -> Result<usize, Failure> {
    let count = count as usize;
    if count > MOST {
        return Err(Failure::argument(format!("{count} threads; there may be {MOST}")));
    }
    Ok(count)
}
