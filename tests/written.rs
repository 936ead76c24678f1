//! Tiles that workers write into a sink's memory: the same triangles as batches have, no room lost, and no crack.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "common/blocks.rs"]
mod blocks;
mod common;
#[path = "../benches/common/nowhere.rs"]
mod nowhere;
#[path = "sequence/random.rs"]
mod random;

use blocks::{BlockSink, Blocks, Refusal, decoded};
use common::prepared;
use glam::{DAffine3, DVec3, Vec3};
use nowhere::Nowhere;
use random::SplitMix;
use std::sync::Arc;
use std::time::Duration;
use trimtess::control::Control;
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::{
    Batch, IndexFormat, MemorySink, NormalFormat, PositionFormat, SceneInstance, SinkError, TileMemory, VertexLayout,
    WrittenTile, check_scene,
};
use trimtess::model::{Face, Part, PartId, shapes};
use trimtess::parallel::{FrameError, Session, SessionOptions, serial};
use trimtess::prepare::Prepared;
use trimtess::view::{CameraPath, Picture, View};

const PICTURE: Picture = Picture { size: (640, 480), deviation_px: 0.5, size_px: None, angle: 0.5 };

fn shape(name: &str) -> Arc<Prepared> {
    prepared(trimtess_models::by_name(name).unwrap())
}

fn layouts() -> Vec<VertexLayout> {
    let all = VertexLayout::COMPACT.with_uv(true).with_tangent(true).with_origin(true).with_normal(NormalFormat::F32);
    vec![
        VertexLayout::COMPACT,
        VertexLayout::COMPACT.with_index(IndexFormat::U32).with_normal(NormalFormat::None),
        VertexLayout::COMPACT.with_position(PositionFormat::Grid),
        VertexLayout::COMPACT.with_tangent(true),
        all.with_position(PositionFormat::F64),
        all.with_position(PositionFormat::Grid).with_normal(NormalFormat::Octahedral),
    ]
}

fn session(prepared: &Arc<Prepared>, workers: usize) -> Session {
    let options = SessionOptions::DEFAULT.with_workers(workers).with_edge_lines(false);
    Session::start(Arc::clone(prepared), &options).unwrap()
}

fn writing(prepared: &Arc<Prepared>, workers: usize, layout: VertexLayout) -> (Session, BlockSink) {
    let (mut session, sink) = (session(prepared, workers), BlockSink::default());
    session.write_into(layout, Arc::<Blocks>::clone(&sink.memory));
    (session, sink)
}

fn tolerance(prepared: &Prepared, rel: f64) -> Tolerance {
    Tolerance { chord: rel * prepared.diagonal, angle: 0.5, max_edge: None }
}

/// Asserts that a sink holds the same tiles as another one.
fn same(written: &BlockSink, batches: &[Batch], prepared: &Prepared) {
    assert_eq!(written.tiles.len(), batches.len());
    assert_eq!(written.memory.used(), batches.len());
    for (tile, batch) in written.tiles.values().zip(batches) {
        assert_eq!((tile.part, tile.face, tile.tile), (batch.part, batch.face, batch.tile));
        let scene = &prepared.scene.parts;
        let of = scene.get(tile.part.index()).or(written.scene.parts.get(tile.part.index())).unwrap();
        let (mesh, tangents, origins) = decoded(tile, &written.memory.room(tile), of.centre);
        assert_eq!(mesh.triangles, batch.mesh.triangles);
        let apart = match tile.layout.position {
            PositionFormat::F64 => 0.0,
            PositionFormat::F32 => 1e-7 * of.radius,
            _ => 0.501 * 3_f64.sqrt() * tile.grid.unwrap().step,
        };
        let near = |(a, b): (&DVec3, &DVec3)| a.distance(*b) <= apart;
        assert_eq!(mesh.positions.len(), batch.mesh.positions.len());
        assert!(mesh.positions.iter().zip(&batch.mesh.positions).all(near));
        let normals = mesh.normals.iter().zip(&batch.mesh.normals);
        assert!(normals.into_iter().all(|(a, b)| a.distance(*b) < 2e-4));
        // On the surface where it has a normal; poles have none.
        let lies =
            |(t, n): (&Vec3, &Vec3)| t.dot(*n).abs() < 1e-3 && (t.length() - 1.0).abs() < 1e-5 || *t == Vec3::ZERO;
        assert!(tangents.iter().zip(&batch.mesh.normals).all(lies));
        assert!(tangents.iter().filter(|t| **t == Vec3::ZERO).count() <= tangents.len() / 4);
        assert_eq!(tangents.len(), if tile.layout.tangent { mesh.positions.len() } else { 0 });
        if tile.layout.uv {
            assert_eq!(mesh.uvs, batch.mesh.uvs);
            assert!(origins.into_iter().eq(batch.mesh.origins.iter().map(|origin| origin.words())));
        }
    }
}

