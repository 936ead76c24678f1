//! How long a read, a prepare, or the first frame of views of a file goes on once it is cancelled, what memory and
//! which threads it leaves, and which moments are the worst.
//!
//! `cargo bench --bench cancel -- FILE [COUNT] [COPIES]`: the moments are spread evenly over the time that the call
//! takes. The frame is of so many copies of each part, as parts of their own. The processor time is that of all threads
//! from the cancel on: on a busy machine, a call waits for the others, too.

use cpu_time::ProcessTime;
use std::error::Error;
use std::f64::consts::FRAC_PI_6;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};
use trimtess::control::{Control, Rayon};
use trimtess::import::step::{self, StepOptions};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{self, PrepareOptions, Prepared};
use trimtess::view::{CameraPath, Picture};

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

/// So many copies of each part, where it is.
fn copied(prepared: &Prepared, copies: usize) -> Arc<Prepared> {
    let mut many = prepared.clone();
    for _ in 1..copies {
        let first = many.parts.len();
        Arc::make_mut(&mut many.parts).extend_from_slice(&prepared.parts);
        many.scene.parts.extend_from_slice(&prepared.scene.parts);
        let moved = prepared.scene.instances.iter().cloned().map(|mut instance| {
            instance.part.0 += first as u32;
            instance
        });
        many.scene.instances.extend(moved);
    }
    Arc::new(many)
}

/// Forgets what first frames of views have begun, later and later, and drops their sessions then.
fn first_frames(prepared: &Arc<Prepared>, count: u32) -> Result<(), Box<dyn Error>> {
    const PICTURE: Picture = Picture { size: (1920, 1080), deviation_px: 0.5, size_px: None, angle: FRAC_PI_6 };
    let bounds = prepared.bounds.ok_or("nothing is placed")?;
    let views = CameraPath::Orbit.views(bounds, 1, &PICTURE);
    let begun = || {
        let mut session = Session::start_on(Arc::new(Rayon), Arc::clone(prepared), &SessionOptions::DEFAULT);
        session.begin(&views).map(|()| session)
    };
    let session = begun()?;
    let start = Instant::now();
    while !session.is_made() {
        thread::sleep(Duration::from_millis(1));
    }
    let whole = start.elapsed();
    drop(session);
    let (mut waited, mut dropped) = (Vec::new(), Vec::new());
    for k in 0..count {
        let mut session = begun()?;
        thread::sleep(whole * k / count);
        let asked = Instant::now();
        session.forget();
        waited.push((asked.elapsed(), k));
        let end = Instant::now();
        drop(session);
        dropped.push(end.elapsed());
    }
    waited.sort();
    dropped.sort();
    let ms = |time: Duration| 1e3 * time.as_secs_f64();
    let [median, worst] = [waited.len() / 2, waited.len() - 1].map(|row| waited[row]);
    println!(
        "first frame of {} tiles: {:.0} ms if not cancelled; `forget` takes {:.1} ms (median), {:.1} (worst of {count}, at {:.2}); \
         dropping the session then {:.1} (worst)",
        prepared.tiles().count(),
        ms(whole),
        ms(median.0),
        ms(worst.0),
        f64::from(worst.1) / f64::from(count),
        ms(dropped[dropped.len() - 1])
    );
    Ok(())
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
    let copies = arguments.get(2).map_or(Ok(1), |copies| copies.parse())?;
    first_frames(&copied(&prepare::prepare(model, &options)?, copies), count.max(1))
}
