//! Sessions that go on with an updated model: their sink has what a new session's would, and gets only what differs.

use crate::blocks::{BlockSink, Blocks, Refusal};
use crate::edits::Edit;
use crate::prepared::changed;
use crate::random::SplitMix;
use crate::{built, common, edits, models, pool};
use glam::{DAffine3, DVec3};
use std::sync::Arc;
use trimtess::control::Alone;
use trimtess::frame::{DamagedPlan, PlanLimits, Tolerance, plan_for_view_within};
use trimtess::mesh::{
    Batch, DrawnTiles, EdgeLine, MemorySink, MeshSink, Scene, SceneChanges, SceneInstance, SinkError, VertexLayout,
};
use trimtess::model::{Instance, Model, PartId};
use trimtess::parallel::{EditError, FrameError, Session, SessionOptions, serial};
use trimtess::prepare::{PrepareOptions, Prepared};
use trimtess::view::{Camera, CameraPath, Picture, Projection, View};

const OPTIONS: SessionOptions = SessionOptions::DEFAULT.with_workers(3);
const PICTURE: Picture = Picture { size: (400, 300), deviation_px: 0.5, size_px: None, angle: 0.7 };

fn start(prepared: &Arc<Prepared>) -> Session {
    Session::start_on(Arc::new(Alone), Arc::clone(prepared), &OPTIONS)
}

fn updated(prepared: &Prepared, model: &Model) -> Arc<Prepared> {
    Arc::new(prepared.update(model.clone(), &PrepareOptions::DEFAULT).unwrap())
}

/// A view from which some parts are hidden, and some beside the picture.
pub(crate) fn view_of(prepared: &Prepared) -> View {
    let [low, high] = prepared.bounds.unwrap();
    let (centre, size) = (0.5 * (low + high), (high - low).length());
    let projection = Projection::Perspective { fov_y: 0.5, near: 1e-3 * size };
    let camera = Camera::looking_at(centre + size * DVec3::new(0.5, -0.7, 0.4), centre, DVec3::Z, projection);
    View { camera, size: PICTURE.size, deviation_px: 0.5, size_px: None, angle: 0.7 }
}

/// A sink in memory that lists the parts whose tiles and lines it got in the last frame.
#[derive(Default)]
struct Spy {
    sink: MemorySink,
    sent: Vec<PartId>,
    whole: usize,
}

impl MeshSink for Spy {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.whole += 1;
        self.sent.clear();
        self.sink.begin(scene)
    }

    fn begin_changes(&mut self, scene: &Scene, changes: &SceneChanges<'_>) -> Result<(), SinkError> {
        self.sent.clear();
        self.sink.begin_changes(scene, changes)
    }

    fn begin_update(
        &mut self,
        scene: &Scene,
        changes: &SceneChanges<'_>,
        from: &[Option<PartId>],
    ) -> Result<(), SinkError> {
        assert_eq!(from.len(), scene.parts.len());
        assert!(from.iter().flatten().all(|part| part.index() < self.sink.scene.parts.len()), "{from:?}");
        self.sent.clear();
        self.sink.begin_update(scene, changes, from)
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        self.sent.push(batch.part);
        self.sink.batch(batch)
    }

    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError> {
        self.sent.push(line.part);
        self.sink.edge_line(line)
    }

    fn drawn(&mut self, drawn: &DrawnTiles, before: &DrawnTiles) -> Result<(), SinkError> {
        self.sink.drawn(drawn, before)
    }

    fn end(&mut self) -> Result<(), SinkError> {
        self.sink.end()
    }

    fn abort(&mut self) {
        self.sink.abort();
    }
}

/// What a sink has: all but triangles as text, and triangles without the numbers of workers. Without keys, which are
/// names that each session gives.
fn content(sink: &MemorySink) -> (String, Vec<Batch>) {
    let mut scene = sink.scene.clone();
    scene.parts.iter_mut().for_each(|part| part.key = None);
    scene.instances.iter_mut().for_each(|instance| instance.key = None);
    let batches = sink.batches.iter().cloned().map(|batch| Batch { worker: 0, ..batch }).collect();
    (format!("{:?} {:?} {:?}", scene, sink.drawn, sink.edge_lines), batches)
}

