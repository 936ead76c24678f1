//! Contract: reading and preparing on anybody's threads. The same model on threads of the library, on an engine's pool,
//! on none, and in any order; no deadlock from within a job; a cancelled call leaves no memory.
#![cfg(feature = "step")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "sequence/random.rs"]
mod random;

use random::SplitMix;
use std::cell::Cell;
use std::collections::hash_map::DefaultHasher;
use std::fmt::{self, Write};
use std::hash::Hasher;
use std::sync::atomic::{AtomicI64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::thread;
use std::time::{Duration, Instant};
use trimtess::control::{Alone, Control, Job, Jobs, Priority, Rayon, Stage, Threads};
use trimtess::import::step::{StepError, StepOptions, read, read_on};
use trimtess::mesh::MemorySink;
use trimtess::model::Model;
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareError, PrepareOptions, Prepared, prepare_on};
use trimtess::view::{Camera, Projection, View};

/// An engine's pool: rayon's. Adds up what is allocated and not freed in its loops.
struct Engine {
    pool: rayon::ThreadPool,
    bytes: AtomicI64,
}

thread_local! {
    /// Whether a loop around this one counts what this one allocates.
    static COUNTED: Cell<bool> = const { Cell::new(false) };
}

impl Engine {
    fn of(threads: usize) -> Self {
        Self { pool: rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap(), bytes: AtomicI64::new(0) }
    }

    /// Bytes that `work` allocates and does not free.
    fn held(&self, work: impl FnOnce()) -> i64 {
        self.bytes.store(0, Ordering::Relaxed);
        let here = allocation_counter::measure(work).bytes_current;
        here + self.bytes.load(Ordering::Relaxed)
    }
}

impl Jobs for Engine {
    fn width(&self) -> usize {
        self.pool.current_num_threads()
    }

    fn spawn(&self, _: Priority, job: Job) {
        self.pool.spawn(job);
    }

    fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
        let counted = |k| {
            if COUNTED.replace(true) {
                return body(k);
            }
            let held = allocation_counter::measure(|| body(k)).bytes_current;
            COUNTED.set(false);
            self.bytes.fetch_add(held, Ordering::Relaxed);
        };
        self.pool.install(|| Rayon.for_each(count, &counted));
    }
}

/// Starts threads for each loop, which take the next number when they are done with one.
struct Scoped(usize);

impl Jobs for Scoped {
    fn width(&self) -> usize {
        self.0
    }

    fn spawn(&self, _: Priority, job: Job) {
        thread::spawn(job);
    }

    fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
        let next = AtomicUsize::new(0);
        let take = || while Some(next.fetch_add(1, Ordering::Relaxed)).filter(|k| *k < count).map(body).is_some() {};
        thread::scope(|scope| {
            (1..self.0.min(count)).for_each(|_| drop(scope.spawn(take)));
            take();
        });
    }
}

/// Makes the calls of a loop in shuffled order, on the caller's thread.
struct Shuffled(Mutex<SplitMix>);

impl Jobs for Shuffled {
    fn width(&self) -> usize {
        5
    }

    fn spawn(&self, _: Priority, job: Job) {
        job();
    }

    fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
        let mut order: Vec<usize> = (0..count).collect();
        for k in (1..count).rev() {
            let other = self.0.lock().unwrap().below(k as u64 + 1);
            order.swap(k, usize::try_from(other).unwrap());
        }
        order.into_iter().for_each(body);
    }
}

fn pools() -> [(&'static str, Box<dyn Jobs>); 9] {
    [
        ("none", Box::new(Alone)),
        ("one of its own", Box::new(Threads::start(1).unwrap())),
        ("three of its own", Box::new(Threads::start(3).unwrap())),
        ("rayon's", Box::new(Rayon)),
        ("an engine's one", Box::new(Engine::of(1))),
        ("an engine's two", Box::new(Engine::of(2))),
        ("one for each loop", Box::new(Scoped(1))),
        ("three for each loop", Box::new(Scoped(3))),
        ("shuffled", Box::new(Shuffled(Mutex::new(SplitMix(1))))),
    ]
}

/// A hash of all that a value is, as far as it is printed.
fn hash(value: &impl fmt::Debug) -> u64 {
    struct Hashed(DefaultHasher);
    impl Write for Hashed {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            self.0.write(text.as_bytes());
            Ok(())
        }
    }
    let mut hashed = Hashed(DefaultHasher::new());
    write!(hashed, "{value:?}").unwrap();
    hashed.0.finish()
}

