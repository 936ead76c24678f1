//! Frames of a moving camera: after each, the sink holds what the plan says, without cracks and within the screen-space
//! error.

use super::pixels::measured;
use super::{prepared, shape, two_sizes};
use crate::random::SplitMix;
use glam::{DAffine3, DVec3};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use trimtess::frame::internals::{PlacedInstances, Planner, edge_line};
use trimtess::frame::{Plan, PlannerOptions};
use trimtess::mesh::{Batch, DrawnTiles, MemorySink, MeshSink, Scene, SceneChanges, SceneInstance, SinkError};
use trimtess::model::{EdgeId, ModelBuilder, PartId, TileId};
use trimtess::parallel::{EditError, FrameError, Session, SessionOptions};
use trimtess::prepare::Prepared;
use trimtess::view::{Camera, Projection, View};

/// Cameras along a path: around the middle, closer and further away, looking aside, with occasional jumps.
pub(crate) fn path(draw: &mut SplitMix, [low, high]: [DVec3; 2], frames: usize) -> Vec<View> {
    let (middle, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
    let mut place = [0.0, 0.3, 2.5, 0.0];
    let mut speed = [0.02, 0.0, 0.0, 0.0];
    let view = |_| {
        if draw.unit() < 0.1 {
            speed = [draw.range(-0.1, 0.1), draw.range(-0.05, 0.05), draw.range(-0.15, 0.15), draw.range(-0.1, 0.1)];
        }
        if draw.unit() < 0.03 {
            place[2] = draw.range(0.3, 6.0);
        }
        (0..4).for_each(|k| place[k] += speed[k]);
        place[2] = place[2].clamp(0.4, 8.0);
        let [round, up, away, aside] = place;
        let from = DVec3::new(f64::cos(round) * f64::cos(up), f64::sin(round) * f64::cos(up), f64::sin(up));
        let eye = middle + from * radius * away;
        let target = middle + DVec3::Z.cross(from) * radius * f64::sin(aside);
        let near = 0.02 * radius;
        View {
            camera: Camera {
                eye,
                forward: target - eye,
                up: DVec3::Z,
                projection: Projection::Perspective { fov_y: 0.7, near },
            },
            size: (960, 540),
            deviation_px: 0.5,
            size_px: None,
            angle: 1.5,
        }
    };
    (0..frames).map(view).collect()
}

/// The plan's triangles of all drawn tiles, made without history.
pub(crate) fn from_scratch(session: &Session) -> MemorySink {
    let plan = session.plan().unwrap();
    let mut sink = crate::common::frame(session.prepared(), &plan, false).0;
    sink.drawn = plan.drawn.clone();
    sink.scene = session.scene().clone();
    sink
}

/// Batches drawn in some view, ordered by part and tile.
pub(crate) fn drawn(sink: &MemorySink) -> Vec<Batch> {
    let shows = |batch: &&Batch| {
        let instances = sink.scene.instances.iter().enumerate().filter(|(_, i)| i.part == batch.part);
        let mut pairs = instances.flat_map(|(i, _)| (0..sink.drawn.views()).map(move |view| (view, i)));
        pairs.any(|(view, i)| sink.drawn.contains(view, i, batch.tile))
    };
    sink.batches.iter().filter(shows).cloned().map(|batch| Batch { worker: 0, ..batch }).collect()
}

/// Asserts that the drawn tiles are closed: their triangles use each segment as often in one direction as in the other.
/// Edges of a tile that is not drawn may be open. Returns the number of segments between tessellants that are closed.
pub(crate) fn balanced(prepared: &Prepared, plan: &Plan, batches: &[Batch], case: &str) -> usize {
    balanced_as(prepared, plan, batches, |_, point| point, case)
}

/// The same, where vertices are rounded: `rounded` does that to a point of a part.
pub(crate) fn balanced_as(
    prepared: &Prepared,
    plan: &Plan,
    batches: &[Batch],
    rounded: impl Fn(usize, DVec3) -> DVec3,
    case: &str,
) -> usize {
    let mut stretches = 0;
    for (p, part) in prepared.parts.iter().enumerate() {
        let mut there = vec![false; part.tiles.len()];
        let mut uses: HashMap<[[u64; 3]; 2], i32> = HashMap::new();
        for batch in batches.iter().filter(|b| b.part.index() == p) {
            there[batch.tile.0 as usize] = true;
            for &[a, b, c] in &batch.mesh.triangles {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    let ends = [from, to].map(|v| bits(batch.mesh.positions[v as usize]));
                    let row = uses.entry([ends[0].min(ends[1]), ends[0].max(ends[1])]).or_default();
                    *row += if ends[0] < ends[1] { 1 } else { -1 };
                }
            }
        }
        let stretch = |ends: &[DVec3]| {
            let ends = [bits(rounded(p, ends[0])), bits(rounded(p, ends[1]))];
            [ends[0].min(ends[1]), ends[0].max(ends[1])]
        };
        let line = |e: usize| edge_line(prepared, plan, PartId::new(p), EdgeId::new(e)).points;
        let is_all_there = |e: &usize| {
            let uses = &part.edges[*e].uses;
            uses.len() >= 2 && uses.iter().all(|place| there[place.tile.index()])
        };
        let (whole, cut): (Vec<usize>, Vec<usize>) = (0..part.edges.len()).partition(is_all_there);
        // Coarse edges with the same ends may be the same chord, which is used by the sides of both.
        let cut: HashSet<_> =
            cut.into_iter().flat_map(|e| line(e).windows(2).map(stretch).collect::<Vec<_>>()).collect();
        for (ends, sum) in uses.iter().filter(|(ends, _)| ends[0] != ends[1]) {
            let points = ends.map(|end| end.map(f64::from_bits));
            assert!(*sum == 0 || cut.contains(ends), "{case}: {sum} of part {p}: {points:?}");
        }
        for e in whole {
            stretches += line(e).windows(2).filter(|ends| uses.contains_key(&stretch(ends))).count();
        }
    }
    stretches
}

fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

pub(crate) fn options(workers: usize) -> SessionOptions {
    SessionOptions::DEFAULT.with_workers(workers).with_edge_lines(false)
}

#[test]
fn the_number_of_workers_does_not_matter() {
    let prepared = shape("brake-hub");
    let views = path(&mut SplitMix(3), prepared.bounds.unwrap(), 25);
    let frames = |workers: usize, cull: bool| {
        let planner = PlannerOptions::DEFAULT.with_cull_back_faces(cull);
        let options = SessionOptions::DEFAULT.with_workers(workers).with_planner(planner);
        let mut session = Session::start(Arc::clone(&prepared), &options).unwrap();
        let mut sink = MemorySink::default();
        let mut frames = Vec::new();
        for view in &views {
            session.view(&[*view], &mut sink).unwrap();
            let batches: Vec<Batch> = sink.batches.iter().cloned().map(|b| Batch { worker: 0, ..b }).collect();
            frames.push((batches, sink.edge_lines.clone(), sink.drawn.clone()));
        }
        frames
    };
    let one = [false, true].map(|cull| frames(1, cull));
    assert!(one[0] != one[1]);
    for workers in [2, 3, 8, 29] {
        for cull in [false, true] {
            assert!(frames(workers, cull) == one[usize::from(cull)], "{workers} workers, culled: {cull}");
        }
    }
}

#[test]
fn cancelled_frames_cost_nothing_but_time() {
    let prepared = shape("trimmed-teapot");
    let views = path(&mut SplitMix(5), prepared.bounds.unwrap(), 40);
    let mut session = Session::start(Arc::clone(&prepared), &options(3)).unwrap();
    let mut sink = MemorySink::default();
    for (f, view) in views.iter().enumerate() {
        session.begin(&[*view]).unwrap();
        match f % 4 {
            0 => continue,
            1 => session.cancel(),
            _ => {
                while f % 4 == 3 && !session.is_made() {
                    std::thread::yield_now();
                }
                session.finish(&mut sink).unwrap();
                assert_eq!(drawn(&sink), drawn(&from_scratch(&session)), "{f}");
            }
        }
        let nothing = session.finish(&mut sink).unwrap();
        assert_eq!((nothing.tiles, nothing.whole), (0, false));
    }
}

