//! Plans of flights, also of those that are taken back.

use super::*;
use crate::control::{Threads, cancelled_at, so_far};
use crate::frame::live::draft::GroupBand;
use crate::frame::plan::limits::PlanLimits;
use crate::frame::plan::make::completed;
use crate::model::{ModelBuilder, shapes};
use crate::prepare::{PrepareOptions, prepare};
use crate::sequence::random::SplitMix;
use crate::view::{Camera, CameraPath, Picture};
use glam::{DAffine3, DVec3};
use std::time::Duration;

/// Shapes, each placed along a row that leads away from the origin.
fn rows() -> Arc<Prepared> {
    let mut model = ModelBuilder::new("rows");
    for (row, name) in (0..).zip(["box", "torus", "washer", "flower", "wave", "sphere"]) {
        let part = model.part(shapes::by_name(name).expect("a shape").parts.swap_remove(0));
        for place in 0..5 {
            let place = DVec3::new(60.0 * f64::from(row), 90.0 * f64::from(place), 0.0);
            model.place(part, DAffine3::from_translation(place));
        }
    }
    Arc::new(prepare(model.finish().expect("a model"), &PrepareOptions::DEFAULT).expect("within the limits"))
}

/// The groups that are looked at in a flight of views, and all that are seen. Each plan is compared with one in
/// which no group is judged.
fn compare(prepared: &Arc<Prepared>, options: &PlannerOptions, flight: &[Vec<View>]) -> [u32; 2] {
    let new = || Planner::new(Arc::clone(prepared), options);
    let (mut grouped, mut single) = (new(), new());
    let mut placed = PlacedInstances::of(prepared);
    let mut looked = [0; 2];
    for (k, views) in flight.iter().enumerate() {
        if k % 9 == 0 {
            let row = k % placed.instances().len();
            let lifted = DAffine3::from_translation(DVec3::Z) * placed.instances()[row].transform;
            placed.move_to(row, lifted);
        }
        grouped.plan(&mut placed, views);
        for part in &mut own(&mut single.rates).parts {
            part.groups.fill(GroupBand::NONE);
        }
        single.plan(&mut placed, views);
        assert_eq!(grouped.changes(), single.changes(), "frame {k}");
        assert!(grouped.last() == single.last(), "frame {k}");
        for (looked, planner) in looked.iter_mut().zip([&grouped, &single]) {
            let ranges = planner.rates.parts.iter().flat_map(|part| &part.seen.0);
            *looked += ranges.map(|range| range.open.count_ones()).sum::<u32>();
        }
    }
    looked
}

#[test]
fn groups_decide_as_their_tiles_do() {
    const PICTURE: Picture = Picture { size: (800, 600), deviation_px: 0.5, size_px: None, angle: 0.5 };
    let prepared = rows();
    let around = CameraPath::Orbit.views(prepared.bounds.expect("a placed model"), 400, &PICTURE);
    let along = (0..200).map(|k| {
        let eye = DVec3::new(150.0, 2.5 * f64::from(k) - 100.0, 40.0);
        let camera = Camera { eye, ..around[0].camera };
        View { camera: Camera { forward: DVec3::new(0.3, 1.0, -0.1).normalize(), ..camera }, ..around[0] }
    });
    // Every other frame has a second view, in which another part of the scene is large.
    let second = |k: usize| around[(7 * k + 100) % around.len()];
    let views = around.iter().copied().chain(along).enumerate();
    let flight: Vec<Vec<View>> = views.map(|(k, view)| [view, second(k)][..1 + k % 2].to_vec()).collect();
    let [open, all] = compare(&prepared, &PlannerOptions::DEFAULT, &flight);
    assert!(all > 1000 && 2 * open < all, "{open} of {all} groups were looked at");

    // Changes that wait, terms that limits make coarser, and tiles that the camera's side decides on.
    let options = PlannerOptions::DEFAULT;
    compare(&prepared, &options.with_budget(Some(Duration::from_micros(20))), &flight[..200]);
    compare(&prepared, &options.with_limits(PlanLimits::DEFAULT.with_triangles(2000)), &flight[..200]);
    compare(&prepared, &options.with_cull_back_faces(true), &flight[..200]);
}

