//! A sink for benches of what comes before the sink.

use std::hint::black_box;
use std::slice::Iter;
use trimtess::mesh::{Batch, MeshSink, Scene, SceneChanges, SinkError, WrittenTile};

/// Accepts everything and keeps nothing.
pub(crate) struct Nowhere;

impl MeshSink for Nowhere {
    fn begin(&mut self, _: &Scene) -> Result<(), SinkError> {
        Ok(())
    }

    fn begin_changes(&mut self, _: &Scene, _: &SceneChanges<'_>) -> Result<(), SinkError> {
        Ok(())
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        black_box(&batch.mesh);
        Ok(())
    }

    fn written(&mut self, tiles: &mut Iter<'_, WrittenTile>) -> Result<(), SinkError> {
        tiles.for_each(|tile| _ = black_box(tile));
        Ok(())
    }
}