fn views(prepared: &Prepared, count: usize) -> Vec<View> {
    CameraPath::Glu.views(prepared.bounds.unwrap(), count, &PICTURE)
}

#[test]
fn every_layout_has_the_triangles_of_batches() {
    for name in ["torus", "flower", "brake-hub"] {
        let prepared = shape(name);
        let plan = Arc::new(plan(&prepared, &tolerance(&prepared, 1e-2)));
        let mut whole = MemorySink::default();
        let report = serial(&prepared, &plan, false, &mut whole).unwrap();
        for layout in layouts() {
            for workers in [1, 3] {
                let (mut session, mut sink) = writing(&prepared, workers, layout);
                for _ in 0..2 {
                    let made = session.frame(Arc::clone(&plan), &mut sink).unwrap();
                    assert_eq!((made.batches, made.triangles), (report.batches, report.triangles));
                    assert_eq!((&made.ladder, &made.rungs), (&report.ladder, &report.rungs));
                    same(&sink, &whole.batches, &prepared);
                }
            }
        }
    }
}

#[test]
fn tangents_are_those_of_the_face_after_a_lost_one() {
    let layout = VertexLayout::COMPACT.with_tangent(true);
    let tangents = |part: Part| {
        let prepared = prepared(part);
        let plan = Arc::new(plan(&prepared, &tolerance(&prepared, 1e-2)));
        let (mut session, mut sink) = writing(&prepared, 1, layout);
        session.frame(plan, &mut sink).unwrap();
        let of = |tile: &WrittenTile| decoded(tile, &sink.memory.room(tile), prepared.scene.parts[0].centre).1;
        sink.tiles.values().flat_map(of).collect::<Vec<_>>()
    };
    let whole = shapes::cylinder();
    let mut broken = whole.clone();
    broken.faces.insert(0, Face { lost: true, ..whole.faces[0].clone() });
    let [whole, broken] = [whole, broken].map(tangents);
    assert!(!whole.is_empty() && whole == broken);
}

#[test]
fn rounded_borders_stay_closed() {
    for name in ["torus", "brake-hub", "brake-assembly"] {
        let prepared = shape(name);
        let plan = Arc::new(plan(&prepared, &tolerance(&prepared, 3e-3)));
        let mut whole = MemorySink::default();
        serial(&prepared, &plan, false, &mut whole).unwrap();
        for layout in [PositionFormat::F32, PositionFormat::Grid].map(|p| VertexLayout::COMPACT.with_position(p)) {
            let (mut session, mut sink) = writing(&prepared, 2, layout);
            session.frame(Arc::clone(&plan), &mut sink).unwrap();
            let scene = &prepared.scene;
            for (tile, batch) in sink.tiles.values().zip(&mut whole.batches) {
                let part = &scene.parts[tile.part.index()];
                batch.mesh.positions = decoded(tile, &sink.memory.room(tile), part.centre).0.positions;
            }
            let facts = check_scene(&whole);
            for (part, facts) in scene.parts.iter().zip(&facts.parts) {
                // Slivers may collapse, since corners are rounded; that opens nothing.
                assert_eq!(facts.unbalanced_edges == 0, part.closed, "{name} {layout:?} {}", part.name);
            }
        }
    }
}

