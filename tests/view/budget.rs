//! Budgets: a coarse picture at once, closed in every frame, and all of the rest within twice the work.

use super::frames::{balanced, drawn, from_scratch, options, path};
use super::pixels::measured;
use super::{of_corpus, shape};
use crate::pools::{Engine, Shuffled};
use crate::random::SplitMix;
use std::sync::Arc;
use std::time::Duration;
use trimtess::control::{Alone, Jobs};
use trimtess::frame::{PlanLimits, PlannerOptions};
use trimtess::mesh::{Batch, MemorySink};
use trimtess::parallel::Session;
use trimtess::prepare::Prepared;
use trimtess::view::View;

/// A session whose frames may take so many microseconds of a worker.
fn within(prepared: &Arc<Prepared>, micros: u64) -> Session {
    let planner = PlannerOptions::DEFAULT.with_budget(Some(Duration::from_micros(micros)));
    Session::start(Arc::clone(prepared), &options(2).with_planner(planner)).unwrap()
}

fn a_view(prepared: &Prepared) -> View {
    path(&mut SplitMix(3), prepared.bounds.unwrap(), 1)[0]
}

#[test]
fn a_budget_defers_the_least_urgent_tiles_and_all_are_done_in_the_end() {
    let prepared = shape("brake-hub");
    let mut session = within(&prepared, 300);
    let mut at_once = Session::start(Arc::clone(&prepared), &options(2)).unwrap();
    let (mut sink, mut whole) = (MemorySink::default(), MemorySink::default());
    let views = path(&mut SplitMix(9), prepared.bounds.unwrap(), 30);
    let mut deferred = 0;
    for (k, view) in views.iter().enumerate() {
        let report = session.view(&[*view], &mut sink).unwrap();
        deferred += report.deferred;
        let batches = drawn(&sink);
        assert_eq!(batches, drawn(&from_scratch(&session)), "{k}");
        balanced(&prepared, &session.plan().unwrap(), &batches, &format!("{k}"));
    }
    assert!(deferred > 100, "{deferred}");
    let last = views[views.len() - 1];
    for _ in 0..1000 {
        if session.view(&[last], &mut sink).unwrap().deferred == 0 {
            break;
        }
    }
    // All tiles keep the tolerance then. Rates may be a step finer than without the budget, because of the path to
    // them.
    at_once.view(&[last], &mut whole).unwrap();
    let frame = MemorySink::of(sink.scene.clone(), drawn(&sink), Vec::new());
    let (share, _) = measured(&prepared, &last, 0.05 * prepared.scene.parts[0].radius, &frame);
    assert!(share <= 1.0, "{share}");
    let triangles = |sink: &MemorySink| drawn(sink).iter().map(|b| b.mesh.triangles.len()).sum::<usize>();
    assert!(triangles(&sink) < 2 * triangles(&whole), "{} {}", triangles(&sink), triangles(&whole));
}

#[test]
fn a_still_camera_reaches_the_picture_within_twice_the_work() {
    for (name, micros) in [("brake-hub", 100), ("brake-hub", 500), ("trimmed-teapot", 100), ("brake-assembly", 2000)] {
        reaches_the_picture(name, &shape(name), micros);
    }
    for (name, micros) in [("tri_zero_skirts.step", 4000), ("odrive_pcb_v35.step", 500)] {
        if let Some(prepared) = of_corpus(name) {
            reaches_the_picture(name, &prepared, micros);
        }
    }
}

fn reaches_the_picture(name: &str, prepared: &Arc<Prepared>, micros: u64) {
    let view = a_view(prepared);
    let (mut sink, mut whole, mut first) = <(MemorySink, MemorySink, MemorySink)>::default();
    let at_once = Session::start(Arc::clone(prepared), &options(2)).unwrap().view(&[view], &mut whole).unwrap();
    let coarse = within(prepared, 0).view(&[view], &mut first).unwrap();
    let mut session = within(prepared, micros);
    let (mut triangles, mut frames) = (0, 0);
    loop {
        let report = session.view(&[view], &mut sink).unwrap();
        balanced(prepared, &session.plan().unwrap(), &drawn(&sink), &format!("{name}, frame {frames}"));
        assert!(frames > 0 || report.whole && report.deferred > 0, "{name}: {report:?}");
        (triangles, frames) = (triangles + report.triangles, frames + 1);
        if report.deferred == 0 {
            break;
        }
        assert!(frames < 1000, "{name}: {} tiles still wait", report.deferred);
    }
    println!(
        "{name}: {triangles} triangles in {frames} frames; at once {}, at first {}",
        at_once.triangles, coarse.triangles
    );
    assert!(triangles <= 2 * at_once.triangles + coarse.triangles, "{name}: {triangles} for {}", at_once.triangles);
    let held: usize = drawn(&sink).iter().map(|batch| batch.mesh.triangles.len()).sum();
    assert_eq!(held as u64, at_once.triangles, "{name}");
}