#[test]
fn parts_are_planned_once_a_view_shows_them() {
    const PICTURE: Picture = Picture { size: (800, 600), deviation_px: 0.5, size_px: None, angle: 0.5 };
    let prepared = rows();
    let all = CameraPath::Orbit.views(prepared.bounds.expect("a placed model"), 1, &PICTURE)[0];
    // Along the first row of parts, away from the others.
    let camera =
        Camera { eye: DVec3::new(0.0, -40.0, 0.0), forward: DVec3::new(-0.3, 1.0, 0.0).normalize(), ..all.camera };
    let few = View { camera, ..all };
    let mut placed = PlacedInstances::of(&prepared);
    let mut planner = Planner::new(Arc::clone(&prepared), &PlannerOptions::DEFAULT);
    let mut known = Vec::new();
    for (view, are_all) in [(few, false), (few, false), (all, true), (few, true)] {
        planner.plan(&mut placed, &[view]);
        let new = &planner.changes().parts;
        assert!(new.iter().all(|part| !known.contains(part)), "{new:?}, {known:?}");
        known.extend(new);
        let plan = Arc::clone(planner.last());
        for (row, (plan, part)) in plan.parts.iter().zip(&*prepared.parts).enumerate() {
            assert!(plan.is_of(part) || plan.tiles.is_empty() && plan.edges.is_empty());
            assert_eq!(plan.is_of(part), known.contains(&PartId::new(row)), "part {row}");
        }
        assert!(!known.is_empty() && (known.len() == prepared.parts.len()) == are_all, "{known:?}");
        let whole = completed(&Alone, &plan, &prepared, &PlanLimits::DEFAULT);
        assert!(whole.parts.iter().zip(&*prepared.parts).all(|(plan, part)| plan.is_of(part)));
        assert!(known.iter().all(|part| whole.parts[part.index()] == plan.parts[part.index()]));
        assert_eq!(Arc::ptr_eq(&whole, &plan), are_all);
    }
}

/// Flies with two planners, of which one also makes plans that are taken back: cancelled at some look, or made to their
/// end. Both must make the same plans. Returns how many were cancelled.
fn waste(jobs: &dyn Jobs, options: &PlannerOptions, flight: &[View]) -> usize {
    let prepared = rows();
    let new = || (Planner::new(Arc::clone(&prepared), options), PlacedInstances::of(&prepared));
    let ((mut plain, mut placed), (mut wasting, mut again)) = (new(), new());
    let (mut draw, mut cancelled) = (SplitMix(11), 0);
    let tiles = prepared.tiles().count() as u64;
    for (k, view) in flight.iter().enumerate() {
        for _ in 0..draw.below(4) {
            let other = [flight[draw.below(flight.len() as u64) as usize]];
            let mut plan = |control: &Control| {
                let shown = again.shown_by(&other, options.cull_back_faces);
                wasting.plan_on(Call::new(jobs, control), &again, (&other, shown)).is_some()
            };
            let look = draw.below(3 * tiles);
            let control = cancelled_at(look);
            if plan(&control) {
                wasting.revert(jobs);
            } else {
                cancelled += 1;
                // A call of a loop looks once.
                assert!(so_far(&control) - look < 40, "{} looks after {look}", so_far(&control) - look);
            }
        }
        plain.plan(&mut placed, &[*view]);
        wasting.plan(&mut again, &[*view]);
        assert_eq!(wasting.changes(), plain.changes(), "frame {k}");
        assert!(wasting.last() == plain.last(), "frame {k}");
        let counts = |planner: &Planner| (planner.rates.triangles_drawn(), planner.growth, planner.rates.terms);
        assert_eq!(counts(&wasting), counts(&plain), "frame {k}");
    }
    cancelled
}

#[test]
fn plans_that_are_taken_back_leave_no_trace() {
    const PICTURE: Picture = Picture { size: (800, 600), deviation_px: 0.5, size_px: None, angle: 0.5 };
    let flight = CameraPath::Zoom.views(rows().bounds.expect("a placed model"), 60, &PICTURE);
    let options = PlannerOptions::DEFAULT;
    let threads = Threads::start(3).expect("threads");
    for (what, options) in [
        ("default", options),
        ("budget", options.with_budget(Some(Duration::from_micros(20)))),
        ("limits", options.with_limits(PlanLimits::DEFAULT.with_triangles(2000))),
        ("culling", options.with_cull_back_faces(true)),
    ] {
        for jobs in [&Alone as &dyn Jobs, &threads] {
            let cancelled = waste(jobs, &options, &flight);
            assert!(cancelled > 20, "{what}: {cancelled}");
        }
    }
}

#[test]
fn a_plan_looks_for_a_cancel_before_each_tile_and_edge() {
    const PICTURE: Picture = Picture { size: (800, 600), deviation_px: 0.5, size_px: None, angle: 0.5 };
    let prepared = rows();
    let view = CameraPath::Orbit.views(prepared.bounds.expect("a placed model"), 1, &PICTURE);
    let (mut planner, mut placed) =
        (Planner::new(Arc::clone(&prepared), &PlannerOptions::DEFAULT), PlacedInstances::of(&prepared));
    let control = Control::default();
    let shown = placed.shown_by(&view, false);
    assert!(planner.plan_on(Call::new(&Alone, &control), &placed, (&view, shown)).is_some());
    let (lattices, edges) = (planner.pages.new.lattices.len(), planner.changes().edges.len());
    assert!(lattices > 10, "{lattices}");
    assert!(so_far(&control) >= (lattices + edges) as u64);
}
