//! The caller's pool of threads as the library's.

use crate::border::handles::{Exclusive, Table};
use crate::border::{Caller, User, entry, lend_body, versioned};
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

/// One call of a loop: `of` is what `tt_jobs.each` got, `number` is below its `count`.
pub type tt_body = extern "C" fn(of: *mut c_void, number: u32);

/// A pool of threads. Jobs may run in any order, at any time, also within `spawn`. They wait at most for one that runs
/// on another thread, so a pool of one thread suffices.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_jobs {
    /// `sizeof(tt_jobs)`.
    pub size: u32,
    /// How many threads can work at the same time, the caller's included while it makes a frame or helps, 1 to 1024.
    pub width: u32,
    /// Passed to the functions. Valid until the session is freed, or the call returns.
    pub user: *mut c_void,
    /// Takes a job, on any thread, several at the same time, and returns 0. Another number refuses the job.
    pub spawn: Option<extern "C" fn(user: *mut c_void, job: tt_job) -> i32>,
    /// A loop, for reading and preparing: calls `body` once with each number below `count`, on any threads and in any
    /// order, and returns 0 when all calls have returned. `body` may come back here: whoever waits for a loop within
    /// must make calls meanwhile, or have made all of them itself. The library makes the calls that are left out.
    ///
    /// May be null: then the thread that reads or prepares does all the work.
    pub each: Option<extern "C" fn(user: *mut c_void, count: u32, body: tt_body, of: *mut c_void) -> i32>,
}
versioned!(tt_jobs);

static JOBS: Table<Exclusive<Job>> = Table::new(7);

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
    each: Option<extern "C" fn(*mut c_void, u32, tt_body, *mut c_void) -> i32>,
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
    Ok(Some(Arc::new(Pool { width: at_most(from.width)?, user: User::of(from.user), spawn, each: from.each })))
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

    fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
        match (self.each, u32::try_from(count)) {
            // What it leaves out is made by whoever needs it.
            (Some(each), Ok(below)) => lend_body(count, body, |body, of| _ = each(self.user.get(), below, body, of)),
            _ => (0..count).for_each(body),
        }
    }
}