fn text() -> Vec<u8> {
    std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/nist_ctc05.step")).unwrap()
}

/// A solid of a file, faces with free trims whose borders are sewn, and an assembly.
fn models() -> [Model; 3] {
    let built = |name| trimtess_models::by_name(name).unwrap();
    [read(&text(), &StepOptions::DEFAULT).unwrap(), built("flower-teapot"), built("brake-assembly")]
}

fn prepared(jobs: &dyn Jobs, model: &Model) -> Prepared {
    prepare_on(jobs, model, &PrepareOptions::DEFAULT, &Control::default()).unwrap()
}

#[test]
fn models_do_not_depend_on_whose_threads_read_and_prepare_them() {
    let (text, models) = (text(), models());
    // A syntax error in the middle, so that the text is parsed in pieces twice.
    let mut broken = text.clone();
    let middle = broken.len() / 2;
    broken[middle..middle + 3].copy_from_slice(b"=(;");
    let results = pools().map(|(name, jobs)| {
        let texts = [&text, &broken].map(|text| {
            let model = read_on(&*jobs, text, &StepOptions::DEFAULT, &Control::default());
            hash(&model.map_err(|error| error.to_string()))
        });
        (name, texts, models.each_ref().map(|model| hash(&prepared(&*jobs, model))))
    });
    for (name, texts, models) in &results {
        assert_eq!((*texts, *models), (results[0].1, results[0].2), "threads: {name}");
    }
}

#[test]
fn reading_and_preparing_from_within_a_job_does_not_deadlock() {
    let (text, [model, ..]) = (Arc::new(text()), models());
    let expected = hash(&prepared(&Alone, &model));
    for threads in [1, 2] {
        let jobs = Arc::new(Engine::of(threads));
        let (send, made) = mpsc::channel();
        for _ in 0..3 {
            let (inner, send, text) = (Arc::clone(&jobs), send.clone(), Arc::clone(&text));
            let work = move || {
                let model = read_on(&*inner, &text, &StepOptions::DEFAULT, &Control::default()).unwrap();
                send.send(hash(&prepared(&*inner, &model))).unwrap();
            };
            jobs.spawn(Priority::Frame, Box::new(work));
        }
        drop(send);
        assert!(made.iter().eq([expected; 3]), "{threads} threads");
    }
}

/// A loop that waits may run a frame of a session on top of it, and a frame its helpers.
#[test]
fn sessions_and_loops_share_a_pool() {
    let model = trimtess_models::by_name("brake-assembly").unwrap();
    let ready = Arc::new(prepared(&Alone, &model));
    let [low, high] = ready.bounds.unwrap();
    let (middle, size) = (0.5 * (low + high), (high - low).length());
    let view = |k: u32| {
        let eye = middle + size * (0.4 + 0.3 * f64::from(k % 4)) * trimtess::glam::DVec3::X;
        let projection = Projection::Perspective { fov_y: 0.7, near: 0.01 * size };
        let camera = Camera::looking_at(eye, middle, trimtess::glam::DVec3::Z, projection);
        View { camera, size: (960, 540), deviation_px: 0.5, size_px: None, angle: 0.5 }
    };
    for threads in [1, 2, 3] {
        let jobs = Arc::new(Engine::of(threads));
        let (send, ended) = mpsc::channel();
        for _ in 0..4 {
            let (inner, model, send) = (Arc::clone(&jobs), model.clone(), send.clone());
            let work = move || send.send(prepared(&*inner, &model).parts.len()).unwrap();
            jobs.spawn(Priority::Frame, Box::new(work));
        }
        drop(send);
        let mut session = Session::start_on(jobs, Arc::clone(&ready), &SessionOptions::DEFAULT);
        let mut sink = MemorySink::default();
        for k in 0..12 {
            session.view(&[view(k)], &mut sink).unwrap();
        }
        assert_eq!(ended.iter().collect::<Vec<_>>(), [model.parts.len(); 4]);
    }
}