/// Draws until no tile waits, and cancels or replaces some frames at random. Asserts that each commit is closed.
/// Returns what the last one draws.
fn settled(session: &mut Session, view: View, draw: &mut SplitMix, case: &str) -> Vec<Batch> {
    let mut sink = MemorySink::default();
    for _ in 0..1000 {
        while draw.unit() < 0.6 {
            session.begin(&[view]).unwrap();
            (0..draw.below(300)).for_each(|_| std::thread::yield_now());
            if draw.unit() < 0.7 {
                session.cancel();
            }
        }
        let report = session.view(&[view], &mut sink).unwrap();
        let batches = drawn(&sink);
        balanced(session.prepared(), &session.plan().unwrap(), &batches, case);
        if report.deferred == 0 {
            return batches;
        }
    }
    panic!("{case}: tiles still wait");
}

#[test]
fn pools_budgets_cancels_and_workers_do_not_change_the_picture() {
    let pools: [(&str, Arc<dyn Jobs>); 4] = [
        ("an engine's", Arc::new(Engine::of(2))),
        ("of one", Arc::new(Engine::of(1))),
        ("shuffled", Arc::new(Shuffled::default())),
        ("none", Arc::new(Alone)),
    ];
    let mut draw = SplitMix(21);
    for name in ["brake-hub", "trimmed-teapot"] {
        let prepared = shape(name);
        let view = a_view(&prepared);
        let mut at_once = MemorySink::default();
        Session::start(Arc::clone(&prepared), &options(1)).unwrap().view(&[view], &mut at_once).unwrap();
        let expected = drawn(&at_once);
        for (pool, jobs) in &pools {
            for (workers, micros) in [1, 2, 3, 8, 29].into_iter().flat_map(|w| [50, 1000].map(|m| (w, m))) {
                let planner = PlannerOptions::DEFAULT.with_budget(Some(Duration::from_micros(micros)));
                let options = options(workers).with_planner(planner);
                let mut session = Session::start_on(Arc::clone(jobs), Arc::clone(&prepared), &options);
                let case = format!("{name}, pool: {pool}, {workers} workers, {micros} us");
                assert!(settled(&mut session, view, &mut draw, &case) == expected, "{case}");
            }
        }
    }
}

#[test]
fn a_view_within_the_limits_does_not_suffer_from_one_before_that_was_not() {
    let prepared = shape("trimmed-teapot");
    let easy = a_view(&prepared);
    let hard = View { deviation_px: 0.02, ..easy };
    let mut alone = MemorySink::default();
    let wanted = Session::start(Arc::clone(&prepared), &options(2)).unwrap().view(&[easy], &mut alone).unwrap();
    for spare in [1.3, 2.0, 8.0] {
        let limits = PlanLimits::DEFAULT.with_triangles((spare * wanted.triangles as f64) as u64);
        let planner = PlannerOptions::DEFAULT.with_limits(limits);
        let mut session = Session::start(Arc::clone(&prepared), &options(2).with_planner(planner)).unwrap();
        let mut sink = MemorySink::default();
        session.view(&[hard], &mut sink).unwrap();
        assert!(session.shortfall().is_some_and(|short| short.density < 1.0), "{spare}");
        session.view(&[easy], &mut sink).unwrap();
        let held: usize = drawn(&sink).iter().map(|batch| batch.mesh.triangles.len()).sum();
        let share = held as f64 / wanted.triangles as f64;
        // Hysteresis keeps some tiles finer than alone.
        assert!((0.5..2.0).contains(&share), "{spare}: {share}");
        assert!(spare < 2.0 || session.shortfall().is_none(), "{spare}: {:?}", session.shortfall());
    }
}

#[test]
fn a_limit_holds_where_angles_or_outlines_decide() {
    for name in ["brake-rotor", "brake-hub", "flower-teapot", "washer"] {
        let prepared = shape(name);
        let view = View { deviation_px: 0.05, ..a_view(&prepared) };
        let mut all = MemorySink::default();
        let wanted = Session::start(Arc::clone(&prepared), &options(2)).unwrap().view(&[view], &mut all).unwrap();
        for share in [0.8, 0.4] {
            let most = (share * wanted.triangles as f64) as u64;
            let limits = PlanLimits::DEFAULT.with_triangles(most);
            let planner = PlannerOptions::DEFAULT.with_limits(limits);
            let mut session = Session::start(Arc::clone(&prepared), &options(2).with_planner(planner)).unwrap();
            let mut sink = MemorySink::default();
            let made = session.view(&[view], &mut sink).unwrap();
            let short = session.shortfall();
            assert!(made.triangles <= most, "{name} {share}: {} of {most}, {short:?}", made.triangles);
            assert!(short.is_some_and(|short| short.needed >= most), "{name} {share}: {short:?}");
            balanced(&prepared, &session.plan().unwrap(), &drawn(&sink), name);
        }
    }
}
