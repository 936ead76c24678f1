//! Contract: sessions on anybody's threads. The same bytes on threads of their own, on an engine's pool, on none, and
//! in any order; no deadlock from within a job.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "common/blocks.rs"]
mod blocks;
mod common;
#[path = "common/pools.rs"]
mod pools;

use blocks::{BlockSink, Blocks};
use common::prepared;
use pools::{Engine, Shuffled};
use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, mpsc};
use std::thread::{self, ThreadId};
use std::time::Duration;
use trimtess::control::{Alone, Job, Jobs, Priority, Threads};
use trimtess::frame::{PlanLimits, Tolerance, plan_for_view_within, plan_within};
use trimtess::glam::DVec3;
use trimtess::mesh::{Batch, MemorySink, SinkError, TileMemory, VertexLayout, WrittenTile};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::Prepared;
use trimtess::view::{Camera, Projection, View};

/// Runs a job in the call that spawns it, and keeps what jobs are for.
#[derive(Default)]
struct AtOnce(Mutex<Vec<Priority>>);

impl Jobs for AtOnce {
    fn width(&self) -> usize {
        3
    }

    fn spawn(&self, priority: Priority, job: Job) {
        self.0.lock().unwrap().push(priority);
        job();
    }
}

/// A pool that panics once it is broken.
#[derive(Default)]
struct Breakable(AtomicBool);

impl Jobs for Breakable {
    fn width(&self) -> usize {
        assert!(!self.0.load(Ordering::Relaxed), "the pool is broken");
        1
    }

    fn spawn(&self, _: Priority, _: Job) {}
}

fn model() -> Arc<Prepared> {
    prepared(trimtess_models::by_name("brake-assembly").unwrap())
}

/// Views from closer and closer, and back.
fn views(prepared: &Prepared) -> Vec<View> {
    let [low, high] = prepared.bounds.unwrap();
    let (middle, size) = (0.5 * (low + high), (high - low).length());
    let at = |k: u32| {
        let away = size * (0.4 + 0.3 * (f64::from(k) - 4.0).abs());
        let eye = middle + away * DVec3::new(1.0, 0.3 * f64::from(k), 0.5).normalize();
        let projection = Projection::Perspective { fov_y: 0.7, near: 0.01 * size };
        let camera = Camera::looking_at(eye, middle, DVec3::Z, projection);
        View { camera, size: (960, 540), deviation_px: 0.5, size_px: None, angle: 0.5 }
    };
    (0..8).map(at).collect()
}

/// Records which threads write. Others than the caller wait until the caller writes, too.
struct Together {
    blocks: Arc<Blocks>,
    caller: ThreadId,
    seen: Mutex<HashSet<ThreadId>>,
    more: Condvar,
}

impl Together {
    /// Waits until as many threads have written.
    fn wait_for(&self, threads: usize) {
        let seen = self.seen.lock().unwrap();
        let fewer = |seen: &mut HashSet<ThreadId>| seen.len() < threads;
        let (seen, waited) = self.more.wait_timeout_while(seen, Duration::from_secs(60), fewer).unwrap();
        assert!(!waited.timed_out(), "only {seen:?} wrote");
    }
}

impl TileMemory for Together {
    fn write(&self, tile: &WrittenTile, fill: &mut dyn FnMut(&mut [u8], &mut [u8])) -> Result<u64, SinkError> {
        let place = self.blocks.write(tile, fill)?;
        self.seen.lock().unwrap().insert(thread::current().id());
        self.more.notify_all();
        if thread::current().id() != self.caller {
            self.wait_for(2);
        }
        Ok(place)
    }

    fn release(&self, tile: &WrittenTile) {
        self.blocks.release(tile);
    }
}

type Frames = Vec<(Vec<Batch>, usize)>;

