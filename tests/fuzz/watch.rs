//! An input -> a verdict on its result, time and memory. Prints a failing input as a test to commit.

use crate::parts::said;
use crate::process::{peak_of, work_of};
use arbitrary::Unstructured;
use std::collections::HashMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, Once, OnceLock};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

/// Limit for one input, in processor time of the whole process. Inputs are small and take milliseconds; the margin is
/// for tests that run in parallel.
const TIME: Duration = Duration::from_secs(20);
/// An input that takes this long counts as endless: it is printed, and the process aborts.
const ENDLESS: Duration = Duration::from_secs(60);
/// Limit for the growth of the process during one input, bytes. Includes other tests of the process.
const MEMORY: u64 = 1 << 30;

/// An input drawn from bytes.
pub(crate) trait Case: Sized {
    /// The input that `u` encodes.
    fn draw(u: &mut Unstructured<'_>) -> arbitrary::Result<Self>;
    /// Runs it through the crate; an error says what is wrong with the outcome.
    fn judge(&self) -> Result<(), String>;
    /// The source of a test for it.
    fn as_test(&self) -> String;
}

/// Inputs in progress, by thread: the start time, and how to print them.
type AtWork = HashMap<ThreadId, (Duration, fn(&[u8]) -> String, Vec<u8>)>;
static AT_WORK: Mutex<Option<AtWork>> = Mutex::new(None);
static WATCHDOG: Once = Once::new();

/// Judges the input that `bytes` encode.
///
/// # Panics
/// If it fails, with the test to commit.
pub(crate) fn drawn<C: Case>(bytes: &[u8]) {
    let Ok(case) = C::draw(&mut Unstructured::new(bytes)) else { return };
    WATCHDOG.call_once(|| drop(thread::spawn(watch)));
    at_work(|work| work.insert(thread::current().id(), (processor_time(), text::<C>, bytes.to_vec())));
    let verdict = verdict(&case);
    at_work(|work| work.remove(&thread::current().id()));
    if let Err(fault) = verdict {
        panic!("{fault}\n\n{}\n", case.as_test());
    }
}

/// Judges a case found earlier.
///
/// # Panics
/// If it fails.
pub(crate) fn sound<C: Case>(case: &C) {
    verdict(case).unwrap_or_else(|fault| panic!("{fault}"));
}

fn verdict<C: Case>(case: &C) -> Result<(), String> {
    let (start, before) = (processor_time(), forget_peak());
    let judged = catch_unwind(AssertUnwindSafe(|| case.judge()));
    judged.unwrap_or_else(|panic| Err(format!("a panic: {}", said(&*panic))))?;
    let taken = processor_time().saturating_sub(start);
    if taken > TIME {
        return Err(format!("it took {taken:?}"));
    }
    let grown = peak_of("self").saturating_sub(before);
    if grown > MEMORY { Err(format!("it took {} MiB", grown >> 20)) } else { Ok(()) }
}

fn text<C: Case>(bytes: &[u8]) -> String {
    C::draw(&mut Unstructured::new(bytes)).map_or_else(|error| error.to_string(), |case| case.as_test())
}

fn at_work<R>(change: impl FnOnce(&mut AtWork) -> R) -> R {
    let mut work = AT_WORK.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    change(work.get_or_insert_default())
}

fn watch() {
    loop {
        thread::sleep(Duration::from_secs(1));
        let now = processor_time();
        let stuck = at_work(|work| {
            let (_, print, bytes) = work.values().find(|(since, ..)| now.saturating_sub(*since) > ENDLESS)?;
            Some(print(bytes))
        });
        if let Some(test) = stuck {
            eprintln!("it takes more than {ENDLESS:?}\n\n{test}\n");
            std::process::abort();
        }
    }
}

/// Processor time of all threads so far, which does not depend on the load of the machine. Wall time on systems other
/// than Linux.
fn processor_time() -> Duration {
    static START: OnceLock<Instant> = OnceLock::new();
    let start = *START.get_or_init(Instant::now);
    work_of("self").unwrap_or_else(|| start.elapsed())
}

/// Resets the process's memory peak and returns its current memory, bytes; `u64::MAX`, which allows any growth, where
/// the system has no peak to reset.
fn forget_peak() -> u64 {
    // Linux: proc_pid_clear_refs(5).
    if fs::write("/proc/self/clear_refs", "5").is_ok() { peak_of("self") } else { u64::MAX }
}