/// Counts calls.
#[derive(Default)]
struct Calls {
    begun: usize,
    drawn: usize,
    refuse: bool,
    whole: usize,
}

impl MeshSink for Calls {
    fn begin(&mut self, _: &Scene) -> Result<(), SinkError> {
        self.whole += 1;
        self.begin_changes(&Scene::default(), &SceneChanges::default())
    }
    fn begin_changes(&mut self, _: &Scene, _: &SceneChanges<'_>) -> Result<(), SinkError> {
        self.begun += 1;
        Ok(())
    }
    fn batch(&mut self, _: &mut Batch) -> Result<(), SinkError> {
        match self.refuse {
            true => Err(SinkError::new("memory", std::io::Error::other("full"))),
            false => Ok(()),
        }
    }
    fn drawn(&mut self, _: &DrawnTiles, _: &DrawnTiles) -> Result<(), SinkError> {
        self.drawn += 1;
        Ok(())
    }
}

#[test]
fn a_still_view_does_no_work_and_a_refused_frame_is_sent_whole_again() {
    let prepared = two_sizes("torus");
    let view = path(&mut SplitMix(1), prepared.bounds.unwrap(), 1)[0];
    let mut session = Session::start(Arc::clone(&prepared), &options(2)).unwrap();
    let mut sink = Calls::default();
    for _ in 0..3 {
        session.view(&[view], &mut sink).unwrap();
    }
    assert_eq!((sink.begun, sink.drawn, sink.whole), (1, 1, 1));
    let mut closer = view;
    closer.camera.eye += 0.6 * view.camera.forward;
    sink.refuse = true;
    assert!(session.view(&[closer], &mut sink).is_err());
    sink.refuse = false;
    let report = session.view(&[closer], &mut sink).unwrap();
    assert_eq!((report.whole, report.tiles, sink.whole), (true, session.prepared().tiles().count(), 2));
}

#[test]
fn tiles_off_screen_for_long_are_evicted_when_they_are_many() {
    let prepared = shape("brake-hub");
    let mut session = Session::start(Arc::clone(&prepared), &options(2)).unwrap();
    let mut sink = MemorySink::default();
    let whole = path(&mut SplitMix(1), prepared.bounds.unwrap(), 1)[0];
    session.view(&[whole], &mut sink).unwrap();
    let triangles = |batches: &[Batch]| batches.iter().map(|b| b.mesh.triangles.len()).sum::<usize>();
    let all = triangles(&sink.batches);
    // Past the model, a little further each time, and back.
    let Camera { forward, up, .. } = whole.camera;
    let aside = |k: u32| {
        let forward = forward + 1.3 * forward.cross(up) * (1.0 + 1e-4 * f64::from(k));
        View { camera: Camera { forward, ..whole.camera }, ..whole }
    };
    let (mut evicted, mut most) = (0, 0.0_f64);
    for k in 0..220 {
        evicted += session.view(&[aside(k)], &mut sink).unwrap().evicted;
        assert_eq!(drawn(&sink), drawn(&from_scratch(&session)), "{k}");
        if k > 200 {
            most = most.max(triangles(&sink.batches) as f64 / triangles(&drawn(&sink)) as f64);
        }
    }
    assert!(evicted > 50 && most <= 2.0, "{evicted} {most}");
    let again = session.view(&[whole], &mut sink).unwrap();
    assert!(again.tiles >= evicted && triangles(&drawn(&sink)) >= all, "{}", again.tiles);
    assert_eq!(drawn(&sink), drawn(&from_scratch(&session)));
}