fn assert_same(sink: &MemorySink, prepared: &Arc<Prepared>, view: &View, what: &str) {
    let mut fresh = MemorySink::default();
    start(prepared).view(&[*view], &mut fresh).unwrap();
    let ((told, batches), (other, others)) = (content(sink), content(&fresh));
    // No `assert_eq`: it would print all vertices.
    let differs = told.bytes().zip(other.bytes()).position(|(a, b)| a != b).unwrap_or(told.len().min(other.len()));
    let around = |text: &str| text.chars().skip(differs.saturating_sub(200)).take(400).collect::<String>();
    assert!(told == other, "{what}: {}\nin a new session: {}", around(&told), around(&other));
    let keys = |batches: &[Batch]| batches.iter().map(|batch| (batch.part, batch.tile)).collect::<Vec<_>>();
    assert_eq!(keys(&batches), keys(&others), "{what}");
    let differ = |(one, other): (&Batch, &Batch)| (one != other).then_some((one.part, one.tile));
    let differ: Vec<_> = batches.iter().zip(&others).filter_map(differ).collect();
    assert_eq!(differ, [], "{what}");
}

/// Tiles that a session makes when it goes on with `next`.
pub(crate) fn tiles_of_update(prepared: &Arc<Prepared>, next: &Arc<Prepared>, view: &View) -> usize {
    let (mut session, mut sink) = (start(prepared), MemorySink::default());
    session.view(&[*view], &mut sink).unwrap();
    session.update(Arc::clone(next)).unwrap();
    session.view(&[*view], &mut sink).unwrap().tiles
}

#[test]
fn after_random_edits_a_sink_has_what_a_new_session_would_give_it() {
    let models = models();
    let (count, pool, limits) = (edits() / models.len() as u64, pool(), PlanLimits::DEFAULT);
    let mut tiles = [0, 0];
    for (k, mut model) in models.into_iter().enumerate() {
        let mut draw = SplitMix(100 + k as u64);
        let mut prepared = common::prepared(model.clone());
        let view = view_of(&prepared);
        let (mut session, mut spy) = (start(&prepared), Spy::default());
        session.view(&[view], &mut spy).unwrap();
        // So that the first update has something to invalidate.
        assert!(session.plan_for_view(&view, &limits) == plan_for_view_within(&prepared, &view, &limits));
        for number in 0..count {
            let edit = Edit::DISTINCT[draw.below(Edit::DISTINCT.len() as u64) as usize];
            edit.apply(&mut model, &pool, &mut draw);
            let next = updated(&prepared, &model);
            let what = format!("{} {number}: {edit:?}", model.name);
            session.update(Arc::clone(&next)).unwrap();
            let report = session.view(&[view], &mut spy).unwrap();
            assert_same(&spy.sink, &next, &view, &what);
            // What plans of one view read of the model is that of the new one.
            assert!(session.plan_for_view(&view, &limits) == plan_for_view_within(&next, &view, &limits), "{what}");
            let new = changed(&prepared, &next);
            let part = |row: &PartId| next_part(&spy.sink.scene, *row).index();
            assert!(spy.sent.iter().all(|row| new.contains(&part(row))), "{what}: {:?}, not {new:?}", spy.sent);
            tiles = [tiles[0] + report.tiles, tiles[1] + next.tiles().count()];
            assert!(session.view(&[view], &mut spy).unwrap().tiles == 0, "{what}: nothing is left");
            prepared = next;
        }
        assert_eq!(spy.whole, 1);
    }
    println!("{} tiles made of {} in {} edits", tiles[0], tiles[1], edits());
    assert!(tiles[0] > 0 && 4 * tiles[0] < tiles[1], "{tiles:?}");
}

/// The model's part of a row of a scene.
fn next_part(scene: &Scene, row: PartId) -> PartId {
    scene.parts[row.index()].mesh_of.unwrap_or(row)
}

#[test]
fn moving_cameras_go_on_and_the_sink_always_holds_the_plan() {
    let (mut model, pool, mut draw) = (built(), pool(), SplitMix(7));
    let mut prepared = common::prepared(model.clone());
    let views = CameraPath::Orbit.views(prepared.bounds.unwrap(), 40, &PICTURE);
    let (mut session, mut spy) = (start(&prepared), Spy::default());
    for (f, view) in views.iter().enumerate() {
        if f % 4 == 3 {
            Edit::ALL[f / 4 % Edit::ALL.len()].apply(&mut model, &pool, &mut draw);
            prepared = updated(&prepared, &model);
            session.update(Arc::clone(&prepared)).unwrap();
        }
        session.view(&[*view], &mut spy).unwrap();
        let mut planned = MemorySink::default();
        serial(session.prepared(), &session.plan().unwrap(), false, &mut planned).unwrap();
        let drawn = |batches: &[Batch]| {
            let rows = || spy.sink.drawn.instances(0);
            let is_drawn = |batch: &Batch| {
                rows().any(|row| {
                    let part = spy.sink.scene.instances[row].part;
                    part == batch.part && spy.sink.drawn.contains(0, row, batch.tile)
                })
            };
            let drawn = batches.iter().filter(|batch| is_drawn(batch)).cloned();
            drawn.map(|batch| Batch { worker: 0, ..batch }).collect::<Vec<_>>()
        };
        assert!(drawn(&spy.sink.batches) == drawn(&planned.batches), "{f}");
    }
    assert_eq!(spy.whole, 1);
}

