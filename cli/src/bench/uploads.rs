//! Tiles -> the bytes that a renderer would upload and hold. Stores sizes, not meshes.

use std::slice::Iter;
use std::sync::{Arc, Mutex, PoisonError};
use trimtess::mesh::{Batch, EdgeLine, MeshLists, MeshSink, Scene, SinkError, TileMemory, VertexLayout, WrittenTile};
use trimtess::model::{PartId, TileId};
use trimtess::parallel::Session;
use trimtess::prepare::Prepared;

/// Position relative to the part as three f32, and a packed normal.
const BYTES_PER_VERTEX: usize = 16;
/// Three u32.
const BYTES_PER_TRIANGLE: usize = 12;

/// Size of a batch, or of several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Size {
    pub(super) triangles: u64,
    pub(super) bytes: u64,
}

/// Staging memory of a renderer: one block per worker. Each frame overwrites it.
struct Staging(Vec<Mutex<Block>>);

#[derive(Default)]
struct Block {
    bytes: Vec<u8>,
    used: usize,
}

impl Staging {
    fn next_frame(&self) {
        self.0.iter().for_each(|block| block.lock().unwrap_or_else(PoisonError::into_inner).used = 0);
    }
}

impl TileMemory for Staging {
    fn write(&self, tile: &WrittenTile, fill: &mut dyn FnMut(&mut [u8], &mut [u8])) -> Result<u64, SinkError> {
        let mut block = self.0[tile.worker as usize].lock().unwrap_or_else(PoisonError::into_inner);
        let Block { bytes, used } = &mut *block;
        let place = *used;
        *used += tile.vertex_bytes() + tile.index_bytes();
        if bytes.len() < *used {
            bytes.resize(2 * *used, 0);
        }
        let (vertices, indices) = bytes[place..*used].split_at_mut(tile.vertex_bytes());
        fill(vertices, indices);
        Ok(place as u64)
    }

    fn release(&self, _: &WrittenTile) {}
}

/// A sink that only counts.
pub(super) struct Uploads {
    /// Index of each part's first tile among all tiles.
    starts: Vec<usize>,
    /// Triangles and bytes of each tile.
    held: Vec<[u32; 2]>,
    /// Where workers write vertices, if they do.
    staging: Option<Arc<Staging>>,
    /// Batches sent in this frame.
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
        let held = vec![[0; 2]; starts[starts.len() - 1]];
        Self { starts, held, staging: None, sent: Vec::new(), uploaded: 0 }
    }

    /// Creates a sink for frames of a session whose workers write vertices of this layout into its memory.
    pub(super) fn written_by(session: &mut Session, layout: VertexLayout) -> Self {
        let staging = Arc::new(Staging((0..session.workers()).map(|_| Mutex::default()).collect()));
        session.write_into(layout, Arc::<Staging>::clone(&staging));
        Self { staging: Some(staging), ..Self::of(session.prepared()) }
    }

    /// Resets the counts of the frame. Needed because frames that change nothing do not call the sink.
    pub(super) fn next_frame(&mut self) {
        self.sent.clear();
        self.uploaded = 0;
        self.staging.iter().for_each(|staging| staging.next_frame());
    }

    fn hold(&mut self, part: PartId, tile: TileId, [triangles, bytes]: [usize; 2]) {
        let row = self.tile(part, tile);
        self.held[row] = [triangles as u32, bytes as u32];
        self.uploaded += bytes as u64;
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
        let [triangles, bytes] = [0, 1].map(|k| self.held.iter().map(|tile| u64::from(tile[k])).sum());
        Size { triangles, bytes }
    }
}

impl MeshSink for Uploads {
    fn reads(&self) -> MeshLists {
        MeshLists::NONE
    }

    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.held.fill([0; 2]);
        self.begin_changes(scene)
    }

    fn begin_changes(&mut self, _: &Scene) -> Result<(), SinkError> {
        Ok(())
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        let (vertices, triangles) = (batch.mesh.positions.len(), batch.mesh.triangles.len());
        let bytes = vertices * BYTES_PER_VERTEX + triangles * BYTES_PER_TRIANGLE;
        self.hold(batch.part, batch.tile, [triangles, bytes]);
        self.sent.push((batch.part, batch.tile));
        Ok(())
    }

    fn written(&mut self, tiles: &mut Iter<'_, WrittenTile>) -> Result<(), SinkError> {
        for tile in tiles {
            self.hold(tile.part, tile.tile, [tile.triangles as usize, tile.vertex_bytes() + tile.index_bytes()]);
        }
        Ok(())
    }

    fn edge_line(&mut self, _: EdgeLine) -> Result<(), SinkError> {
        Ok(())
    }

    fn end(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    fn abort(&mut self) {
        self.held.fill([0; 2]);
    }
}
