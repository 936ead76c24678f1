//! Batches -> the bytes that a renderer would upload and hold. Stores sizes, not meshes.

use trimtess::mesh::{Batch, EdgeLine, MeshLists, MeshSink, Scene, SinkError};
use trimtess::model::{PartId, TileId};
use trimtess::prepare::Prepared;

/// Position relative to the part as three f32, and a packed normal.
const BYTES_PER_VERTEX: u64 = 16;
/// Three u32.
const BYTES_PER_TRIANGLE: u64 = 12;

/// Size of a batch, or of several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Size {
    pub(super) triangles: u64,
    pub(super) bytes: u64,
}

/// A sink that only counts.
pub(super) struct Uploads {
    /// Index of each part's first tile among all tiles.
    starts: Vec<usize>,
    held: Vec<Size>,
    /// Tiles sent in this frame.
    pub(super) sent: Vec<(PartId, TileId)>,
    /// Bytes sent in this frame.
    pub(super) uploaded: u64,
}

impl Uploads {
    /// Creates a sink for frames of a model.
    pub(super) fn of(prepared: &Prepared) -> Self {
        let mut starts = vec![0];
        for part in &prepared.parts {
            starts.push(starts[starts.len() - 1] + part.tiles.len());
        }
        let held = vec![Size::default(); starts[starts.len() - 1]];
        Self { starts, held, sent: Vec::new(), uploaded: 0 }
    }

    /// Resets the counts of the frame. Needed because frames that change nothing do not call the sink.
    pub(super) fn next_frame(&mut self) {
        self.sent.clear();
        self.uploaded = 0;
    }

    /// Number of tiles.
    pub(super) fn tiles(&self) -> usize {
        self.held.len()
    }

    /// Index of a tile among all tiles.
    pub(super) fn tile(&self, part: PartId, tile: TileId) -> usize {
        self.starts[part.index()] + tile.0 as usize
    }

    /// Total size of all tiles after the last frame.
    pub(super) fn held(&self) -> Size {
        let add = |a: Size, b: &Size| Size { triangles: a.triangles + b.triangles, bytes: a.bytes + b.bytes };
        self.held.iter().fold(Size::default(), add)
    }
}

impl MeshSink for Uploads {
    fn reads(&self) -> MeshLists {
        MeshLists::NONE
    }

    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.held.fill(Size::default());
        self.begin_changes(scene)
    }

    fn begin_changes(&mut self, _: &Scene) -> Result<(), SinkError> {
        Ok(())
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        let (vertices, triangles) = (batch.mesh.positions.len() as u64, batch.mesh.triangles.len() as u64);
        let bytes = vertices * BYTES_PER_VERTEX + triangles * BYTES_PER_TRIANGLE;
        let tile = self.tile(batch.part, batch.tile);
        self.held[tile] = Size { triangles, bytes };
        self.sent.push((batch.part, batch.tile));
        self.uploaded += bytes;
        Ok(())
    }

    fn edge_line(&mut self, _: EdgeLine) -> Result<(), SinkError> {
        Ok(())
    }

    fn end(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    fn abort(&mut self) {
        self.held.fill(Size::default());
    }
}
