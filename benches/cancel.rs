//! How long a read or a prepare of a file goes on once it is cancelled, what memory it leaves, and which moments are the
//! worst.
//!
//! `cargo bench --bench cancel -- FILE [COUNT]`: the moments are spread evenly over the time that the call takes.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::thread;
use std::time::Instant;
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

/// Calls `work` with controls that are cancelled later and later.
fn cancelled<T>(name: &str, count: u32, work: impl Fn(&Control) -> Option<T>) {
    let start = Instant::now();
    let whole = work(&Control::default());
    let time = start.elapsed();
    assert!(whole.is_some(), "{name} fails");
    drop(whole);
    let before = resident();
    let (mut on, mut finished) = (Vec::new(), 0);
    for k in 0..count {
        let control = Control::default();
        let ours = control.clone();
        let asked = thread::scope(|scope| {
            let asks = scope.spawn(move || {
                thread::sleep(time * k / count);
                let asked = Instant::now();
                ours.cancel();
                asked
            });
            let ended = work(&control);
            let end = Instant::now();
            finished += u32::from(ended.is_some());
            drop(ended);
            asks.join().ok().map(|asked| end.saturating_duration_since(asked))
        });
        on.extend(asked.map(|asked| (asked, k)));
    }
    on.sort();
    let ms = |at: usize| on.get(at).map_or(0.0, |(time, _)| 1e3 * time.as_secs_f64());
    println!(
        "{name}: {:.0} ms if not cancelled; goes on for {:.1} ms (median), {:.1} (worst of {count}, {finished} had ended); \
         memory {before:.0} -> {:.0} MiB",
        1e3 * time.as_secs_f64(),
        ms(on.len() / 2),
        ms(on.len().saturating_sub(1)),
        resident()
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
