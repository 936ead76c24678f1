//! What frames cost on an engine's pool, against threads of the session's own. By the pool: the session's threads and
//! the caller, an engine's and the caller (rayon's, without priorities and loops of its own), as many threads apart
//! from the caller, rayon's global pool apart from it, and the caller alone.
//!
//! `cargo bench --bench pools -- FILE [FRAMES [ROUNDS]]`. Without a file, the brake assembly. Each round flies once on
//! every pool, frame by frame in turn, so that a machine that is slower for a while is slower for all. Of each frame,
//! the quickest round counts. *Cold*: every frame from scratch. *Coherent*: what changes since the one before.

use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trimtess::control::{Alone, Job, Jobs, Priority, Rayon, Threads};
use trimtess::frame::PlanLimits;
use trimtess::import::step::{self, StepOptions};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, prepare};
use trimtess::view::{CameraPath, Picture, View};

#[path = "common/nowhere.rs"]
mod nowhere;
use nowhere::Nowhere;

const PICTURE: Picture = Picture { size: (1920, 1080), deviation_px: 0.5, size_px: None, angle: 0.5 };

/// A pool of an engine, which has one way to run a job.
struct Engine {
    pool: rayon::ThreadPool,
    /// As many threads as the others have: the caller's, and those of the pool.
    width: usize,
}

impl Jobs for Engine {
    fn width(&self) -> usize {
        self.width
    }

    fn spawn(&self, _: Priority, job: Job) {
        self.pool.spawn(job);
    }
}

/// A session on a pool, and its quickest times.
struct Column {
    name: &'static str,
    session: Session,
    cold: Vec<Duration>,
    coherent: Vec<Duration>,
}

impl Column {
    fn of(name: &'static str, session: Session, frames: usize) -> Self {
        Self { name, session, cold: vec![Duration::MAX; frames], coherent: vec![Duration::MAX; frames] }
    }

    /// Makes a frame from scratch.
    fn cold(&mut self, k: usize, view: &View) -> Result<(), Box<dyn Error>> {
        let begun = Instant::now();
        let plan = self.session.plan_for_view(view, &PlanLimits::DEFAULT);
        self.session.frame(plan, &mut Nowhere)?;
        self.cold[k] = self.cold[k].min(begun.elapsed());
        Ok(())
    }

    /// Goes on from the last frame.
    fn coherent(&mut self, k: usize, view: &View) -> Result<(), Box<dyn Error>> {
        let begun = Instant::now();
        self.session.view(&[*view], &mut Nowhere)?;
        self.coherent[k] = self.coherent[k].min(begun.elapsed());
        Ok(())
    }
}

/// Ways to run frames.
const COLUMNS: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let model = match arguments.first() {
        Some(file) => step::read_file(file.as_ref(), &StepOptions::DEFAULT)?,
        None => trimtess_models::by_name("brake-assembly").ok_or("no such model")?,
    };
    let frames: usize = arguments.get(1).map_or(Ok(30), |count| count.parse())?;
    let rounds: usize = arguments.get(2).map_or(Ok(5), |count| count.parse())?;
    let prepared = Arc::new(prepare(model, &PrepareOptions::DEFAULT)?);
    let views = CameraPath::Orbit.views(prepared.bounds.ok_or("an empty model")?, frames, &PICTURE);

    let threads = Rayon.width();
    let options = SessionOptions::DEFAULT.with_edge_lines(false).with_threads(threads);
    let on = |jobs: Arc<dyn Jobs>| Session::start_on(jobs, Arc::clone(&prepared), &options);
    let pool = rayon::ThreadPoolBuilder::new().num_threads((threads - 1).max(1)).build()?;
    let engine = Engine { pool, width: threads };
    let mut columns: [Column; COLUMNS] = [
        Column::of("own threads", Session::start(Arc::clone(&prepared), &options)?, frames),
        Column::of("an engine's", on(Arc::new(engine)), frames),
        Column::of("threads apart", on(Arc::new(Threads::start(threads)?)), frames),
        Column::of("rayon's", on(Arc::new(Rayon)), frames),
        Column::of("the caller", on(Arc::new(Alone)), frames),
    ];
    for round in 0..rounds {
        // The first to make a frame reads the model's rows for the others. Each is first in turn.
        let turn = |k: usize| (0..COLUMNS).map(move |place| (round + k + place) % COLUMNS);
        for (k, view) in views.iter().enumerate() {
            turn(k).try_for_each(|column| columns[column].cold(k, view))?;
        }
        for (k, view) in views.iter().enumerate() {
            turn(k).try_for_each(|column| columns[column].coherent(k, view))?;
        }
    }

    // The first coherent frame of a round comes after whole frames, and is one.
    let ms = |times: &[Duration]| {
        1e3 * times.iter().skip(1).sum::<Duration>().as_secs_f64() / frames.saturating_sub(1).max(1) as f64
    };
    let [cold, coherent] = [ms(&columns[0].cold), ms(&columns[0].coherent)];
    println!("{threads} threads, {frames} views, least of {rounds} rounds: ms a frame, and as a share of own threads");
    for Column { name, cold: theirs, coherent: changes, .. } in &columns {
        let (a, b) = (ms(theirs), ms(changes));
        println!("{name:<13} cold {a:>8.3} {:>6.3}   coherent {b:>8.3} {:>6.3}", a / cold, b / coherent);
    }
    Ok(())
}