#[test]
fn frames_of_views_are_those_of_batches_for_any_number_of_workers() {
    let prepared = shape("brake-assembly");
    let path = views(&prepared, 12);
    for layout in [VertexLayout::COMPACT, layouts()[3]] {
        let (mut batches, mut kept) = (session(&prepared, 1), MemorySink::default());
        let mut writers: Vec<_> = [1, 2, 3, 8, 29].map(|workers| writing(&prepared, workers, layout)).into();
        for (k, view) in path.iter().enumerate() {
            let expected = batches.view(&[*view], &mut kept).unwrap();
            for (session, sink) in &mut writers {
                let made = session.view(&[*view], sink).unwrap();
                assert_eq!((made.whole, made.tiles, made.batches), (k == 0, expected.tiles, expected.batches));
                assert_eq!(sink.drawn, kept.drawn);
                same(sink, &kept.batches, session.prepared());
            }
        }
        // In the middle of a session, the sink may change how it wants its tiles.
        let (session, sink) = &mut writers[1];
        let before = sink.memory.used();
        session.write_into(VertexLayout::COMPACT.with_uv(true).with_origin(true), Arc::<Blocks>::clone(&sink.memory));
        assert!(session.view(&path[11..], sink).unwrap().whole);
        assert!(sink.memory.used() <= before && sink.tiles.values().all(|tile| tile.layout.uv));
        let mut again = MemorySink::default();
        batches.forget();
        batches.view(&path[11..], &mut again).unwrap();
        same(sink, &again.batches, &prepared);
    }
}

#[test]
fn rebalanced_sessions_make_whole_frames_of_all_tiles() {
    let prepared = shape("brake-assembly");
    let mut expected = MemorySink::default();
    let plan = Arc::new(plan(&prepared, &tolerance(&prepared, 1e-3)));
    serial(&prepared, &plan, false, &mut expected).unwrap();
    for workers in [2, 5] {
        let options = SessionOptions::DEFAULT.with_workers(workers).with_edge_lines(false).with_rebalance_every(2);
        let mut session = Session::start(Arc::clone(&prepared), &options).unwrap();
        let (mut batches, mut written) = (MemorySink::default(), BlockSink::default());
        for view in views(&prepared, 6) {
            session.view(&[view], &mut batches).unwrap();
        }
        session.frame(Arc::clone(&plan), &mut batches).unwrap();
        assert!(session.prepared().tiles().count() >= batches.batches.len());
        assert_eq!(batches.batches.len(), expected.batches.len());
        for (made, wanted) in batches.batches.iter().zip(&expected.batches) {
            assert_eq!((made.part, made.tile, &made.mesh), (wanted.part, wanted.tile, &wanted.mesh));
        }
        session.write_into(VertexLayout::COMPACT, Arc::<Blocks>::clone(&written.memory));
        session.frame(Arc::clone(&plan), &mut written).unwrap();
        same(&written, &expected.batches, &prepared);
    }
}

#[test]
fn no_room_is_lost_by_cancelled_frames_and_added_instances() {
    let prepared = shape("brake-assembly");
    let path = views(&prepared, 40);
    let mut draw = SplitMix(7);
    let (mut session, mut sink) = writing(&prepared, 2, VertexLayout::COMPACT);
    for (k, view) in path.iter().enumerate() {
        session.begin(&[*view]).unwrap();
        std::thread::sleep(Duration::from_micros((2000.0 * draw.unit()) as u64));
        if draw.unit() < 0.6 {
            session.cancel();
        }
        if k % 7 == 3 {
            let part = PartId(k as u32 % prepared.parts.len() as u32);
            let transform = DAffine3::from_translation(DVec3::splat(k as f64));
            session.add_instance(SceneInstance::new(part, transform)).unwrap();
        }
        session.finish(&mut sink).unwrap();
        if matches!(session.finish_within(Duration::from_secs(60), &mut sink), Ok(Some(report)) if report.tiles > 0) {
            panic!("a frame that was not begun");
        }
        assert_eq!(sink.memory.used(), sink.tiles.len());
    }
    session.view(&path[..1], &mut sink).unwrap();
    session.begin(&path[1..2]).unwrap();
    drop(session);
    assert_eq!(sink.memory.used(), sink.tiles.len());
}

#[test]
fn refused_rooms_cost_the_frame_and_nothing_else() {
    let prepared = shape("brake-hub");
    let path = views(&prepared, 8);
    let mut batches = session(&prepared, 1);
    let mut kept = MemorySink::default();
    let (mut session, mut sink) = writing(&prepared, 3, VertexLayout::COMPACT);
    for (k, view) in path.iter().enumerate() {
        for bad in [Refusal::Error, Refusal::Panic, Refusal::Short, Refusal::Nothing] {
            sink.memory.refuse(Some(k as u32), bad);
            let calls = (sink.calls, sink.aborts);
            let result = session.view(&[*view], &mut sink);
            let refused = matches!(&result, Err(FrameError::Sink(_)));
            // A frame that changes fewer tiles has no such call.
            assert!(refused || result.unwrap().tiles <= k, "{bad:?}");
            if refused {
                assert_eq!((sink.calls, sink.aborts), calls, "the sink hears of a frame that was refused");
            }
            assert_eq!(sink.memory.used(), sink.tiles.len());
        }
        sink.memory.refuse(None, Refusal::Error);
        session.view(&[*view], &mut sink).unwrap();
        batches.view(&[*view], &mut kept).unwrap();
        same(&sink, &kept.batches, &prepared);
    }
}