/// What the sink holds after each frame, without the workers' numbers.
fn frames(jobs: Arc<dyn Jobs>, workers: usize, prepared: &Arc<Prepared>) -> Frames {
    let options = SessionOptions::DEFAULT.with_workers(workers);
    let mut session = Session::start_on(jobs, Arc::clone(prepared), &options);
    assert!(workers == 0 || session.workers() == workers);
    let mut sink = MemorySink::default();
    let held = views(prepared).into_iter().enumerate().map(|(k, view)| {
        if k % 3 == 2 {
            // A frame that another one replaces.
            session.begin(&[view]).unwrap();
        }
        if k % 2 == 0 {
            session.begin(&[view]).unwrap();
            session.finish(&mut sink).unwrap();
        } else {
            session.view(&[view], &mut sink).unwrap();
        }
        let batches = sink.batches.iter().cloned().map(|batch| Batch { worker: 0, ..batch });
        (batches.collect(), sink.edge_lines.len())
    });
    held.collect()
}

#[test]
fn frames_do_not_depend_on_whose_threads_make_them() {
    let prepared = model();
    let expected = frames(Arc::new(Alone), 1, &prepared);
    assert!(expected.windows(2).any(|w| w[0] != w[1]));
    let pools: [(&str, Arc<dyn Jobs>); 6] = [
        ("own", Arc::new(Threads::start(3).unwrap())),
        ("an engine's", Arc::new(Engine::of(2))),
        ("of one", Arc::new(Engine::of(1))),
        ("shuffled", Arc::new(Shuffled::default())),
        ("at once", Arc::new(AtOnce::default())),
        ("none", Arc::new(Alone)),
    ];
    for (name, jobs) in pools {
        for workers in [0, 1, 2, 3, 8, 29] {
            let made = frames(Arc::clone(&jobs), workers, &prepared);
            assert!(made == expected, "{name}, {workers} workers");
        }
    }
}

#[test]
fn jobs_say_what_they_are_for() {
    let jobs = Arc::new(AtOnce::default());
    frames(Arc::clone(&jobs) as Arc<dyn Jobs>, 3, &model());
    let told = jobs.0.lock().unwrap();
    let begun = told.iter().filter(|priority| **priority == Priority::Frame).count();
    // Frames 0, 2, 4 and 6 are begun, 2 and 5 also before another one replaces them. `view` spawns none.
    assert_eq!((told[0], begun), (Priority::Frame, 6));
    assert!(told.len() > begun && told.iter().all(|priority| *priority <= Priority::Helper), "{told:?}");
}

#[test]
fn plans_do_not_depend_on_whose_threads_make_them() {
    let prepared = model();
    let tolerance = Tolerance { chord: 1e-3 * prepared.diagonal, angle: 0.35, max_edge: None };
    let few = PlanLimits::DEFAULT.with_triangles(3_000);
    let pools: [Arc<dyn Jobs>; 3] =
        [Arc::new(Threads::start(3).unwrap()), Arc::new(Shuffled::default()), Arc::new(Alone)];
    for jobs in pools {
        let session = Session::start_on(jobs, Arc::clone(&prepared), &SessionOptions::DEFAULT);
        for limits in [PlanLimits::DEFAULT, few] {
            assert_eq!(session.plan_within(&tolerance, &limits), plan_within(&prepared, &tolerance, &limits));
            let view = views(&prepared)[3];
            assert_eq!(session.plan_for_view(&view, &limits), plan_for_view_within(&prepared, &view, &limits));
        }
    }
}

#[test]
fn a_frame_from_within_a_job_does_not_deadlock() {
    let prepared = model();
    let expected = frames(Arc::new(Alone), 1, &prepared);
    for threads in [1, 2] {
        let jobs = Arc::new(Engine::of(threads));
        let (send, made) = mpsc::channel();
        let (inner, model) = (Arc::clone(&jobs), Arc::clone(&prepared));
        jobs.spawn(Priority::Frame, Box::new(move || drop(send.send(frames(inner, 0, &model)))));
        assert!(made.recv().unwrap() == expected, "{threads} threads");
    }
}

