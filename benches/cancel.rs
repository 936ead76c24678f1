//! How long a read or a prepare of a file goes on once it is cancelled, what memory and which threads it leaves, and which
//! moments are the worst.
//!
//! `cargo bench --bench cancel -- FILE [COUNT]`: the moments are spread evenly over the time that the call takes. The
//! processor time is that of all threads from the cancel on: on a busy machine, a call waits for the others, too.

use cpu_time::ProcessTime;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};
use trimtess::control::{Control, Rayon};
use trimtess::import::step::{self, StepOptions};
use trimtess::prepare::{self, PrepareOptions};

/// That of the program.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Resident memory, MiB; 0 where the system does not say.
fn resident() -> f64 {
    let pages = fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages: f64 = pages.split(' ').nth(1).and_then(|pages| pages.parse().ok()).unwrap_or(0.0);
    pages * 4096.0 / f64::from(1 << 20)
}

/// Threads of the process; 0 where the system does not say.
fn threads() -> usize {
    fs::read_dir("/proc/self/task").map_or(0, Iterator::count)
}

/// Calls `work` with controls that are cancelled later and later.
fn cancelled<T>(name: &str, count: u32, work: impl Fn(&Control) -> Option<T>) {
    let whole = |_| {
        let start = Instant::now();
        let whole = work(&Control::default());
        let time = start.elapsed();
        assert!(whole.is_some(), "{name} fails");
        time
    };
    let time = (0..3).map(whole).min().unwrap_or_default();
    let (before, threads_before) = (resident(), threads());
    let (mut on, mut at_work, mut finished) = (Vec::new(), Vec::new(), 0);
    for k in 0..count {
        let control = Control::default();
        let ours = control.clone();
        let asked = thread::scope(|scope| {
            let asks = scope.spawn(move || {
                thread::sleep(time * k / count);
                let asked = (Instant::now(), ProcessTime::now());
                ours.cancel();
                asked
            });
            let ended = work(&control);
            let end = (Instant::now(), ProcessTime::now());
            finished += u32::from(ended.is_some());
            drop(ended);
            let asked = asks.join().ok();
            asked.map(|(clock, processor)| {
                let worked = end.1.as_duration().saturating_sub(processor.as_duration());
                (end.0.saturating_duration_since(clock), worked)
            })
        });
        on.extend(asked.map(|(clock, _)| (clock, k)));
        at_work.extend(asked.map(|(_, worked)| worked));
    }
    on.sort();
    at_work.sort();
    let ms = |time: Option<Duration>| 1e3 * time.unwrap_or_default().as_secs_f64();
    let at = |row: usize| on.get(row).map(|(time, _)| *time);
    let last = on.len().saturating_sub(1);
    println!(
        "{name}: {:.0} ms if not cancelled; goes on for {:.1} ms (median), {:.1} (worst of {count}, {finished} had ended); \
         processor {:.1} ms (median), {:.1} (worst); memory {before:.0} -> {:.0} MiB; threads {threads_before} -> {}",
        ms(Some(time)),
        ms(at(on.len() / 2)),
        ms(at(last)),
        ms(at_work.get(at_work.len() / 2).copied()),
        ms(at_work.last().copied()),
        resident(),
        threads()
    );
    let worst: Vec<String> =
        on.iter().rev().take(8).map(|(_, k)| format!("{:.2}", f64::from(*k) / f64::from(count))).collect();
    println!("    the worst at {} of its time", worst.join(", "));
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let file = arguments.first().map_or("tests/data/red_cube_blue_cylinder.step", String::as_str);
    let count = arguments.get(1).map_or(Ok(100), |count| count.parse())?;
    let text = fs::read(Path::new(file))?;
    println!("{file}");
    cancelled("read", count, |control| step::read_on(&Rayon, &text, &StepOptions::DEFAULT, control).ok());
    let model = step::read(&text, &StepOptions::DEFAULT)?;
    let options = PrepareOptions::DEFAULT;
    cancelled("prepare", count, |control| prepare::prepare_on(&Rayon, &model, &options, control).ok());
    Ok(())
}
