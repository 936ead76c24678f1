//! Threads of reading and preparing: a pool that ends with the call, so that nothing of it outlives the library.

use crate::status::{Failure, tt_status};
use std::num::NonZero;
use std::thread;

/// Stack of a thread, as the main thread has on Linux.
const STACK: usize = 8 << 20;

/// Threads at most, as of the program.
const MOST: usize = 1024;

/// Runs `work` on `count` threads; 0 = one per core. A panic of it reaches the caller.
pub(crate) fn run<T: Send>(count: u32, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    let cores = || thread::available_parallelism().map_or(1, NonZero::get);
    let count = if count == 0 { cores() } else { at_most(count)? };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count).stack_size(STACK).build();
    let refused = |error| Failure::new(tt_status::TT_ERROR_THREADS, format!("cannot start {count} threads: {error}"));
    Ok(pool.map_err(refused)?.install(work))
}

/// A number of threads that is not absurd.
pub(crate) fn at_most(count: u32) -> Result<usize, Failure> {
    let count = count as usize;
    if count > MOST {
        return Err(Failure::argument(format!("{count} threads; there may be {MOST}")));
    }
    Ok(count)
}
