//! Progress of long work, and work that is stopped.
#![cfg(feature = "step")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::DVec3;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use trimtess::control::{Alone, Control, Jobs, Progress, Rayon, Stage, Threads};
use trimtess::frame::{Plan, PlanError, PlanLimits, Tolerance, plan, plan_for_view_on, plan_on};
use trimtess::import::step::{StepError, StepOptions, read_on};
use trimtess::mesh::{Batch, EdgeLine, MemorySink, MeshSink, Scene, SinkError};
use trimtess::model::Model;
use trimtess::parallel::{FrameError, Session, SessionOptions, tessellate_on};
use trimtess::prepare::{PrepareError, PrepareOptions, Prepared, prepare, prepare_on};
use trimtess::view::{Camera, Projection, View};

fn text() -> Vec<u8> {
    std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/nist_ctc05.step")).unwrap()
}

fn model() -> Model {
    read_on(&Rayon, &text(), &StepOptions::DEFAULT, &Control::default()).unwrap()
}

fn planned() -> (Arc<Prepared>, Arc<Plan>) {
    let prepared = Arc::new(prepare(model(), &PrepareOptions::DEFAULT).unwrap());
    let tolerance = Tolerance { chord: 1e-3 * prepared.diagonal, angle: 0.35, max_edge: None };
    let plan = Arc::new(plan(&prepared, &tolerance));
    (prepared, plan)
}

/// A control that remembers all progress.
fn watched() -> (Control, Arc<Mutex<Vec<Progress>>>) {
    let heard = Arc::<Mutex<Vec<Progress>>>::default();
    let writer = Arc::clone(&heard);
    (Control::observed_by(move |progress| writer.lock().unwrap().push(progress)), heard)
}

/// A control that asks to stop once `after` units are done.
fn stopped(after: u64) -> Control {
    let own = Arc::<Mutex<Option<Control>>>::default();
    let reader = Arc::clone(&own);
    let control = Control::observed_by(move |progress| {
        if progress.done >= after {
            reader.lock().unwrap().iter().for_each(Control::cancel);
        }
    });
    *own.lock().unwrap() = Some(control.clone());
    control
}

/// Asserts that larger and larger numbers were heard, from 0 to the total; all of them if one thread did the work.
fn assert_complete(heard: &Mutex<Vec<Progress>>, stage: Stage, total: u64, alone: bool) {
    let heard = heard.lock().unwrap();
    let counts: Vec<u64> = heard.iter().map(|progress| progress.done).collect();
    assert!(counts.is_sorted_by(|a, b| a < b), "{counts:?}");
    assert_eq!((counts.first(), counts.last()), (Some(&0), Some(&total)));
    assert!(!alone || counts.iter().copied().eq(0..=total), "{counts:?}");
    assert!(heard.iter().all(|progress| (progress.stage, progress.total) == (stage, total)));
}

#[test]
fn parts_faces_and_tiles_are_counted_upwards() {
    let model = model();
    let (prepared, plan) = planned();
    let faces = model.parts.iter().map(|part| part.faces.len() as u64).sum();
    let tiles = prepared.parts.iter().map(|part| part.tiles.len() as u64).sum();
    for jobs in [&Alone as &dyn Jobs, &Threads::start(3).unwrap()] {
        let alone = jobs.width() == 1;
        let (control, heard) = watched();
        read_on(jobs, &text(), &StepOptions::DEFAULT, &control).unwrap();
        assert_complete(&heard, Stage::Read, model.parts.len() as u64, alone);

        let (control, heard) = watched();
        prepare_on(jobs, &model, &PrepareOptions::DEFAULT, &control).unwrap();
        assert_complete(&heard, Stage::Prepare, faces, alone);

        let (control, heard) = watched();
        tessellate_on(jobs, &prepared, &plan, true, &control, &mut MemorySink::default()).unwrap();
        assert_complete(&heard, Stage::Tessellate, tiles, alone);
    }
}

#[test]
fn a_model_that_is_kept_is_prepared_as_one_that_is_given_away() {
    let kept = model();
    let of_kept = prepare_on(&Rayon, &kept, &PrepareOptions::DEFAULT, &Control::default()).unwrap();
    let given = prepare(kept, &PrepareOptions::DEFAULT).unwrap();
    assert_eq!(of_kept.scene, given.scene);
    assert_eq!(of_kept.diagnostics, given.diagnostics);
    assert_eq!((of_kept.bounds, of_kept.diagonal), (given.bounds, given.diagonal));
}

