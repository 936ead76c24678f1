//! Triangles of tiles -> bytes in the memory of a sink, by the workers that made them.

use crate::frame::internals::largest_tile;
use crate::mesh::{MeshLists, NotWritten, PartGrid, Scene, TileMemory, TileMesh, VertexLayout, WrittenTile};
use crate::model::{FaceId, PartId, TileId};
use crate::prepare::Prepared;
use glam::{Vec2, Vec3};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Writes tiles in one layout into one memory.
#[derive(Clone)]
pub(super) struct Writer {
    layout: VertexLayout,
    memory: Arc<dyn TileMemory>,
    prepared: Arc<Prepared>,
    /// By part.
    grids: Vec<PartGrid>,
}

impl Writer {
    /// For the parts of `prepared`.
    pub(super) fn new(layout: VertexLayout, memory: Arc<dyn TileMemory>, prepared: &Arc<Prepared>) -> Self {
        let mut writer = Self { layout, memory, prepared: Arc::default(), grids: Vec::new() };
        writer.set_prepared(prepared);
        writer
    }

    /// Replaces the model by the same with more parts.
    pub(super) fn set_prepared(&mut self, prepared: &Arc<Prepared>) {
        self.prepared = Arc::clone(prepared);
        let Prepared { parts, scene: Scene { parts: scene, .. }, .. } = &**prepared;
        for (part, seen) in parts.iter().zip(scene).skip(self.grids.len()) {
            let grid = match seen.mesh_of {
                Some(of) => self.grids[of.index()],
                None => PartGrid::new(seen.centre, seen.radius, largest_tile(part)),
            };
            self.grids.push(grid);
        }
    }

    /// For another model, in the same layout and memory.
    pub(super) fn of_model(&self, prepared: &Arc<Prepared>) -> Self {
        Self::new(self.layout, Arc::clone(&self.memory), prepared)
    }

    pub(super) fn layout(&self) -> VertexLayout {
        self.layout
    }

    /// Writes a tile that `worker` made to the tolerance `chord`.
    pub(super) fn write(
        &self,
        tile: (PartId, FaceId, TileId),
        mesh: &TileMesh,
        (worker, chord): (u32, f64),
    ) -> Result<WrittenTile, NotWritten> {
        let grid = &self.grids[tile.0.index()];
        let new = WrittenTile { worker, ..WrittenTile::gone(tile, self.layout) };
        new.write(mesh, (grid, chord), &|uv| self.tangent(tile.0, tile.1, uv), &*self.memory)
    }

    /// Lists of meshes that the layout is written from.
    pub(super) fn lists(&self) -> MeshLists {
        let VertexLayout { uv, tangent, origin, .. } = self.layout;
        MeshLists { uvs: uv || tangent, lines: false, origins: origin }
    }

    /// The direction in which the natural parameter u increases.
    fn tangent(&self, part: PartId, face: FaceId, uv: Vec2) -> Vec3 {
        let Some(face) = self.prepared.parts[part.index()].face(face) else { return Vec3::ZERO };
        let at = face.to_patches(uv.as_dvec2());
        face.patches.tangents(at.x, at.y)[1].normalize_or_zero().as_vec3()
    }

    /// Gives back the room of tiles that their sink never hears of.
    pub(super) fn release<'a>(&self, tiles: impl Iterator<Item = &'a WrittenTile>) {
        tiles.filter(|tile| tile.triangles > 0).for_each(|tile| self.memory.release(tile));
    }
}

/// Written tiles that the sink has not been told of. Dropping this releases their memory, also in a panic.
#[derive(Default)]
pub(super) struct Rooms {
    writer: Option<Arc<Writer>>,
    tiles: Vec<WrittenTile>,
}

impl Rooms {
    /// None yet, for up to `most` tiles of `writer`. Uses the room of `list`, unless that is far too much.
    pub(super) fn of(writer: Option<&Arc<Writer>>, most: usize, mut list: Vec<WrittenTile>) -> Self {
        list.clear();
        if writer.is_some() {
            list.shrink_to(2 * most);
            list.reserve_exact(most);
        }
        Self { writer: writer.cloned(), tiles: list }
    }

    pub(super) fn push(&mut self, tile: WrittenTile) {
        self.tiles.push(tile);
    }

    /// The tiles, for whoever hands them to the sink or gives their room back.
    pub(super) fn take(&mut self) -> Vec<WrittenTile> {
        std::mem::take(&mut self.tiles)
    }
}

impl Drop for Rooms {
    fn drop(&mut self) {
        if let Some(writer) = &self.writer {
            // A memory that panics here must not end the process, which a second panic would.
            let _ = catch_unwind(AssertUnwindSafe(|| writer.release(self.tiles.iter())));
        }
    }
}
