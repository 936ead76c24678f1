//! Tiles and edges to ranges of buffer pages on the device.

use super::super::error::RenderError;
use super::super::gpu::Gpu;
use super::super::layout::{CellPlace, TileOfVertex, Vertex};
use super::super::palette::rate;
use super::encode::{Encoded, cells};
use super::pages::{Companion, Pages, Range};
use super::staging::Staging;
use crate::mesh::Batch;
use crate::model::FaceId;
use ::wgpu::BufferUsages;
use glam::DVec3;

/// The ranges of a tile on the device, and the properties it may be coloured by.
pub(super) struct StoredTile {
    pub(super) vertices: Range,
    pub(super) corners: Corners,
    pub(super) triangles: u32,
    pub(super) face: FaceId,
    pub(super) worker: u32,
    pub(super) rate: f32,
}

/// Where the indices of a tile are. Three per triangle.
pub(super) enum Corners {
    /// On the device, in two bytes each, or four if `wide`.
    OnDevice { range: Range, wide: bool },
    /// In memory, to be merged with those of other tiles.
    InMemory(Vec<u32>),
}

impl StoredTile {
    /// Page of indices, whether they have four bytes, and the first in units of their width. `None` for those in memory.
    pub(super) fn indices(&self) -> Option<(u32, bool, u32)> {
        match &self.corners {
            Corners::OnDevice { range, wide } => Some((range.page, *wide, range.start() << u32::from(!wide))),
            Corners::InMemory(_) => None,
        }
    }
}

/// The polyline of an edge, relative to the centre of its part.
pub(super) type Line = Vec<[f32; 3]>;

/// Bytes of a pair of indices.
const INDEX_UNIT: u64 = 4;

/// Pages of vertices and indices, with the staging that fills them.
pub(super) struct Store {
    pub(super) vertices: Pages,
    pub(super) indices: Pages,
    pub(super) staging: Staging,
    encoded: Encoded,
    cells: Vec<CellPlace>,
    tile_numbers: Vec<TileOfVertex>,
}

impl Store {
    pub(super) fn new(gpu: &Gpu) -> Self {
        // Wireframes read both as arrays, where they are not merged.
        let readable = if gpu.indirect { BufferUsages::STORAGE } else { BufferUsages::empty() };
        let vertices = Pages::new("vertices", BufferUsages::VERTEX | readable, size_of::<Vertex>() as u64, 1 << 15, 24);
        let per_vertex = (!gpu.indirect).then_some(size_of::<TileOfVertex>() as u64);
        Self {
            vertices: vertices.with(Companion::Tiles, per_vertex),
            indices: Pages::new("indices", BufferUsages::INDEX | readable, INDEX_UNIT, 1 << 16, 48),
            staging: Staging::new(),
            encoded: Encoded::default(),
            cells: Vec::new(),
            tile_numbers: Vec::new(),
        }
    }

    /// Uploads a tile. `None` if it has no triangles. Free it with [`drop_tile`](Self::drop_tile).
    pub(super) fn tile(&mut self, gpu: &Gpu, batch: &Batch, centre: DVec3) -> Result<Option<StoredTile>, RenderError> {
        self.encoded.tile(&batch.mesh, centre, gpu.indirect);
        let Encoded { vertices, indices, triangles, wide } = &self.encoded;
        if *triangles == 0 {
            return Ok(None);
        }
        let count = |n: usize| u32::try_from(n).map_err(|_| RenderError::Device(format!("a tile of {n} vertices")));
        let at = self.vertices.allocate(gpu, count(vertices.len())?)?;
        let corners = if gpu.indirect {
            match count(indices.len()).and_then(|n| self.indices.allocate(gpu, n)) {
                Ok(range) => Corners::OnDevice { range, wide: *wide },
                Err(error) => {
                    self.vertices.free(at);
                    return Err(error);
                }
            }
        } else {
            Corners::InMemory(indices.clone())
        };
        let tile = StoredTile {
            vertices: at,
            corners,
            triangles: *triangles,
            face: batch.face,
            worker: batch.worker,
            rate: rate(batch),
        };
        if let Err(error) = self.send(gpu, batch, &tile) {
            self.drop_tile(tile);
            return Err(error);
        }
        Ok(Some(tile))
    }

    /// Stages what is encoded of a tile.
    fn send(&mut self, gpu: &Gpu, batch: &Batch, tile: &StoredTile) -> Result<(), RenderError> {
        let Self { vertices, indices, staging, encoded, cells: places, tile_numbers } = self;
        let at = &tile.vertices;
        staging.write(gpu, vertices.buffer(at.page), vertices.offset(at), bytemuck::cast_slice(&encoded.vertices))?;
        if let Corners::OnDevice { range, .. } = &tile.corners {
            let bytes = bytemuck::cast_slice(&encoded.indices);
            staging.write(gpu, indices.buffer(range.page), indices.offset(range), bytes)?;
        }
        if let Some((buffer, offset)) = vertices.companion_at(Companion::Tiles, at) {
            tile_numbers.clear();
            tile_numbers.resize(encoded.vertices.len(), batch.tile.0);
            staging.write(gpu, buffer, offset, bytemuck::cast_slice(tile_numbers))?;
        }
        if let Some((buffer, offset)) = vertices.companion_at(Companion::Cells, at) {
            places.clear();
            places.extend(cells(&batch.mesh));
            staging.write(gpu, buffer, offset, bytemuck::cast_slice(places))?;
        }
        Ok(())
    }

    pub(super) fn drop_tile(&mut self, tile: StoredTile) {
        self.vertices.free(tile.vertices);
        if let Corners::OnDevice { range, .. } = tile.corners {
            self.indices.free(range);
        }
    }
}

/// The polyline of an edge. `None` if it has no segments.
pub(super) fn line(points: &[DVec3], centre: DVec3) -> Option<Line> {
    (points.len() > 1).then(|| points.iter().map(|&point| (point - centre).as_vec3().to_array()).collect())
}