#[test]
fn a_plan_is_cancelled() {
    let (prepared, plan) = planned();
    let tolerance = Tolerance { chord: 1e-3 * prepared.diagonal, angle: 0.35, max_edge: None };
    let camera = Camera::looking_at(DVec3::X, DVec3::ZERO, DVec3::Z, Projection::Orthographic { height: 100.0 });
    let view = View { camera, size: (640, 480), deviation_px: 0.5, size_px: None, angle: View::ANGLE };
    let limits = PlanLimits::DEFAULT;
    for jobs in [&Alone as &dyn Jobs, &Threads::start(3).unwrap()] {
        let control = Control::default();
        assert_eq!(plan_on(jobs, &prepared, &tolerance, &limits, &control).unwrap(), *plan);
        control.cancel();
        assert_eq!(plan_on(jobs, &prepared, &tolerance, &limits, &control), Err(PlanError::Cancelled));
        // Limits ask for several attempts.
        let few = limits.with_triangles(100);
        assert_eq!(plan_on(jobs, &prepared, &tolerance, &few, &control), Err(PlanError::Cancelled));
        assert_eq!(plan_for_view_on(jobs, &prepared, &view, &limits, &control), Err(PlanError::Cancelled));
    }
}

#[test]
fn cancelled_work_ends_with_an_error() {
    let read = read_on(&Rayon, &text(), &StepOptions::DEFAULT, &stopped(0));
    assert!(matches!(read, Err(StepError::Cancelled)));
    for after in [0, 1, 40] {
        let prepared = prepare_on(&Rayon, &model(), &PrepareOptions::DEFAULT, &stopped(after));
        assert_eq!(prepared.err(), Some(PrepareError::Cancelled), "after {after} faces");
    }
}

/// Fails when it is touched.
struct Untouchable;

impl MeshSink for Untouchable {
    fn begin(&mut self, _: &Scene) -> Result<(), SinkError> {
        panic!("a cancelled frame reached the sink")
    }

    fn batch(&mut self, _: &mut Batch) -> Result<(), SinkError> {
        panic!("a cancelled frame reached the sink")
    }

    fn edge_line(&mut self, _: EdgeLine) -> Result<(), SinkError> {
        panic!("a cancelled frame reached the sink")
    }

    fn end(&mut self) -> Result<(), SinkError> {
        panic!("a cancelled frame reached the sink")
    }

    fn abort(&mut self) {
        panic!("a cancelled frame reached the sink")
    }
}

#[test]
fn a_cancelled_frame_touches_no_sink() {
    let (prepared, plan) = planned();
    for after in [0, 1, 5] {
        let ended = tessellate_on(&Alone, &prepared, &plan, true, &stopped(after), &mut Untouchable);
        assert!(matches!(ended, Err(FrameError::Cancelled)), "after {after} tiles");
    }
}

/// Cancels in one of its calls, or refuses it.
#[derive(Default)]
struct Canceller {
    control: Control,
    refuses: bool,
    /// Number of the call, from 1; 0 is `begin`.
    at: usize,
    batches: usize,
    lines: usize,
    aborts: usize,
    ends: usize,
}

impl Canceller {
    fn call(&mut self) -> Result<(), SinkError> {
        match self.at == self.batches + self.lines + self.ends {
            true if self.refuses => Err(SinkError::new("disk", std::io::Error::other("full"))),
            true => {
                self.control.cancel();
                Ok(())
            }
            false => Ok(()),
        }
    }
}

impl MeshSink for Canceller {
    fn begin(&mut self, _: &Scene) -> Result<(), SinkError> {
        self.call()
    }

    fn batch(&mut self, _: &mut Batch) -> Result<(), SinkError> {
        self.batches += 1;
        self.call()
    }

    fn edge_line(&mut self, _: EdgeLine) -> Result<(), SinkError> {
        self.lines += 1;
        self.call()
    }

    fn end(&mut self) -> Result<(), SinkError> {
        self.ends += 1;
        self.call()
    }

    fn abort(&mut self) {
        self.aborts += 1;
    }
}