#[test]
fn a_sink_that_refuses_a_written_tile_gets_a_whole_frame_next() {
    let prepared = shape("brake-hub");
    let path = views(&prepared, 2);
    for at in [0, 1, 5] {
        let (mut session, mut sink) = writing(&prepared, 3, VertexLayout::COMPACT);
        session.view(&path[..1], &mut sink).unwrap();
        sink.refuse = Some(at);
        assert!(matches!(session.view(&path[1..], &mut sink), Err(FrameError::Sink(_))));
        assert_eq!((sink.aborts, sink.memory.used()), (1, sink.tiles.len()));
        let report = session.view(&path[1..], &mut sink).unwrap();
        assert!(report.whole && report.tiles > 0);
        assert_eq!(sink.memory.used(), sink.tiles.len());
    }
}

#[test]
fn rooms_that_a_sink_leaves_are_given_back() {
    let prepared = shape("brake-hub");
    let path = views(&prepared, 2);
    for (most, bad) in
        [Refusal::Error, Refusal::Panic, Refusal::Nothing].into_iter().flat_map(|bad| [(0, bad), (2, bad)])
    {
        let (mut session, mut sink) = writing(&prepared, 1, VertexLayout::COMPACT);
        session.view(&path[..1], &mut sink).unwrap();
        sink.takes = Some((most, bad));
        let error = session.view(&path[1..], &mut sink).unwrap_err();
        assert!(sink.takes.is_none() && matches!(error, FrameError::Sink(_)), "{bad:?}: {error}");
        assert_eq!((sink.aborts, sink.memory.used()), (1, sink.tiles.len()), "{most} taken, then {bad:?}");
        assert!(session.view(&path[1..], &mut sink).unwrap().whole);
        assert_eq!(sink.memory.used(), sink.tiles.len());
    }
}

/// Memory that panics where it is given a room back.
struct Greedy(Arc<Blocks>);

impl TileMemory for Greedy {
    fn write(&self, tile: &WrittenTile, fill: &mut dyn FnMut(&mut [u8], &mut [u8])) -> Result<u64, SinkError> {
        self.0.write(tile, fill)
    }

    fn release(&self, _: &WrittenTile) {
        panic!("nothing is given back")
    }
}

#[test]
fn a_memory_that_panics_leaves_no_frame_open() {
    let prepared = shape("brake-hub");
    let path = views(&prepared, 2);
    let (mut session, mut sink) = (session(&prepared, 3), BlockSink::default());
    session.write_into(VertexLayout::COMPACT, Arc::new(Greedy(Arc::clone(&sink.memory))));
    session.view(&path[..1], &mut sink).unwrap();
    sink.refuse = Some(1);
    assert!(matches!(session.view(&path[1..], &mut sink), Err(FrameError::Sink(_))));
    assert_eq!(sink.aborts, 1);
    assert!(session.view(&path[1..], &mut sink).unwrap().whole);
}

#[test]
fn a_grid_too_coarse_for_the_tolerance_is_refused_with_numbers() {
    let prepared = shape("torus");
    let layout = VertexLayout::COMPACT.with_position(PositionFormat::Grid);
    let (mut session, mut sink) = writing(&prepared, 2, layout);
    let fine = Arc::new(plan(&prepared, &tolerance(&prepared, 3e-6)));
    let FrameError::Grid(error) = session.frame(Arc::clone(&fine), &mut sink).unwrap_err() else {
        panic!("another error")
    };
    assert!(error.moved > 0.1 * error.chord && error.moved < 1e-4 * prepared.diagonal, "{error}");
    assert_eq!((sink.calls, sink.memory.used()), (0, 0));
    let coarse = Arc::new(plan(&prepared, &tolerance(&prepared, 1e-3)));
    session.frame(Arc::clone(&coarse), &mut sink).unwrap();
    assert_eq!(sink.memory.used(), sink.tiles.len());
}

