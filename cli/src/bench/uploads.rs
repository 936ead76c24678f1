//! Tiles -> the bytes that a renderer would upload and hold. Stores sizes, not meshes.

use std::slice::Iter;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use trimtess::mesh::{
    Batch, MeshLists, MeshSink, Scene, SceneChanges, SinkError, TileMemory, VertexLayout, WrittenTile,
};
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
    /// The tiles in it. Workers list them, as those of a renderer list draws.
    draws: Vec<Draw>,
}

/// A tile in the staging memory.
struct Draw {
    part: PartId,
    tile: TileId,
    size: [u32; 2],
}

impl Staging {
    fn blocks(&self) -> impl Iterator<Item = MutexGuard<'_, Block>> {
        self.0.iter().map(|block| block.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn next_frame(&self) {
        self.blocks().for_each(|mut block| {
            block.used = 0;
            block.draws.clear();
        });
    }
}

/// Triangles and bytes of a tile.
fn size(tile: &WrittenTile) -> [u32; 2] {
    [tile.triangles, (tile.vertex_bytes() + tile.index_bytes()) as u32]
}

impl TileMemory for Staging {
    fn write(&self, tile: &WrittenTile, fill: &mut dyn FnMut(&mut [u8], &mut [u8])) -> Result<u64, SinkError> {
        let mut block = self.0[tile.worker as usize].lock().unwrap_or_else(PoisonError::into_inner);
        let Block { bytes, used, draws } = &mut *block;
        let (place, size) = (*used, size(tile));
        *used += size[1] as usize;
        draws.push(Draw { part: tile.part, tile: tile.tile, size });
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
    /// Triangles and bytes of each tile, but of those of a whole frame that workers wrote. Empty if it holds none.
    held: Vec<[u32; 2]>,
    /// Those, by worker, until the first frame of changes.
    lists: Vec<Vec<Draw>>,
    /// Whether the frame in progress is whole.
    whole: bool,
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
        for part in prepared.parts.iter() {
            starts.push(starts[starts.len() - 1] + part.tiles.len());
        }
        Self { starts, held: Vec::new(), lists: Vec::new(), whole: false, staging: None, sent: Vec::new(), uploaded: 0 }
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

    fn hold(&mut self, part: PartId, tile: TileId, size: [u32; 2]) {
        let row = self.tile(part, tile);
        self.held[row] = size;
        self.uploaded += u64::from(size[1]);
    }

    fn forget(&mut self) {
        self.held.clear();
        self.lists.iter_mut().for_each(Vec::clear);
    }

    pub(super) fn tiles(&self) -> usize {
        self.starts[self.starts.len() - 1]
    }

    /// Index of a tile among all tiles.
    pub(super) fn tile(&self, part: PartId, tile: TileId) -> usize {
        self.starts[part.index()] + tile.0 as usize
    }

    /// Total size of all tiles after the last frame.
    pub(super) fn held(&self) -> Size {
        let sizes = || self.held.iter().chain(self.lists.iter().flatten().map(|draw| &draw.size));
        let [triangles, bytes] = [0, 1].map(|k| sizes().map(|size| u64::from(size[k])).sum());
        Size { triangles, bytes }
    }
}

impl MeshSink for Uploads {
    fn reads(&self) -> MeshLists {
        MeshLists::NONE
    }

    fn begin(&mut self, _: &Scene) -> Result<(), SinkError> {
        self.forget();
        self.whole = true;
        if self.staging.is_none() {
            self.held.resize(self.tiles(), [0; 2]);
        }
        Ok(())
    }

    fn begin_changes(&mut self, _: &Scene, _: &SceneChanges<'_>) -> Result<(), SinkError> {
        self.whole = false;
        self.held.resize(self.tiles(), [0; 2]);
        let Self { starts, held, lists, .. } = self;
        for Draw { part, tile, size } in lists.iter_mut().flat_map(|list| list.drain(..)) {
            held[starts[part.index()] + tile.0 as usize] = size;
        }
        Ok(())
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        let (vertices, triangles) = (batch.mesh.positions.len(), batch.mesh.triangles.len());
        let bytes = vertices * BYTES_PER_VERTEX + triangles * BYTES_PER_TRIANGLE;
        self.hold(batch.part, batch.tile, [triangles as u32, bytes as u32]);
        self.sent.push((batch.part, batch.tile));
        Ok(())
    }

    fn written(&mut self, tiles: &mut Iter<'_, WrittenTile>) -> Result<(), SinkError> {
        if self.whole {
            // The blocks list them.
            *tiles = [].iter();
        }
        tiles.for_each(|tile| self.hold(tile.part, tile.tile, size(tile)));
        Ok(())
    }

    fn end(&mut self) -> Result<(), SinkError> {
        if let (true, Some(staging)) = (self.whole, &self.staging) {
            self.lists.resize_with(staging.0.len(), Vec::new);
            for (list, mut block) in self.lists.iter_mut().zip(staging.blocks()) {
                self.uploaded += block.used as u64;
                std::mem::swap(list, &mut block.draws);
            }
        }
        Ok(())
    }

    fn abort(&mut self) {
        self.forget();
    }
}
