//! A sink and a pool that count what they are asked for.

use std::sync::atomic::{AtomicUsize, Ordering};
use trimtess::control::{Job, Jobs, Priority, Threads};
use trimtess::mesh::{Batch, DrawnTiles, EdgeLine, MemorySink, MeshSink, Scene, SceneChanges, SinkError};
use trimtess::model::PartId;

/// A sink in memory that counts frames and bytes, and refuses them on request.
#[derive(Default)]
pub(crate) struct Counting {
    pub(crate) sink: MemorySink,
    pub(crate) frames: usize,
    /// Bytes of the tiles that were sent.
    pub(crate) sent: u64,
    pub(crate) refuses: bool,
}

impl MeshSink for Counting {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.frames += 1;
        self.sink.begin(scene)
    }
    fn begin_changes(&mut self, scene: &Scene, changes: &SceneChanges<'_>) -> Result<(), SinkError> {
        self.frames += 1;
        self.sink.begin_changes(scene, changes)
    }
    fn begin_update(
        &mut self,
        scene: &Scene,
        changes: &SceneChanges<'_>,
        from: &[Option<PartId>],
    ) -> Result<(), SinkError> {
        self.frames += 1;
        self.sink.begin_update(scene, changes, from)
    }
    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        self.sent += batch.mesh.bytes() as u64;
        self.sink.batch(batch)
    }
    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError> {
        self.sink.edge_line(line)
    }
    fn drawn(&mut self, drawn: &DrawnTiles, before: &DrawnTiles) -> Result<(), SinkError> {
        if self.refuses {
            return Err(SinkError::new("memory", std::io::Error::other("full")));
        }
        self.sink.drawn(drawn, before)
    }
    fn end(&mut self) -> Result<(), SinkError> {
        self.sink.end()
    }
    fn abort(&mut self) {
        self.sink.abort();
    }
}

/// Threads, and the number of jobs that they were given.
pub(crate) struct CountedJobs(pub(crate) Threads, pub(crate) AtomicUsize);

impl Jobs for CountedJobs {
    fn width(&self) -> usize {
        self.0.width()
    }

    fn spawn(&self, priority: Priority, job: Job) {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.spawn(priority, job);
    }
}
