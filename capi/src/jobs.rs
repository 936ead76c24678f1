//! The caller's pool of threads as the library's.

use crate::border::handles::Table;
use crate::border::{Caller, User, entry, versioned};
use crate::status::{Failure, tt_status};
use crate::threads::at_most;
use std::ffi::c_void;
use std::sync::{Arc, Mutex, PoisonError};
use trimtess::control::{Job, Jobs, Priority};

/// Work that the library gave to a pool, to be run once: `tt_job_run`. A pool that does not want it calls
/// `tt_job_drop`; whoever waits for the work does it then.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_job {
    pub id: u64,
}

/// A pool of threads. Jobs may run in any order, at any time, also within `spawn`. They wait at most for one that runs
/// on another thread, so a pool of one thread suffices.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_jobs {
    /// `sizeof(tt_jobs)`.
    pub size: u32,
    /// How many jobs can run at the same time, at least 1.
    pub width: u32,
    /// Passed to `spawn`. Valid until the session is freed.
    pub user: *mut c_void,
    /// Takes a job, on any thread, several at the same time, and returns 0. Another number refuses the job.
    pub spawn: Option<extern "C" fn(user: *mut c_void, job: tt_job) -> i32>,
}
versioned!(tt_jobs);

static JOBS: Table<Mutex<Option<Job>>> = Table::new(7);

fn take(job: tt_job) -> Result<Option<Job>, Failure> {
    Ok(JOBS.take(job.id)?.lock().unwrap_or_else(PoisonError::into_inner).take())
}

/// Runs a job, on this thread. Its handle ends.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_job_run(job: tt_job) -> tt_status {
    entry!(_c => {
        if let Some(work) = take(job)? {
            work();
        }
        Ok(())
    })
}

/// Drops a job. Its handle ends.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_job_drop(job: tt_job) -> tt_status {
    entry!(_c => take(job).map(drop))
}

/// A [`tt_jobs`] in use.
struct Pool {
    width: usize,
    user: User,
    spawn: extern "C" fn(*mut c_void, tt_job) -> i32,
}

/// The pool that C states; none if null.
pub(crate) fn pool(c: &Caller, from: *const tt_jobs) -> Result<Option<Arc<dyn Jobs>>, Failure> {
    if from.is_null() {
        return Ok(None);
    }
    let from = c.read("jobs", from)?;
    let spawn = from.spawn.ok_or_else(|| Failure::argument("jobs.spawn must be a function"))?;
    if from.width == 0 {
        return Err(Failure::argument("jobs.width is 0; it must be 1 or more"));
    }
    Ok(Some(Arc::new(Pool { width: at_most(from.width)?, user: User::of(from.user), spawn })))
}

impl Jobs for Pool {
    fn width(&self) -> usize {
        self.width
    }

    fn spawn(&self, _: Priority, job: Job) {
        let id = JOBS.add(Mutex::new(Some(job)));
        if (self.spawn)(self.user.get(), tt_job { id }) != 0 {
            // It may have run nevertheless.
            let _ = take(tt_job { id });
        }
    }
}
