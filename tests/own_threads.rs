//! Contract: with an engine's pool, no new thread appears, neither while a model is read and prepared nor while frames
//! are made. One test, because it counts the threads of the process.
#![cfg(all(target_os = "linux", feature = "step"))]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use trimtess::control::{Control, Job, Jobs, Priority, Rayon};
use trimtess::frame::{Tolerance, plan_on};
use trimtess::import::step::{StepOptions, read_on};
use trimtess::mesh::MemorySink;
use trimtess::parallel::{Session, SessionOptions, tessellate_on};
use trimtess::prepare::{PrepareOptions, prepare_on};

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
fn no_thread_is_started_beside_an_engines_pool() {
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
    let plan = Arc::new(plan_on(&*jobs, &prepared, &tolerance, &trimtess::frame::PlanLimits::DEFAULT));
    tessellate_on(&*jobs, &prepared, &plan, true, &control, &mut MemorySink::default()).unwrap();
    let mut session = Session::start_on(jobs, prepared, &SessionOptions::DEFAULT);
    session.frame_controlled(Arc::clone(&plan), &control, &mut MemorySink::default()).unwrap();
    assert_eq!((most.load(Ordering::Relaxed), threads()), (before, before));
}
