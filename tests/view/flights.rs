//! Cameras that move: no cracks, the tolerance, the same plans for the same views, and the limits.

use super::frames::{balanced, drawn, from_scratch, options, path};
use super::pixels::measured;
use super::shape;
use crate::random::SplitMix;
use glam::DVec3;
use std::sync::Arc;
use trimtess::frame::internals::{PlacedInstances, Planner};
use trimtess::frame::{Plan, PlanLimits, PlannerOptions};
use trimtess::mesh::{Batch, MemorySink};
use trimtess::parallel::Session;
use trimtess::prepare::Prepared;
use trimtess::view::{Camera, View};

/// Flies a path. Every frame is closed and equals its plan without history; one in `every` is measured. Returns the
/// largest deviation as a multiple of the tolerance, and how many tiles were rebuilt.
pub(crate) fn flown(name: &str, prepared: &Arc<Prepared>, views: &[View], every: usize) -> (f64, usize) {
    let mut session = Session::start(Arc::clone(prepared), &options(2)).unwrap();
    let mut sink = MemorySink::default();
    let (mut most, mut stretches, mut made) = (0.0_f64, 0, 0);
    for (f, view) in views.iter().enumerate() {
        let case = format!("{name}, frame {f}");
        let report = session.view(&[*view], &mut sink).unwrap();
        assert!(report.whole == (f == 0) && report.degraded.is_empty(), "{case}: {:?}", report.degraded);
        made += if f > 0 { report.tiles } else { 0 };
        let (batches, plan) = (drawn(&sink), session.plan().unwrap());
        let of_tile = |b: &Batch| plan.parts[b.part.index()].tiles[b.tile.0 as usize].chord;
        assert!(batches.iter().all(|b| of_tile(b).is_finite()), "{case}");
        assert!(batches == drawn(&from_scratch(&session)), "{case}");
        stretches += balanced(session.prepared(), &plan, &batches, &case);
        if f % every == every - 1 {
            let frame = MemorySink::of(sink.scene.clone(), batches, Vec::new());
            let near = 0.05 * prepared.scene.parts.iter().map(|part| part.radius).fold(0.0, f64::max);
            let (share, _) = measured(session.prepared(), view, near, &frame);
            assert!(share <= 1.0, "{case}: {share} times the tolerance");
            most = most.max(share);
        }
    }
    assert!(stretches > 1000, "{name}: {stretches}");
    (most, made)
}

#[test]
fn frames_are_closed_and_keep_the_tolerance() {
    let (mut made, mut all, mut most) = (0, 0, 0.0_f64);
    for name in ["torus", "washer", "sphere", "brake-hub", "trimmed-teapot"] {
        let prepared = shape(name);
        let views = path(&mut SplitMix(7), prepared.bounds.unwrap(), 60);
        let (share, tiles) = flown(name, &prepared, &views, 5);
        assert!(share > 0.1, "{name}: {share}");
        (most, made) = (most.max(share), made + tiles);
        all += (views.len() - 1) * prepared.tiles().count();
    }
    println!("at most {most} of the tolerance, {made} tiles rebuilt");
    assert!(3 * made < all, "{made} of {all} tiles");
}

/// Plans along a path.
fn plans(prepared: &Arc<Prepared>, views: &[View]) -> Vec<Arc<Plan>> {
    let mut planner = Planner::new(Arc::clone(prepared), &PlannerOptions::DEFAULT);
    let mut placed = PlacedInstances::of(prepared);
    let plan = |view: &View| Arc::clone(planner.plan(&mut placed, &[*view]));
    views.iter().map(plan).collect()
}

#[test]
fn the_same_views_give_the_same_plans() {
    let prepared = shape("brake-hub");
    let views = path(&mut SplitMix(12), prepared.bounds.unwrap(), 80);
    assert!(plans(&prepared, &views) == plans(&prepared, &views));
}

#[test]
fn limits_make_frames_coarser_and_say_so_until_there_is_room_again() {
    let prepared = shape("teapot");
    let limits = PlanLimits::DEFAULT.with_triangles(4000);
    let [low, high] = prepared.bounds.unwrap();
    let (middle, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
    let mut planner = Planner::new(Arc::clone(&prepared), &PlannerOptions::DEFAULT.with_limits(limits));
    let mut placed = PlacedInstances::of(&prepared);
    let mut coarser = 0;
    // To the model, and away from it.
    for k in 0..120 {
        let away = 2.0 + 40.0 * (f64::from(k) / 60.0 - 1.0).abs();
        let eye = middle - DVec3::Y * away * radius;
        let view = path(&mut SplitMix(1), [low, high], 1)[0];
        let view = View { camera: Camera { eye, forward: DVec3::Y, ..view.camera }, ..view };
        let plan = planner.plan(&mut placed, &[view]);
        let cells = plan.parts[0].tiles.iter().map(|tile| tile.cells().0 * tile.cells().1).sum::<u32>();
        assert!(cells <= 2000, "{k}: {cells}");
        let by_limits = plan.shortfall.as_ref().is_some_and(|s| s.density < 1.0 && s.by_limits());
        coarser += usize::from(by_limits);
        assert!(!by_limits || (10..110).contains(&k), "{k}: {:?}", plan.shortfall);
        if k % 10 == 9 {
            let settles = (0..200).any(|_| {
                let plan = Arc::clone(planner.last());
                Arc::ptr_eq(&plan, planner.plan(&mut placed, &[view]))
            });
            assert!(settles, "{k}");
        }
    }
    assert!(coarser > 5, "{coarser}");
}