/// A control that is cancelled once `after` units of a stage are done, and the numbers that its observer hears.
fn stopped(after: u64) -> (Control, Arc<Mutex<Vec<u64>>>) {
    let (own, heard) = (Arc::<Mutex<Option<Control>>>::default(), Arc::<Mutex<Vec<u64>>>::default());
    let (reader, writer) = (Arc::clone(&own), Arc::clone(&heard));
    let control = Control::observed_by(move |progress| {
        assert!(matches!(progress.stage, Stage::Read | Stage::Prepare));
        writer.lock().unwrap().push(progress.done);
        if progress.done >= after {
            reader.lock().unwrap().take().iter().for_each(Control::cancel);
        }
    });
    *own.lock().unwrap() = Some(control.clone());
    (control, heard)
}

#[test]
fn observers_cancel_at_any_moment_and_hear_of_more_and_more() {
    let ([model, ..], mut random) = (models(), SplitMix(2));
    let whole = hash(&prepared(&Alone, &model));
    let faces = model.parts.iter().map(|part| part.faces.len() as u64).sum::<u64>();
    for (name, jobs) in pools() {
        for after in (0..6).map(|_| random.below(faces + 20)) {
            let (control, heard) = stopped(after);
            match prepare_on(&*jobs, &model, &PrepareOptions::DEFAULT, &control) {
                Ok(prepared) => assert!(after > faces && hash(&prepared) == whole, "{name}, {after}"),
                Err(error) => assert!(after <= faces && error == PrepareError::Cancelled, "{name}, {after}"),
            }
            let heard = heard.lock().unwrap();
            assert!(heard[0] == 0 && heard.is_sorted_by(|a, b| a < b), "{name}: {heard:?}");
            assert!(after <= faces || heard.last() == Some(&faces), "{name}: {heard:?}");
        }
    }
}

/// Calls `work` with controls that another thread cancels at random moments within `time`, and asserts that less than
/// 1 % of what a whole call allocates is left afterwards.
fn assert_nothing_left(engine: &Engine, whole: u64, time: Duration, work: impl Fn(&Control)) {
    let mut random = SplitMix(3);
    let mut left = 0;
    for _ in 0..30 {
        let control = Control::default();
        let ours = control.clone();
        let delay = time.mul_f64(1e-3 * random.below(1000) as f64);
        let asks = thread::spawn(move || {
            thread::sleep(delay);
            ours.cancel();
        });
        left += engine.held(|| work(&control));
        asks.join().unwrap();
    }
    assert!(left.unsigned_abs() < whole / 100, "{left} bytes are left of 30 calls that take {whole}");
}

#[test]
fn cancelled_calls_leave_no_memory() {
    let (text, [model, ..]) = (text(), models());
    for threads in [1, 2, 3] {
        let engine = Engine::of(threads);
        let reads = |control: &Control| match read_on(&engine, &text, &StepOptions::DEFAULT, control) {
            Ok(_) | Err(StepError::Cancelled) => {}
            Err(error) => panic!("{error}"),
        };
        let prepares = |control: &Control| match prepare_on(&engine, &model, &PrepareOptions::DEFAULT, control) {
            Ok(_) | Err(PrepareError::Cancelled) => {}
            Err(error) => panic!("{error}"),
        };
        for work in [&reads as &dyn Fn(&Control), &prepares] {
            // What is allocated once: of the pool, of spans.
            work(&Control::default());
            let start = Instant::now();
            let whole = allocation_counter::measure(|| work(&Control::default())).bytes_total;
            assert_nothing_left(&engine, whole, start.elapsed(), work);
        }
    }
}
