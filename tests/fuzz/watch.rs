//! An input -> a verdict on its result, its time and its memory. What fails is printed as a test to commit.

use arbitrary::Unstructured;
use std::any::Any;
use std::collections::HashMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, Once, OnceLock};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

/// Longest that one input may take, processor time of the whole process. They are small, and take milliseconds; the rest is
/// for the targets beside this one.
const TIME: Duration = Duration::from_secs(20);
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
type AtWork = HashMap<ThreadId, (Duration, fn(&[u8]) -> String, Vec<u8>)>;
static AT_WORK: Mutex<Option<AtWork>> = Mutex::new(None);
static WATCHDOG: Once = Once::new();

/// Judges the input that `bytes` stand for.
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

/// Judges a case that was found before.
///
/// # Panics
/// If it fails.
pub(crate) fn sound<C: Case>(case: &C) {
    verdict(case).unwrap_or_else(|fault| panic!("{fault}"));
}

fn verdict<C: Case>(case: &C) -> Result<(), String> {
    let (start, before) = (processor_time(), forget_peak());
    let judged = catch_unwind(AssertUnwindSafe(|| case.judge()));
    judged.unwrap_or_else(|panic| Err(format!("a panic: {}", message(&*panic))))?;
    let taken = processor_time().saturating_sub(start);
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

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no text").to_owned()
}

/// Processor time of all threads so far: a clock that a busy machine does not run ahead. Elsewhere than on Linux, time itself.
fn processor_time() -> Duration {
    static START: OnceLock<Instant> = OnceLock::new();
    let start = *START.get_or_init(Instant::now);
    // Linux: proc_pid_stat(5), in hundredths of a second.
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |k: usize| fields.get(k).and_then(|field| field.parse::<u64>().ok());
    ticks(11)
        .zip(ticks(12))
        .map_or_else(|| start.elapsed(), |(user, system)| Duration::from_millis(10 * (user + system)))
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
