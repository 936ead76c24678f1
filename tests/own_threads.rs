//! Contract: with an engine's pool, no new thread appears, neither while a model is read and prepared nor while frames
//! are made. With threads of its own, a session leaves none, whatever was cancelled. One test, because it counts the
//! threads of the process.
#![cfg(all(target_os = "linux", feature = "step"))]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use trimtess::control::{Control, Job, Jobs, Priority, Rayon};
use trimtess::frame::{PlanLimits, Tolerance, plan_on};
use trimtess::import::step::{StepOptions, read_on};
use trimtess::mesh::MemorySink;
use trimtess::parallel::{FrameError, Session, SessionOptions, tessellate_on};
use trimtess::prepare::{PrepareOptions, Prepared, prepare_on};
use trimtess::view::{CameraPath, Picture, View};

/// An engine's pool: rayon's.
struct Engine(rayon::ThreadPool);

impl Jobs for Engine {
    fn width(&self) -> usize {
        self.0.current_num_threads()
    }

    fn spawn(&self, _: Priority, job: Job) {
        self.0.spawn(job);
    }

    fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
        self.0.install(|| Rayon.for_each(count, body));
    }
}

fn threads() -> usize {
    std::fs::read_dir("/proc/self/task").unwrap().count()
}

#[test]
fn threads_are_those_of_pools_and_of_sessions_alive() {
    let prepared = assert_no_thread_beside_an_engines_pool();
    for cancel in [cancelled, replaced, cancelled_by_an_observer, dropped] {
        assert_cancelled_sessions_leave_no_thread(&prepared, cancel);
    }
}

fn assert_no_thread_beside_an_engines_pool() -> Arc<Prepared> {
    let text = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/nist_ctc05.step")).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    // Threads are counted once they have begun.
    pool.broadcast(|_| ());
    let (jobs, before, most) = (Arc::new(Engine(pool)), threads(), Arc::new(AtomicUsize::new(0)));
    let seen = Arc::clone(&most);
    let control = Control::observed_by(move |_| {
        seen.fetch_max(threads(), Ordering::Relaxed);
    });
    let model = read_on(&*jobs, &text, &StepOptions::DEFAULT, &control).unwrap();
    let prepared = Arc::new(prepare_on(&*jobs, &model, &PrepareOptions::DEFAULT, &control).unwrap());
    let tolerance = Tolerance { chord: 1e-3 * prepared.diagonal, angle: 0.35, max_edge: None };
    let plan = Arc::new(plan_on(&*jobs, &prepared, &tolerance, &PlanLimits::DEFAULT, &Control::default()).unwrap());
    tessellate_on(&*jobs, &prepared, &plan, true, &control, &mut MemorySink::default()).unwrap();
    let mut session = Session::start_on(jobs, Arc::clone(&prepared), &SessionOptions::DEFAULT);
    session.frame_controlled(Arc::clone(&plan), &control, &mut MemorySink::default()).unwrap();
    assert_eq!((most.load(Ordering::Relaxed), threads()), (before, before));
    drop(session);
    // Its pool goes with the session, at its own time.
    assert_soon(before - 2);
    prepared
}

/// Waits until there are so many threads: a thread that was joined is listed for a moment. Panics if they do not come.
fn assert_soon(count: usize) {
    for _ in 0..1000 {
        if threads() == count {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("{} threads instead of {count}", threads());
}

fn views(prepared: &Prepared) -> Vec<View> {
    let picture = Picture { size: (640, 480), deviation_px: 0.1, size_px: None, angle: 0.5 };
    CameraPath::Orbit.views(prepared.bounds.unwrap(), 4, &picture)
}

fn cancelled(session: &mut Session) {
    for view in views(session.prepared()) {
        session.begin(&[view]).unwrap();
        session.cancel();
    }
    assert_eq!(session.finish(&mut MemorySink::default()).unwrap().tiles, 0);
}

fn replaced(session: &mut Session) {
    let views = views(session.prepared());
    views.iter().for_each(|view| session.begin(&[*view]).unwrap());
    session.finish(&mut MemorySink::default()).unwrap();
}

fn cancelled_by_an_observer(session: &mut Session) {
    let own = Arc::<Mutex<Option<Control>>>::default();
    let reader = Arc::clone(&own);
    let control = Control::observed_by(move |progress| {
        if progress.done > 2 {
            reader.lock().unwrap().take().iter().for_each(Control::cancel);
        }
    });
    *own.lock().unwrap() = Some(control.clone());
    let plan = session.plan_for_view(&views(session.prepared())[0], &PlanLimits::DEFAULT);
    let ended = session.frame_controlled(plan, &control, &mut MemorySink::default());
    assert!(matches!(ended, Err(FrameError::Cancelled)), "{ended:?}");
}

/// With a frame that was begun.
fn dropped(session: &mut Session) {
    session.begin(&views(session.prepared())).unwrap();
}

fn assert_cancelled_sessions_leave_no_thread(prepared: &Arc<Prepared>, cancel: fn(&mut Session)) {
    let (before, options) = (threads(), SessionOptions::DEFAULT.with_threads(3).with_workers(8));
    let mut session = Session::start(Arc::clone(prepared), &options).unwrap();
    cancel(&mut session);
    // The third is the caller's.
    assert_soon(before + 2);
    drop(session);
    assert_soon(before);
}
