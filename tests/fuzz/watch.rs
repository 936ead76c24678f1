//! An input -> a verdict on its result, its time and its memory. What fails is printed as a test to commit.

use arbitrary::Unstructured;
use std::any::Any;
use std::collections::HashMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, Once};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

/// Longest that one input may take. They are small, and take milliseconds; the rest is for busy machines.
const TIME: Duration = Duration::from_secs(10);
/// What takes this long is taken for endless: the input is printed and the process ended.
const ENDLESS: Duration = Duration::from_secs(60);
/// Most memory that the process may grow by during one input, bytes. Other tests of the process count, too.
const MEMORY: u64 = 1 << 30;

/// An input that was drawn from bytes.
pub(crate) trait Case: Sized {
    /// The input that `u` stands for.
    fn draw(u: &mut Unstructured<'_>) -> arbitrary::Result<Self>;
    /// Sends it through the crate; an error says what is wrong with the outcome.
    fn judge(&self) -> Result<(), String>;
    /// How to commit it as a test.
    fn as_test(&self) -> String;
}

/// Inputs at work, by thread: since when, and how to print them.
type AtWork = HashMap<ThreadId, (Instant, fn(&[u8]) -> String, Vec<u8>)>;
static AT_WORK: Mutex<Option<AtWork>> = Mutex::new(None);
static WATCHDOG: Once = Once::new();

/// Judges the input that `bytes` stand for.
///
/// # Panics
/// If it fails, with the test to commit.
pub(crate) fn drawn<C: Case>(bytes: &[u8]) {
    let Ok(case) = C::draw(&mut Unstructured::new(bytes)) else { return };
    WATCHDOG.call_once(|| drop(thread::spawn(watch)));
    at_work(|work| work.insert(thread::current().id(), (Instant::now(), text::<C>, bytes.to_vec())));
    let verdict = verdict(&case);
    at_work(|work| work.remove(&thread::current().id()));
    if let Err(fault) = verdict {
        panic!("{fault}\n\n{}\n", case.as_test());
    }
}

/// Judges a case that was found before.
///
/// # Panics
/// If it fails.
pub(crate) fn sound<C: Case>(case: &C) {
    verdict(case).unwrap_or_else(|fault| panic!("{fault}"));
}

fn verdict<C: Case>(case: &C) -> Result<(), String> {
    let (start, before) = (Instant::now(), forget_peak());
    let judged = catch_unwind(AssertUnwindSafe(|| case.judge()));
    judged.unwrap_or_else(|panic| Err(format!("a panic: {}", message(&*panic))))?;
    let taken = start.elapsed();
    if taken > TIME {
        return Err(format!("it took {taken:?}"));
    }
    let grown = peak().saturating_sub(before);
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
        let stuck = at_work(|work| {
            let (_, print, bytes) = work.values().find(|(since, ..)| since.elapsed() > ENDLESS)?;
            Some(print(bytes))
        });
        if let Some(test) = stuck {
            eprintln!("it takes more than {ENDLESS:?}\n\n{test}\n");
            std::process::abort();
        }
    }
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no text").to_owned()
}

/// Makes the process forget its peak of memory and returns what it holds now, bytes; 0 where the system does not tell.
fn forget_peak() -> u64 {
    // Linux: proc_pid_clear_refs(5).
    if fs::write("/proc/self/clear_refs", "5").is_ok() { peak() } else { u64::MAX }
}

/// Most memory that the process held, bytes.
fn peak() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib: Option<u64> = line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok());
    kib.unwrap_or(0) << 10
}