#[test]
fn a_frame_that_is_cancelled_or_refused_in_its_commit_is_aborted_after_the_call_in_hand() {
    let (prepared, plan) = planned();
    let mut all = MemorySink::default();
    tessellate_on(&Alone, &prepared, &plan, true, &Control::default(), &mut all).unwrap();
    let (batches, lines) = (all.batches.len(), all.edge_lines.len());
    let all = batches + lines;
    let cancelled = [1, 7, batches, batches + 1, all].map(|at| (at, false));
    let refused = [0, 1, 7, batches, batches + 1, all, all + 1].map(|at| (at, true));
    let mut session = Session::start(Arc::clone(&prepared), &SessionOptions::DEFAULT.with_workers(2)).unwrap();
    for (at, refuses) in cancelled.into_iter().chain(refused) {
        let sent = (at.min(batches), at.saturating_sub(batches).min(lines));
        for in_session in [false, true] {
            let mut sink = Canceller { at, refuses, ..Canceller::default() };
            let control = sink.control.clone();
            let ended = if in_session {
                session.frame_controlled(Arc::clone(&plan), &control, &mut sink)
            } else {
                tessellate_on(&Alone, &prepared, &plan, true, &control, &mut sink)
            };
            let why = ended.unwrap_err().to_string();
            assert_eq!(why, if refuses { "disk: full".to_owned() } else { FrameError::Cancelled.to_string() }, "{at}");
            let ends = usize::from(at > all);
            assert_eq!(((sink.batches, sink.lines), sink.aborts, sink.ends), (sent, 1, ends));
        }
    }
    let mut whole = MemorySink::default();
    let report = session.frame(plan, &mut whole).unwrap();
    assert!(report.whole && whole.batches.len() == report.batches);
}

#[test]
fn one_worker_stops_after_the_tile_in_hand() {
    let (prepared, plan) = planned();
    let (own, made) = (Arc::<Mutex<Option<Control>>>::default(), Arc::<AtomicU64>::default());
    let (reader, count) = (Arc::clone(&own), Arc::clone(&made));
    let control = Control::observed_by(move |progress| {
        count.fetch_max(progress.done, Ordering::Relaxed);
        if progress.done == 5 {
            reader.lock().unwrap().iter().for_each(Control::cancel);
        }
    });
    *own.lock().unwrap() = Some(control.clone());
    let ended = tessellate_on(&Alone, &prepared, &plan, true, &control, &mut Untouchable);
    assert!(matches!(ended, Err(FrameError::Cancelled)));
    assert_eq!(made.load(Ordering::Relaxed), 5);
}

#[test]
fn a_session_goes_on_after_a_cancelled_frame() {
    let (prepared, plan) = planned();
    let options = SessionOptions::DEFAULT.with_workers(2);
    let mut session = Session::start(Arc::clone(&prepared), &options).unwrap();
    for after in [0, 1, 30] {
        let ended = session.frame_controlled(Arc::clone(&plan), &stopped(after), &mut Untouchable);
        assert!(matches!(ended, Err(FrameError::Cancelled)), "after {after} tiles");
    }
    let (mut after, mut fresh) = (MemorySink::default(), MemorySink::default());
    session.frame(Arc::clone(&plan), &mut after).unwrap();
    tessellate_on(&Alone, &prepared, &plan, true, &Control::default(), &mut fresh).unwrap();
    assert_eq!(after.batches.len(), fresh.batches.len());
    let meshes = |frame: MemorySink| frame.batches.into_iter().map(|batch| batch.mesh).collect::<Vec<_>>();
    assert!(meshes(after) == meshes(fresh));
}

#[test]
fn an_observer_that_panics_costs_its_frame_only() {
    let (prepared, plan) = planned();
    let mut session = Session::start(Arc::clone(&prepared), &SessionOptions::DEFAULT.with_workers(3)).unwrap();
    let mut whole = MemorySink::default();
    session.frame(Arc::clone(&plan), &mut whole).unwrap();
    let bad = Control::observed_by(|progress| assert!(progress.done < 5, "an observer"));
    let ended = catch_unwind(AssertUnwindSafe(|| {
        session.frame_controlled(Arc::clone(&plan), &bad, &mut Untouchable).map(|_| ())
    }));
    assert!(ended.is_err());
    let mut again = MemorySink::default();
    session.frame(Arc::clone(&plan), &mut again).unwrap();
    assert!(again.batches == whole.batches);
}
