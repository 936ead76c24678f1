//! Sinks that read only some lists of meshes: the rest of their frames is the same.

use super::frames::path;
use super::{shape, two_sizes};
use crate::random::SplitMix;
use std::sync::Arc;
use trimtess::frame::{self, Tolerance};
use trimtess::mesh::{Batch, DrawnTiles, EdgeLine, MemorySink, MeshLists, MeshSink, Scene, SceneChanges, SinkError};
use trimtess::parallel::{FrameError, Session, SessionOptions};

/// A sink in memory that reads these lists, and the last batches that it was sent.
struct Reader(MeshLists, MemorySink, Vec<Batch>);

impl Reader {
    fn of(lists: MeshLists) -> Self {
        Self(lists, MemorySink::default(), Vec::new())
    }
}

impl MeshSink for Reader {
    fn reads(&self) -> MeshLists {
        self.0
    }
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.1.begin(scene)
    }
    fn begin_changes(&mut self, scene: &Scene, changes: &SceneChanges<'_>) -> Result<(), SinkError> {
        self.1.begin_changes(scene, changes)
    }
    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        self.2.push(Batch { worker: 0, ..batch.clone() });
        self.1.batch(batch)
    }
    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError> {
        self.1.edge_line(line)
    }
    fn drawn(&mut self, drawn: &DrawnTiles, before: &DrawnTiles) -> Result<(), SinkError> {
        self.1.drawn(drawn, before)
    }
    fn end(&mut self) -> Result<(), SinkError> {
        self.1.end()
    }
    fn abort(&mut self) {
        self.1.abort();
    }
}

const SOME: [MeshLists; 4] = [
    MeshLists::NONE,
    MeshLists { uvs: true, ..MeshLists::NONE },
    MeshLists { lines: true, ..MeshLists::NONE },
    MeshLists { origins: true, ..MeshLists::NONE },
];

/// Batches without the lists that are not read.
fn with(lists: MeshLists, batches: &[Batch]) -> Vec<Batch> {
    let mut batches = batches.to_vec();
    for batch in &mut batches {
        batch.worker = 0;
        let mesh = &mut batch.mesh;
        if !lists.uvs {
            mesh.uvs = Vec::new();
        }
        if !lists.lines {
            mesh.lines = Default::default();
        }
        if !lists.origins {
            mesh.origins = Vec::new();
        }
    }
    batches
}

#[test]
fn whole_frames_have_the_lists_that_are_read() {
    for name in trimtess_models::names() {
        let prepared = shape(name);
        let plan = Arc::new(frame::plan(
            &prepared,
            &Tolerance { chord: 1e-3 * prepared.diagonal, angle: 0.35, max_edge: None },
        ));
        let mut session = Session::start(Arc::clone(&prepared), &SessionOptions::DEFAULT.with_workers(3)).unwrap();
        let mut all = MemorySink::default();
        session.frame(Arc::clone(&plan), &mut all).unwrap();
        for lists in SOME {
            let mut some = Reader::of(lists);
            session.frame(Arc::clone(&plan), &mut some).unwrap();
            assert!(with(lists, &all.batches) == with(MeshLists::ALL, &some.1.batches), "{name} {lists:?}");
        }
    }
}

#[test]
fn a_flight_has_the_lists_that_are_read() {
    for (name, lists) in ["torus", "brake-hub", "sphere", "trimmed-teapot"].into_iter().zip(SOME) {
        let prepared = if name == "torus" { two_sizes(name) } else { shape(name) };
        let start = || Session::start(Arc::clone(&prepared), &SessionOptions::DEFAULT.with_workers(2)).unwrap();
        let (mut one, mut other) = (start(), start());
        let (mut all, mut some) = (MemorySink::default(), Reader::of(lists));
        for (k, view) in path(&mut SplitMix(7), prepared.bounds.unwrap(), 40).into_iter().enumerate() {
            one.view(&[view], &mut all).unwrap();
            some.2.clear();
            let report = other.view(&[view], &mut some).unwrap();
            assert_eq!(report.whole, k == 0);
            let sent = some.2.drain(..).filter(|_| k > 0).collect::<Vec<_>>();
            assert!(sent == with(lists, &sent), "{name}, {k}: a list that is not read");
            // Tiles of the first frame have all lists, as the sink is not known when it is asked for.
            assert!(with(lists, &all.batches) == with(lists, &some.1.batches), "{name}, {k}");
            assert_eq!(all.drawn, some.1.drawn);
        }
        let read = |batches: &[Batch]| batches.iter().map(|batch| batch.mesh.bytes()).sum::<usize>();
        assert!(read(&some.1.batches) < read(&all.batches));
    }
}

#[test]
fn a_sink_that_reads_more_than_was_made_is_refused_and_the_next_frame_is_whole() {
    let prepared = shape("torus");
    let views = path(&mut SplitMix(3), prepared.bounds.unwrap(), 4);
    let mut session = Session::start(Arc::clone(&prepared), &SessionOptions::DEFAULT.with_workers(2)).unwrap();
    let mut less = Reader::of(MeshLists::NONE);
    session.view(&views[..1], &mut less).unwrap();
    let mut more = MemorySink::default();
    let error = session.view(&views[1..2], &mut more).unwrap_err();
    let FrameError::Sink(error) = error else { panic!("{error}") };
    assert_eq!(error.cause.kind(), std::io::ErrorKind::InvalidInput, "{error}");
    let report = session.view(&views[1..2], &mut more).unwrap();
    assert!(report.whole && more.batches.iter().all(|batch| batch.mesh.uvs.len() == batch.mesh.positions.len()));
    // A sink that reads less takes what it finds.
    assert!(!session.view(&views[2..3], &mut less).unwrap().whole);
}