#[test]
fn instances_come_move_and_go() {
    let prepared = shape("torus");
    let view = path(&mut SplitMix(2), prepared.bounds.unwrap(), 1)[0];
    let mut session = Session::start(Arc::clone(&prepared), &options(2)).unwrap();
    let mut sink = MemorySink::default();
    let coarse = session.view(&[view], &mut sink).unwrap().triangles;
    let mut nearer = session.scene().instances[0].clone();
    nearer.transform = DAffine3::from_translation(0.5 * (view.camera.eye - nearer.transform.translation));
    let (first, second) = (session.instance_key(0).unwrap(), session.add_instance(nearer.clone()).unwrap());
    assert_eq!([first, second].map(|key| session.instance_row(key)), [Some(0), Some(1)]);
    // The level that came with it was in no plan yet.
    assert_eq!([session.plan().unwrap().parts.len(), session.prepared().parts.len()], [2, 2]);
    assert_eq!(session.scene().instances[1].first_face, prepared.scene.parts[0].face_colours.len() as u32);
    let fine = session.view(&[view], &mut sink).unwrap();
    assert!(!fine.whole && fine.triangles > coarse, "{} {coarse}", fine.triangles);
    assert_eq!((sink.scene.instances.len(), drawn(&sink) == drawn(&from_scratch(&session))), (2, true));
    session.move_instance(first, DAffine3::from_translation(DVec3::splat(1e6))).unwrap();
    let bad = [DAffine3::from_scale(DVec3::new(1.0, 2.0, 1.0)), DAffine3::from_translation(DVec3::NAN)];
    for transform in bad {
        let error = session.move_instance(first, transform).unwrap_err();
        assert!(matches!(error, EditError::Transform { .. }), "{error}");
        let new = SceneInstance { transform, ..nearer.clone() };
        assert_eq!(session.add_instance(new).unwrap_err().to_string(), error.to_string());
    }
    session.view(&[view], &mut sink).unwrap();
    assert_eq!((sink.drawn.tiles(0, 0).count(), sink.drawn.tiles(0, 1).count() > 0), (0, true));
    assert!(session.remove_instance(first).is_ok());
    let none = EditError::NoInstance { key: first };
    assert_eq!(session.remove_instance(first).unwrap_err(), none);
    assert_eq!(session.move_instance(first, nearer.transform), Err(none));
    assert_eq!((session.instance_row(second), session.instance_key(0)), (Some(0), Some(second)));
    session.view(&[view], &mut sink).unwrap();
    assert!(sink.scene.instances.len() == 1 && sink.drawn.tiles(0, 0).count() > 0);
    let none = EditError::NoPart { part: PartId(9), count: 1 };
    assert_eq!(session.add_instance(SceneInstance { part: PartId(9), ..nearer }), Err(none));
}

#[test]
fn a_frame_that_was_begun_keeps_the_places_of_its_instances() {
    let prepared = shape("torus");
    let view = path(&mut SplitMix(2), prepared.bounds.unwrap(), 1)[0];
    let mut session = Session::start(Arc::clone(&prepared), &options(2)).unwrap();
    let mut sink = MemorySink::default();
    let key = session.instance_key(0).unwrap();
    let [near, far] = [0.0, 1e6].map(|x| DAffine3::from_translation(DVec3::splat(x)));
    // A frame has the places that were set before it was begun. Where others were set since, the next one has these.
    for (begun, meanwhile) in [(near, far), (far, near), (far, near), (far, far)] {
        session.move_instance(key, begun).unwrap();
        session.begin(&[view]).unwrap();
        session.move_instance(key, meanwhile).unwrap();
        session.finish(&mut sink).unwrap();
        let [made, next] = [begun, meanwhile].map(|place| {
            let places = [&sink.scene, session.scene()].map(|scene| scene.instances[0].transform);
            assert_eq!((places, sink.drawn.tiles(0, 0).count() > 0), ([place; 2], place == near));
            session.view(&[view], &mut sink).unwrap().frame
        });
        assert_eq!(made == next, begun == meanwhile);
    }
}

