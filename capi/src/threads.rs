//! Threads of calls and sessions: they have ended once the call returns, or the session is freed.

use crate::status::Failure;
use trimtess::control::Threads;

/// Threads at most, as of the program.
const MOST: usize = 1024;

/// Starts `count` threads; 0 = one per core.
pub(crate) fn start(count: u32) -> Result<Threads, Failure> {
    Ok(Threads::start(at_most(count)?, false)?)
}

/// A number of threads that is not absurd.
pub(crate) fn at_most(count: u32) -> Result<usize, Failure> {
    let count = count as usize;
    if count > MOST {
        return Err(Failure::argument(format!("{count} threads; there may be {MOST}")));
    }
    Ok(count)
}