/// Jobs that begin frames, and jobs that finish them, wherever the pool runs them: on top of a job that waits, too.
#[test]
fn frames_begun_in_one_job_and_finished_in_another_do_not_deadlock() {
    let prepared = model();
    let views = views(&prepared);
    for threads in [1, 2, 3] {
        let jobs = Arc::new(Engine::of(threads));
        let (send, ended) = mpsc::channel();
        for _ in 0..3 {
            let session = Session::start_on(jobs.clone(), Arc::clone(&prepared), &SessionOptions::DEFAULT);
            let passed = Arc::new(Mutex::new((session, MemorySink::default())));
            for &view in views.iter().cycle().take(16) {
                let begins = Arc::clone(&passed);
                jobs.spawn(Priority::Frame, Box::new(move || begins.lock().unwrap().0.begin(&[view]).unwrap()));
                let (finishes, send) = (Arc::clone(&passed), send.clone());
                jobs.spawn(
                    Priority::Frame,
                    Box::new(move || {
                        let (session, sink) = &mut *finishes.lock().unwrap();
                        send.send(session.finish(sink).map(|_| ())).unwrap();
                    }),
                );
            }
        }
        drop(send);
        assert_eq!(ended.iter().filter(Result::is_ok).count(), 48, "{threads} threads");
    }
}

/// The session has one thread besides the caller, which makes the frame that was begun: tiles of eight workers.
#[test]
fn a_caller_who_waits_for_a_frame_helps_to_make_it() {
    let prepared = model();
    let options = SessionOptions::DEFAULT.with_threads(2);
    let mut session = Session::start(Arc::clone(&prepared), &options).unwrap();
    let (mut sink, caller) = (BlockSink::default(), thread::current().id());
    let blocks = Arc::clone(&sink.memory);
    let memory = Arc::new(Together { blocks, caller, seen: Mutex::default(), more: Condvar::new() });
    session.write_into(VertexLayout::COMPACT, Arc::<Together>::clone(&memory));
    session.begin(&views(&prepared)[..1]).unwrap();
    memory.wait_for(1);
    let report = session.finish(&mut sink).unwrap();
    assert!(report.tiles > 0 && report.tiles == sink.tiles.len(), "{} of {}", sink.tiles.len(), report.tiles);
    let seen = memory.seen.lock().unwrap();
    assert!(seen.len() == 2 && seen.contains(&caller), "{seen:?}");
}

#[test]
fn a_session_on_a_pool_starts_no_thread() {
    let jobs = Arc::new(Engine::of(2));
    let own: HashSet<ThreadId> = jobs.pool.broadcast(|_| thread::current().id()).into_iter().collect();
    frames(Arc::clone(&jobs) as Arc<dyn Jobs>, 0, &model());
    let mut seen = jobs.seen.lock().unwrap().clone();
    // What the pool has not begun, the caller does.
    seen.remove(&thread::current().id());
    assert!(!seen.is_empty() && seen.is_subset(&own), "{seen:?} of {own:?}");
}

#[test]
fn an_internal_error_is_told_once() {
    let prepared = model();
    let pool = Arc::<Breakable>::default();
    let mut session =
        Session::start_on(Arc::clone(&pool) as Arc<dyn Jobs>, Arc::clone(&prepared), &SessionOptions::DEFAULT);
    session.begin(&views(&prepared)).unwrap();
    pool.0.store(true, Ordering::Relaxed);
    // Not by `add_instance`: a frame that is cancelled asks nothing of the pool.
    let told = session.finish(&mut MemorySink::default()).unwrap_err().to_string();
    assert_eq!(told, "an internal error ended the session: the pool is broken");
    assert_eq!(session.add_instance(prepared.scene.instances[0].clone()).unwrap_err().to_string(), told);
}