#[test]
fn degraded_tiles_are_told_for_as_long_as_the_sink_has_them() {
    let mut prepared = Prepared::clone(&shape("box"));
    // A tile without loops is empty whenever it is made.
    let part = Arc::make_mut(&mut Arc::make_mut(&mut prepared.parts)[0]);
    part.tiles[0].loops.clear();
    part.edges.iter_mut().for_each(|edge| edge.uses.retain(|place| place.tile != TileId(0)));
    let prepared = Arc::new(prepared);
    let view = path(&mut SplitMix(2), prepared.bounds.unwrap(), 1)[0];
    let aside = View { camera: Camera { forward: -view.camera.forward, ..view.camera }, ..view };
    let mut session = Session::start(Arc::clone(&prepared), &options(2)).unwrap();
    let mut sink = MemorySink::default();
    assert_eq!(session.degraded().count(), 0);
    for (k, view) in [view, view, aside, view].into_iter().enumerate() {
        let report = session.view(&[view], &mut sink).unwrap();
        let degraded: Vec<_> = session.degraded().map(|tile| (tile.part, tile.tile)).collect();
        assert_eq!((degraded, report.degraded.len()), (vec![(PartId(0), TileId(0))], usize::from(k == 0)), "{k}");
    }
    session.forget();
    assert_eq!(session.view(&[aside], &mut sink).unwrap().degraded.len(), 0);
    assert_eq!(session.degraded().count(), 0, "a whole frame without the tile");
}

/// Rows of instances of a part, at increasing distances from the camera.
fn crowd(name: &str) -> Arc<Prepared> {
    let mut model = ModelBuilder::new("crowd");
    let part = model.part(trimtess_models::by_name(name).unwrap().parts.swap_remove(0));
    for k in 0..60 {
        let place = DVec3::new(40.0 * f64::from(k % 4), 60.0 * f64::from(k / 4), 0.0);
        model.place(part, DAffine3::from_translation(place));
    }
    prepared(model.finish().unwrap())
}

#[test]
fn distant_instances_have_coarser_levels_of_detail() {
    let prepared = crowd("torus");
    let eye = DVec3::new(60.0, -80.0, 30.0);
    let view = path(&mut SplitMix(1), prepared.bounds.unwrap(), 1)[0];
    let still = Camera { eye, forward: DVec3::Y, ..view.camera };
    let mut drawn_at = Vec::new();
    for levels in [1, 2, 4] {
        let mut session = Session::start(Arc::clone(&prepared), &options(2).with_levels(levels)).unwrap();
        let mut sink = MemorySink::default();
        let mut triangles = 0;
        for k in 0..12 {
            let camera = Camera { eye: eye + DVec3::Y * 20.0 * f64::from(k), ..still };
            let view = View { camera, ..view };
            session.view(&[view], &mut sink).unwrap();
            assert_eq!(drawn(&sink), drawn(&from_scratch(&session)), "{levels} {k}");
            assert!((0..60).all(|i| session.part_of(i) == Some(PartId(0))));
            triangles += triangles_drawn(&sink);
            // Every instance keeps the screen-space error, whatever level it has.
            if k == 5 {
                let frame = MemorySink::of(sink.scene.clone(), drawn(&sink), Vec::new());
                let (share, _) = measured(session.prepared(), &view, 1.0, &frame);
                assert!(share <= 1.0, "{levels} {k}: {share}");
            }
        }
        drawn_at.push(triangles);
    }
    assert!(2 * drawn_at[2] < drawn_at[0] && drawn_at[2] < drawn_at[1], "{drawn_at:?}");
}

/// Triangles of all instances in the first view.
fn triangles_drawn(sink: &MemorySink) -> usize {
    let of_row = |(i, instance): (usize, &SceneInstance)| -> usize {
        let rows = sink.batches.iter().filter(|b| b.part == instance.part && sink.drawn.contains(0, i, b.tile));
        rows.map(|b| b.mesh.triangles.len()).sum()
    };
    sink.scene.instances.iter().enumerate().map(of_row).sum()
}