#[test]
fn frames_in_flight_refusals_and_several_updates_lose_nothing() {
    let (mut model, pool, mut draw) = (built(), pool(), SplitMix(3));
    let mut prepared = common::prepared(model.clone());
    let view = view_of(&prepared);
    let (mut session, mut spy) = (start(&prepared), Spy::default());
    // Before any frame.
    session.update(Arc::clone(&prepared)).unwrap();
    session.view(&[view], &mut spy).unwrap();
    for number in 0..30 {
        for _ in 0..1 + number % 3 {
            Edit::DISTINCT[draw.below(6) as usize].apply(&mut model, &pool, &mut draw);
            prepared = updated(&prepared, &model);
            session.begin(&[view]).unwrap();
            session.update(Arc::clone(&prepared)).unwrap();
        }
        let before = content(&spy.sink);
        assert_eq!(session.finish(&mut spy).unwrap().tiles, 0);
        assert!(content(&spy.sink) == before, "{number}: the sink keeps the last frame");
        if number % 5 == 4 {
            let refused = session.view(&[view], &mut OneModel);
            assert!(matches!(refused, Err(FrameError::Sink(_))), "{number}: {refused:?}");
        }
        session.view(&[view], &mut spy).unwrap();
        assert_same(&spy.sink, &prepared, &view, &number.to_string());
    }
    assert_eq!(spy.whole, 1 + 30 / 5);
}

/// Takes one model only.
struct OneModel;

impl MeshSink for OneModel {
    fn begin(&mut self, _: &Scene) -> Result<(), SinkError> {
        Ok(())
    }

    fn batch(&mut self, _: &mut Batch) -> Result<(), SinkError> {
        Ok(())
    }
}

#[test]
fn memory_of_a_sink_holds_the_tiles_of_the_new_model_and_no_others() {
    let (mut model, pool, mut draw) = (built(), pool(), SplitMix(11));
    let mut prepared = common::prepared(model.clone());
    let view = view_of(&prepared);
    let (mut session, mut sink) = (start(&prepared), BlockSink::default());
    session.write_into(VertexLayout::COMPACT, Arc::<Blocks>::clone(&sink.memory));
    session.view(&[view], &mut sink).unwrap();
    let mut refused = 0;
    for number in 0..24 {
        let before = Arc::clone(&prepared);
        Edit::DISTINCT[number % Edit::DISTINCT.len()].apply(&mut model, &pool, &mut draw);
        prepared = updated(&prepared, &model);
        session.update(Arc::clone(&prepared)).unwrap();
        if changed(&before, &prepared).len() == 1 {
            // The frame is dropped before the sink hears of it, and the next one is no whole one.
            let calls = sink.calls;
            sink.memory.refuse(Some(0), Refusal::Error);
            // Unless nothing of the part is in the picture.
            let is_refused = session.view(&[view], &mut sink).is_err();
            sink.memory.refuse(None, Refusal::Error);
            assert!(!is_refused || sink.calls == calls, "{number}");
            refused += usize::from(is_refused);
        }
        assert!(!session.view(&[view], &mut sink).unwrap().whole, "{number}");
        assert_eq!(sink.memory.used(), sink.tiles.len(), "{number}");
        let (mut other, mut fresh) = (start(&prepared), BlockSink::default());
        other.write_into(VertexLayout::COMPACT, Arc::<Blocks>::clone(&fresh.memory));
        other.view(&[view], &mut fresh).unwrap();
        assert!(sink.tiles.keys().eq(fresh.tiles.keys()), "{number}");
        for (tile, other) in sink.tiles.values().zip(fresh.tiles.values()) {
            let (room, other) = (sink.memory.room(tile), fresh.memory.room(other));
            assert!((room.vertices, room.indices) == (other.vertices, other.indices), "{number}: {tile:?}");
        }
    }
    assert!(refused > 4);
}