#[test]
fn a_view_that_is_shown_costs_no_calls() {
    let prepared = shape("torus");
    let path = views(&prepared, 2);
    let (mut session, mut sink) = writing(&prepared, 2, VertexLayout::COMPACT);
    for _ in 0..80 {
        session.view(&path[..1], &mut sink).unwrap();
    }
    let calls = sink.calls;
    let report = session.view(&path[..1], &mut sink).unwrap();
    assert_eq!((sink.calls, report.tiles, report.whole), (calls, 0, false));
    let at = session.scene().instances[0].transform;
    let key = session.instance_key(0).unwrap();
    session.move_instance(key, at).unwrap();
    session.view(&path[..1], &mut sink).unwrap();
    assert_eq!(sink.calls, calls, "nothing moved");
    session.move_instance(key, at * DAffine3::from_translation(DVec3::X)).unwrap();
    session.view(&path[..1], &mut sink).unwrap();
    assert!(sink.calls > calls, "an instance moved");
    let calls = sink.calls;
    session.forget();
    assert!(session.view(&path[..1], &mut sink).unwrap().whole && sink.calls > calls);
}

#[test]
fn a_view_that_is_shown_allocates_nothing() {
    let prepared = shape("brake-assembly");
    let path = views(&prepared, 2);
    let (mut session, mut sink) = writing(&prepared, 2, VertexLayout::COMPACT);
    for _ in 0..80 {
        session.view(&path[..1], &mut sink).unwrap();
    }
    let spent = allocation_counter::measure(|| {
        for _ in 0..10 {
            session.view(&path[..1], &mut sink).unwrap();
        }
    });
    assert_eq!(spent.count_total, 0);
}

/// Keeps nothing, so that all allocations are those of the session.
impl TileMemory for Nowhere {
    fn write(&self, tile: &WrittenTile, fill: &mut dyn FnMut(&mut [u8], &mut [u8])) -> Result<u64, SinkError> {
        fill(&mut vec![0; tile.vertex_bytes()], &mut vec![0; tile.index_bytes()]);
        Ok(0)
    }

    fn release(&self, _: &WrittenTile) {}
}

#[test]
fn a_frame_of_a_flight_makes_few_allocations_on_the_callers_thread() {
    let prepared = shape("brake-assembly");
    let path = CameraPath::Orbit.views(prepared.bounds.unwrap(), 200, &PICTURE);
    for (written, workers) in [(true, 2), (true, 29), (false, 2)] {
        let mut session = session(&prepared, workers);
        if written {
            session.write_into(VertexLayout::COMPACT, Arc::new(Nowhere));
        }
        let (mut most, mut tiles) = (0, 0);
        for (k, view) in path.iter().enumerate() {
            // Once it changes, and once it does not.
            for changes in [true, false] {
                let begin = allocation_counter::measure(|| session.begin(&[*view]).unwrap());
                // What no thread has begun, the caller would make.
                while !session.is_made() {
                    std::thread::yield_now();
                }
                let mut made = 0;
                let finish = allocation_counter::measure(|| made = session.finish(&mut Nowhere).unwrap().tiles);
                let count = begin.count_total + finish.count_total;
                if changes && k > 0 {
                    (most, tiles) = (count.max(most), tiles + made);
                } else if !changes {
                    assert_eq!((count, made), (0, 0), "frame {k}, written: {written}, {workers} workers");
                }
            }
        }
        let case = format!("{most} allocations for {tiles} tiles, written: {written}, {workers} workers");
        println!("at most {case}");
        assert!(most <= 10 && tiles > 1000, "{case}");
    }
}

#[test]
fn no_room_is_lost_when_an_observer_panics() {
    let prepared = shape("brake-hub");
    let plan = Arc::new(plan(&prepared, &tolerance(&prepared, 1e-2)));
    let (mut session, mut sink) = writing(&prepared, 2, VertexLayout::COMPACT);
    let control = Control::observed_by(|progress| assert!(progress.done < 5, "an observer"));
    let frame = || session.frame_controlled(Arc::clone(&plan), &control, &mut sink).map(|_| ());
    assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(frame)).is_err());
    assert_eq!((sink.calls, sink.memory.used()), (0, 0));
    session.frame(Arc::clone(&plan), &mut sink).unwrap();
    assert_eq!(sink.memory.used(), sink.tiles.len());
}