#[test]
fn instances_that_are_added_have_levels_of_detail() {
    let prepared = crowd("torus");
    let eye = DVec3::new(60.0, -80.0, 30.0);
    let view = path(&mut SplitMix(1), prepared.bounds.unwrap(), 1)[0];
    let view = View { camera: Camera { eye, forward: DVec3::Y, ..view.camera }, ..view };
    let mut known = MemorySink::default();
    Session::start(Arc::clone(&prepared), &options(2)).unwrap().view(&[view], &mut known).unwrap();

    // One instance, and the others later: some before the first frame, some between frames.
    let mut alone = Prepared::clone(&prepared);
    let others = alone.scene.instances.split_off(1);
    for first in [0, 1, 5, 59] {
        let mut session = Session::start(Arc::new(alone.clone()), &options(2)).unwrap();
        let mut sink = MemorySink::default();
        for (k, instance) in others.iter().enumerate() {
            if k == first || k % 20 == 19 {
                session.view(&[view], &mut sink).unwrap();
            }
            let key = session.add_instance(instance.clone()).unwrap();
            assert_eq!(session.instance_row(key), Some(k + 1));
        }
        session.view(&[view], &mut sink).unwrap();
        assert_eq!((session.scene().parts.len(), sink.scene.parts.len()), (4, 4));
        assert!((0..60).all(|i| session.part_of(i) == Some(PartId(0))));
        assert_eq!(drawn(&sink), drawn(&from_scratch(&session)), "{first}");
        assert_eq!(triangles_drawn(&sink), triangles_drawn(&known), "{first}");
        let frame = MemorySink::of(sink.scene.clone(), drawn(&sink), Vec::new());
        let (share, _) = measured(session.prepared(), &view, 1.0, &frame);
        assert!(share <= 1.0, "{first}: {share}");
    }
}

#[test]
fn two_views_share_the_finer_rates_and_draw_their_own_tiles() {
    let prepared = shape("brake-hub");
    let mut draw = SplitMix(11);
    let views = path(&mut draw, prepared.bounds.unwrap(), 12);
    let mut session = Session::start(Arc::clone(&prepared), &options(2)).unwrap();
    let mut sink = MemorySink::default();
    for (k, view) in views.iter().enumerate() {
        let Camera { forward, up, .. } = view.camera;
        let camera = Camera { forward: forward + 0.4 * forward.cross(up), ..view.camera };
        let aside = View { camera, deviation_px: 1.0, ..*view };
        session.view(&[*view, aside], &mut sink).unwrap();
        assert_eq!(drawn(&sink), drawn(&from_scratch(&session)), "{k}");
        for (v, view) in [*view, aside].iter().enumerate() {
            let shown = |b: &&Batch| sink.drawn.contains(v, 0, b.tile);
            let batches: Vec<Batch> = sink.batches.iter().filter(shown).cloned().collect();
            let frame = MemorySink::of(sink.scene.clone(), batches, Vec::new());
            let (share, _) = measured(&prepared, view, 0.05 * prepared.scene.parts[0].radius, &frame);
            assert!(share <= 1.0, "{k} {v}: {share}");
        }
    }
}

#[test]
fn invalid_views_are_refused_and_nothing_changes() {
    let prepared = prepared(trimtess_models::by_name("torus").unwrap());
    let good = path(&mut SplitMix(1), prepared.bounds.unwrap(), 1)[0];
    let mut session = Session::start(Arc::clone(&prepared), &options(1)).unwrap();
    let mut sink = MemorySink::default();
    let bad = [
        View { camera: Camera { forward: DVec3::ZERO, ..good.camera }, ..good },
        View { camera: Camera { eye: DVec3::NAN, ..good.camera }, ..good },
        View { deviation_px: 0.0, ..good },
        View { size_px: Some(-1.0), ..good },
        View { angle: f64::NAN, ..good },
    ];
    session.view(&[good], &mut sink).unwrap();
    let shown = drawn(&sink);
    for view in bad {
        let error = session.view(&[good, view], &mut sink).unwrap_err();
        assert!(matches!(error, FrameError::View { view: 1, .. }), "{error}");
        assert_eq!(drawn(&sink), shown);
        let mut planner = Planner::new(Arc::clone(&prepared), &PlannerOptions::DEFAULT);
        let mut placed = PlacedInstances::of(&prepared);
        let plan = planner.plan(&mut placed, &[view]);
        assert!(plan.shortfall.as_ref().unwrap().unusable && plan.drawn.tiles(0, 0).count() == 0);
    }
    session.view(&[], &mut sink).unwrap();
    assert_eq!(drawn(&sink).len(), 0);
    session.view(&[good], &mut sink).unwrap();
    assert_eq!(drawn(&sink), drawn(&from_scratch(&session)));
    assert!(!drawn(&sink).is_empty());
}
