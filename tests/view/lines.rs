//! Lattice lines that stay when rates change: no cracks, the tolerance or the stated multiple of it, and eventually the
//! plan without history.

use super::frames::{balanced, drawn, from_scratch, options, path};
use super::pixels::measured;
use super::shape;
use crate::random::SplitMix;
use glam::DVec3;
use std::num::NonZeroU32;
use std::sync::Arc;
use trimtess::frame::internals::{PlacedInstances, Planner};
use trimtess::frame::{LinePlacement, Plan, PlanLimits, PlannerOptions, SplitRule};
use trimtess::mesh::{Batch, MemorySink};
use trimtess::model::TileId;
use trimtess::parallel::Session;
use trimtess::prepare::Prepared;
use trimtess::view::{Camera, View};

pub(crate) const CRITERION: LinePlacement =
    LinePlacement::Split { intensive: SplitRule::Criterion, most: 2.0, resync: None };
pub(crate) const RENDERING: LinePlacement =
    LinePlacement::Split { intensive: SplitRule::LongestFirst, most: 2.0, resync: None };

fn with_turns(intensive: SplitRule, frames: u32) -> LinePlacement {
    LinePlacement::Split { intensive, most: 2.0, resync: NonZeroU32::new(frames) }
}

fn planner(lines: LinePlacement) -> PlannerOptions {
    PlannerOptions::DEFAULT.with_lines(lines)
}

/// Flies a path. Every frame is closed and equals its plan without history; one in `every` is measured. Returns the
/// largest deviation as a multiple of the tolerance, and how many tiles were rebuilt.
pub(crate) fn flown(
    name: &str,
    prepared: &Arc<Prepared>,
    lines: LinePlacement,
    views: &[View],
    every: usize,
) -> (f64, usize) {
    let mut session = Session::start(Arc::clone(prepared), &options(2).with_planner(planner(lines))).unwrap();
    let mut sink = MemorySink::default();
    let (mut most, mut stretches, mut made) = (0.0_f64, 0, 0);
    for (f, view) in views.iter().enumerate() {
        let case = format!("{name}, {lines:?}, frame {f}");
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
            let allowed = if matches!(lines, LinePlacement::Split { intensive: SplitRule::LongestFirst, .. }) {
                4.0
            } else {
                1.0
            };
            assert!(share <= allowed, "{case}: {share} times the tolerance");
            most = most.max(share);
        }
    }
    assert!(stretches > 1000, "{name}: {stretches}");
    (most, made)
}

#[test]
fn frames_are_closed_and_keep_the_tolerance_or_four_times_it() {
    let (mut made, mut all, mut most) = ([0; 6], 0, [0.0_f64; 6]);
    for name in ["torus", "washer", "sphere", "brake-hub", "trimmed-teapot"] {
        let prepared = shape(name);
        let views = path(&mut SplitMix(7), prepared.bounds.unwrap(), 60);
        let ways = [
            LinePlacement::Spread,
            CRITERION,
            RENDERING,
            with_turns(SplitRule::Criterion, 20),
            with_turns(SplitRule::LongestFirst, 20),
            LinePlacement::Split { intensive: SplitRule::Criterion, most: 1.25, resync: None },
        ];
        for (k, lines) in ways.into_iter().enumerate() {
            let (share, tiles) = flown(name, &prepared, lines, &views, 5);
            assert!(share > 0.1, "{name}, {lines:?}: {share}");
            (most[k], made[k]) = (most[k].max(share), made[k] + tiles);
        }
        all += (views.len() - 1) * prepared.tiles().count();
    }
    println!("at most {most:?} of the tolerance, {made:?} tiles rebuilt");
    // `LongestFirst` deviates more than `Criterion`; splitting rebuilds fewer tiles than `Spread`.
    assert!(most[2] > most[1] && most[4] > most[1], "{most:?}");
    assert!(made[1] < made[0] && made[2] < made[0] && made[5] < made[0], "{made:?}");
    assert!(3 * made[0] < all, "{made:?} of {all} tiles");
}

/// Plans along a path.
fn plans(prepared: &Arc<Prepared>, options: &PlannerOptions, views: &[View]) -> Vec<Arc<Plan>> {
    let mut planner = Planner::new(Arc::clone(prepared), options);
    let mut placed = PlacedInstances::of(prepared);
    let plan = |view: &View| Arc::clone(planner.plan(&mut placed, &[*view]));
    views.iter().map(plan).collect()
}

#[test]
fn the_same_views_give_the_same_plans() {
    let prepared = shape("brake-hub");
    let views = path(&mut SplitMix(12), prepared.bounds.unwrap(), 80);
    for lines in [CRITERION, with_turns(SplitRule::LongestFirst, 7)] {
        let again = plans(&prepared, &planner(lines), &views);
        assert!(plans(&prepared, &planner(lines), &views) == again);
        assert!(plans(&prepared, &PlannerOptions::DEFAULT, &views) != again);
    }
}

