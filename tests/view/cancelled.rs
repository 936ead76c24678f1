//! Frames that nobody commits leave no trace: a session goes on as one that never got them.

use super::frames::{options, path};
use super::shape;
use crate::pools::{Engine, Shuffled};
use crate::random::SplitMix;
use glam::{DAffine3, DVec3};
use std::sync::Arc;
use std::thread;
use std::time::Duration;
use trimtess::control::{Alone, Jobs, Threads};
use trimtess::frame::{PlanLimits, PlannerOptions};
use trimtess::mesh::MemorySink;
use trimtess::model::PartId;
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::Prepared;
use trimtess::view::View;

/// Copies of a part in a row along x, as parts of their own, in so many instances each.
fn row_of(name: &str, parts: usize, instances: usize) -> Arc<Prepared> {
    let mut many = Prepared::clone(&shape(name));
    let [low, high] = many.bounds.unwrap();
    let step = 1.2 * (high - low);
    let (part, of_scene) = (many.parts[0].clone(), many.scene.parts[0].clone());
    let one = many.scene.instances[0].clone();
    many.parts = Arc::new(vec![part; parts]);
    many.scene.parts = vec![of_scene; parts];
    many.scene.instances.clear();
    for row in 0..parts * instances {
        let (k, along) = (row % parts, (row / parts) as f64);
        let place = DVec3::new(step.x * k as f64, 4.0 * step.y * along, 0.0);
        let transform = DAffine3::from_translation(place) * one.transform;
        many.scene.instances.push(trimtess::mesh::SceneInstance { part: PartId::new(k), transform, ..one.clone() });
    }
    let last = many.scene.instances[parts * instances - 1].transform.translation;
    many.bounds = Some([low, high + last.max(DVec3::ZERO)]);
    Arc::new(many)
}

/// Begins a frame, and has it come to nothing.
fn waste(session: &mut Session, view: View, draw: &mut SplitMix) {
    session.begin(&[view]).unwrap();
    let late = draw.below(3);
    if late == 0 {
        thread::sleep(Duration::from_micros(draw.below(3000)));
    } else if late == 1 {
        // Not for ever: a pool may keep the job until someone waits for it.
        (0..50).take_while(|_| !session.is_made()).for_each(|_| thread::sleep(Duration::from_micros(200)));
    }
    match draw.below(3) {
        0 => session.cancel(),
        1 => {
            // Waits for the frame first.
            session.memory().unwrap();
            session.cancel();
        }
        // The next frame begins instead.
        _ => {}
    }
}

/// Flies with two sessions, of which one also gets frames that are wasted. Both must show the same.
fn compare(case: &str, jobs: &Arc<dyn Jobs>, prepared: &Arc<Prepared>, options: &SessionOptions, views: &[View]) {
    let start = || Session::start_on(Arc::clone(jobs), Arc::clone(prepared), options);
    let (mut plain, mut wasting) = (start(), start());
    let (mut expected, mut sink, mut draw) = (MemorySink::default(), MemorySink::default(), SplitMix(5));
    for (k, view) in views.iter().enumerate() {
        let case = format!("{case}, frame {k}");
        for _ in 0..draw.below(3) {
            waste(&mut wasting, views[draw.below(views.len() as u64) as usize], &mut draw);
        }
        let wanted = plain.view(&[*view], &mut expected).unwrap();
        let report = wasting.view(&[*view], &mut sink).unwrap();
        let facts = |report: &trimtess::parallel::FrameReport| {
            (report.frame, report.whole, report.tiles, report.evicted, report.deferred, report.triangles)
        };
        assert_eq!(facts(&report), facts(&wanted), "{case}");
        assert!(sink == expected, "{case}");
        assert!(wasting.plan() == plain.plan() && wasting.shortfall() == plain.shortfall(), "{case}");
    }
}

#[test]
fn frames_that_nobody_commits_leave_no_trace() {
    let pools: [(&str, Arc<dyn Jobs>); 4] = [
        ("threads", Arc::new(Threads::start(2).unwrap())),
        ("an engine's", Arc::new(Engine::of(2))),
        ("shuffled", Arc::new(Shuffled::default())),
        ("none", Arc::new(Alone)),
    ];
    let default = PlannerOptions::DEFAULT;
    let planners = [
        ("default", default),
        ("budget", default.with_budget(Some(Duration::from_micros(300)))),
        ("limits", default.with_limits(PlanLimits::DEFAULT.with_triangles(3000))),
        ("culling", default.with_cull_back_faces(true)),
    ];
    // The row long enough for tiles to be evicted.
    let models = [("row", row_of("washer", 5, 6), 70), ("hub", shape("brake-hub"), 12)];
    for (name, prepared, frames) in &models {
        let views = path(&mut SplitMix(3), prepared.bounds.unwrap(), *frames);
        for (k, (what, planner)) in planners.into_iter().enumerate() {
            let (pool, jobs) = &pools[k];
            let options = options(3).with_planner(planner).with_edge_lines(true).with_levels(3);
            compare(&format!("{name}, {what}, pool: {pool}"), jobs, prepared, &options, &views);
        }
    }
}

#[test]
fn a_large_first_frame_that_is_dropped_leaves_no_trace() {
    let prepared = row_of("flower-teapot", 3200, 1);
    let tiles = prepared.tiles().count();
    assert!(tiles >= 100_000, "{tiles}");
    let all = path(&mut SplitMix(3), prepared.bounds.unwrap(), 1)[0];
    // A camera near the first parts, which turns.
    let [low, high] = shape("flower-teapot").bounds.unwrap();
    let few = path(&mut SplitMix(8), [low, high], 3);
    let jobs: Arc<dyn Jobs> = Arc::new(Threads::start(2).unwrap());
    let start = || Session::start_on(Arc::clone(&jobs), Arc::clone(&prepared), &SessionOptions::DEFAULT);
    let frames = |session: &mut Session| {
        let mut sink = MemorySink::default();
        few.iter().for_each(|view| _ = session.view(&[*view], &mut sink).unwrap());
        assert!(sink.drawn.instances(0).count() < 100, "few are in the picture");
        (sink.batches, sink.edge_lines, sink.drawn)
    };
    let expected = frames(&mut start());
    let mut draw = SplitMix(9);
    for how in 0..9 {
        let mut session = start();
        for _ in 0..2 {
            session.begin(&[all]).unwrap();
            thread::sleep(Duration::from_micros(draw.below(200_000)));
            match how % 3 {
                0 => session.cancel(),
                1 => session.forget(),
                _ => {}
            }
        }
        assert!(how % 3 == 2 || frames(&mut session) == expected, "{how}");
        // In the last case, the session is dropped instead.
    }
}