#[test]
fn instances_are_those_of_the_new_model_and_old_keys_name_none() {
    let model = built();
    let prepared = common::prepared(model.clone());
    let view = view_of(&prepared);
    let (mut session, mut spy) = (start(&prepared), Spy::default());
    session.view(&[view], &mut spy).unwrap();
    let first = session.instance_key(0).unwrap();
    let added = SceneInstance { name: "added".into(), ..SceneInstance::new(PartId(3), DAffine3::IDENTITY) };
    let added = session.add_instance(added).unwrap();
    session.move_instance(first, DAffine3::from_translation(DVec3::X)).unwrap();
    let next = updated(&prepared, &model);
    session.update(Arc::clone(&next)).unwrap();
    assert_eq!([first, added].map(|key| session.instance_row(key)), [None, None]);
    let gone = session.move_instance(added, DAffine3::IDENTITY).unwrap_err();
    assert_eq!(gone, EditError::NoInstance { key: added });
    assert_eq!(session.scene().instances.len(), model.instances.len());
    session.view(&[view], &mut spy).unwrap();
    assert_same(&spy.sink, &next, &view, "instances");
    let key = session.instance_key(0).unwrap();
    assert_eq!((session.instance_row(key), session.part_of(0)), (Some(0), Some(PartId(0))));
}

/// A box, and an instance of it further away, behind it in [`view_of`].
fn boxes() -> (Model, SceneInstance) {
    let mut model = built();
    model.parts.truncate(1);
    model.instances.truncate(1);
    let transform = DAffine3::from_translation(DVec3::new(-70.0, 42.0, -24.0));
    (model, SceneInstance { name: "far".into(), ..SceneInstance::new(PartId(0), transform) })
}

#[test]
fn a_level_of_detail_that_no_frame_had_before_an_update_is_news_to_the_sink() {
    let (mut model, far) = boxes();
    let prepared = common::prepared(model.clone());
    let view = view_of(&prepared);
    let (mut session, mut spy) = (start(&prepared), Spy::default());
    session.view(&[view], &mut spy).unwrap();
    session.add_instance(far.clone()).unwrap();
    let again = Instance { transform: far.transform, name: far.name, ..model.instances[0].clone() };
    model.instances.push(again);
    let next = updated(&prepared, &model);
    session.update(Arc::clone(&next)).unwrap();
    assert!(!session.view(&[view], &mut spy).unwrap().whole);
    assert_same(&spy.sink, &next, &view, "one more level");
}

#[test]
fn an_added_instance_has_all_edge_lines() {
    let (model, far) = boxes();
    let prepared = common::prepared(model);
    let (mut session, mut spy) = (start(&prepared), Spy::default());
    let view = view_of(&prepared);
    session.view(&[view], &mut spy).unwrap();
    session.add_instance(far).unwrap();
    session.view(&[view], &mut spy).unwrap();
    for instance in &spy.sink.scene.instances {
        let lines = spy.sink.edge_lines.iter().filter(|line| line.part == instance.part).count();
        assert_eq!(lines, prepared.brep_edges().count(), "part {}", instance.part.0);
    }
    assert!(spy.sink.scene.instances[0].part != spy.sink.scene.instances[1].part, "two levels");
}

#[test]
fn plans_from_before_an_update_are_refused() {
    let prepared = common::prepared(boxes().0);
    let (mut session, mut spy) = (start(&prepared), Spy::default());
    let plan = session.plan_within(&Tolerance { chord: 0.1, angle: 0.3, max_edge: None }, &PlanLimits::DEFAULT);
    session.update(updated(&prepared, &built())).unwrap();
    let refused = session.frame(plan, &mut spy).unwrap_err();
    assert!(
        matches!(refused, FrameError::Plan(DamagedPlan::Rows { part: PartId(1), planned: [0, 0], .. })),
        "{refused:?}"
    );
    session.view(&[view_of(&prepared)], &mut spy).unwrap();
}

#[test]
fn memory_follows_the_model() {
    let mut model = built();
    let prepared = common::prepared(model.clone());
    let view = view_of(&prepared);
    let options = SessionOptions::DEFAULT.with_workers(1);
    let mut session = Session::start_on(Arc::new(Alone), Arc::clone(&prepared), &options);
    assert_eq!(session.memory().unwrap().plans, 0);
    let mut spy = Spy::default();
    for views in [[view, view], [view_of(&prepared), CameraPath::Orbit.views(prepared.bounds.unwrap(), 9, &PICTURE)[4]]]
    {
        session.view(&views, &mut spy).unwrap();
    }
    let full = session.memory().unwrap();
    assert!(full.plans > 100 * prepared.tiles().count() as u64, "{full:?}");
    model.parts.truncate(1);
    model.instances.truncate(1);
    session.update(updated(&prepared, &model)).unwrap();
    session.view(&[view], &mut spy).unwrap();
    let less = session.memory().unwrap();
    assert!(5 * less.plans < full.plans && 5 * less.scene < full.scene, "{less:?} of {full:?}");
    assert_eq!(less.total(), less.plans + less.scene);
}