#[test]
fn lines_do_not_pile_up() {
    for name in ["trimmed-teapot", "brake-hub"] {
        let prepared = shape(name);
        let views = path(&mut SplitMix(21), prepared.bounds.unwrap(), 250);
        let spread = plans(&prepared, &PlannerOptions::DEFAULT, &views);
        for lines in [CRITERION, RENDERING] {
            let mut more = 0;
            for (f, (plan, even)) in plans(&prepared, &planner(lines), &views).iter().zip(&spread).enumerate() {
                for (t, (tile, even)) in plan.parts[0].tiles.iter().zip(&even.parts[0].tiles).enumerate() {
                    for (lines, even) in [(&tile.us, &even.us), (&tile.vs, &even.vs)] {
                        assert!(lines.is_sorted_by(|a, b| a < b) && lines.len() < 2 * even.len(), "{name} {f} {t}");
                        more += usize::from(lines.len() > even.len());
                    }
                }
            }
            assert!(more > 100, "{name} {lines:?}: {more}");
        }
    }
}

/// Number of drawn tiles, and of edges along them, with other lines than in another plan.
fn others(prepared: &Prepared, plan: &Plan, even: &Plan) -> usize {
    let mut others = 0;
    for (p, part) in prepared.parts.iter().enumerate() {
        let (plan_of, even) = (&plan.parts[p], &even.parts[p]);
        for (t, tile) in part.tiles.iter().enumerate().filter(|(t, _)| plan.drawn.contains(0, p, TileId(*t as u32))) {
            let is_other = plan_of.tiles[t].us != even.tiles[t].us || plan_of.tiles[t].vs != even.tiles[t].vs;
            let edges = tile.loops.iter().flatten().map(|u| u.edge.index());
            others += usize::from(is_other) + edges.filter(|&e| plan_of.edges[e] != even.edges[e]).count();
        }
    }
    others
}

#[test]
fn tiles_take_turns_until_lines_equal_newly_placed_ones() {
    const TURN: u32 = 12;
    for name in ["trimmed-teapot", "brake-hub"] {
        let prepared = shape(name);
        let views = path(&mut SplitMix(17), prepared.bounds.unwrap(), 60);
        let even = plans(&prepared, &PlannerOptions::DEFAULT, &views);
        let near = 0.05 * prepared.scene.parts[0].radius;
        for intensive in [SplitRule::Criterion, SplitRule::LongestFirst] {
            let lines = planner(with_turns(intensive, TURN));
            // Stops at the frame where most lines differ.
            let split = plans(&prepared, &lines, &views);
            let others_at = |f: &usize| others(&prepared, &split[*f], &even[*f]);
            let end = (20..views.len()).max_by_key(others_at).unwrap();
            let (views, even) = (&views[..=end], &even[end]);
            let mut session = Session::start(Arc::clone(&prepared), &options(2).with_planner(lines)).unwrap();
            let mut sink = MemorySink::default();
            for view in views {
                session.view(&[*view], &mut sink).unwrap();
            }
            let was_other = others(&prepared, &session.plan().unwrap(), even);
            assert!(was_other > 10, "{name} {intensive:?}: {was_other}");
            let last = views[views.len() - 1];
            let mut made = Vec::new();
            for _ in 0..2 * TURN {
                made.push(session.view(&[last], &mut sink).unwrap().tiles);
                let batches = drawn(&sink);
                assert!(batches == drawn(&from_scratch(&session)), "{name} {intensive:?}");
                balanced(&prepared, &session.plan().unwrap(), &batches, name);
            }
            assert_eq!(others(&prepared, &session.plan().unwrap(), even), 0, "{name} {intensive:?}");
            let frame = MemorySink::of(sink.scene.clone(), drawn(&sink), Vec::new());
            let (share, _) = measured(&prepared, &last, near, &frame);
            assert!(share <= 1.0, "{name} {intensive:?}: {share} times the tolerance");
            // Not all tiles in one frame, and none in the end.
            let (all, most) = (made.iter().sum::<usize>(), made.iter().max().unwrap());
            assert!(all > 0 && 2 * most <= all, "{name} {intensive:?}: {made:?}");
            let plan = session.plan().unwrap();
            assert_eq!(session.view(&[last], &mut sink).unwrap().tiles, 0);
            assert!(Arc::ptr_eq(&plan, &session.plan().unwrap()), "{name} {intensive:?}");
        }
    }
}

#[test]
fn limits_make_frames_coarser_and_say_so_until_there_is_room_again() {
    let prepared = shape("teapot");
    let limits = PlanLimits::DEFAULT.with_triangles(4000);
    let [low, high] = prepared.bounds.unwrap();
    let (middle, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
    for options in [PlannerOptions::DEFAULT, planner(CRITERION), planner(RENDERING)] {
        let mut planner = Planner::new(Arc::clone(&prepared), &options.with_limits(limits));
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
            assert!(cells <= 2000, "{options:?} {k}: {cells}");
            let by_limits = plan.shortfall.as_ref().is_some_and(|s| s.density < 1.0 && s.by_limits());
            coarser += usize::from(by_limits);
            assert!(!by_limits || (10..110).contains(&k), "{options:?} {k}: {:?}", plan.shortfall);
            if k % 10 == 9 {
                let settles = (0..200).any(|_| {
                    let plan = Arc::clone(planner.last());
                    Arc::ptr_eq(&plan, planner.plan(&mut placed, &[view]))
                });
                assert!(settles, "{options:?} {k}");
            }
        }
        assert!(coarser > 5, "{options:?}: {coarser}");
    }
}
