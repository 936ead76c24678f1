//! Tiles and edges to ranges of buffer pages on the device.

use super::super::error::RenderError;
use super::super::gpu::Gpu;
use super::super::layout::{CellPlace, Vertex};
use super::super::palette::rate;
use super::encode::{Encoded, cells};
use super::pages::{Pages, Range};
use super::staging::Staging;
use crate::mesh::Batch;
use crate::model::FaceId;
use ::wgpu::BufferUsages;
use glam::DVec3;

/// The ranges of a tile on the device, and the properties it may be coloured by.
#[derive(Clone, Copy)]
pub(super) struct StoredTile {
    pub(super) vertices: Range,
    pub(super) indices: Range,
    pub(super) triangles: u32,
    /// Whether indices have four bytes.
    pub(super) wide: bool,
    pub(super) face: FaceId,
    pub(super) worker: u32,
    pub(super) rate: f32,
}

impl StoredTile {
    /// The first index, in units of the tile's index width.
    pub(super) fn first_index(&self) -> u32 {
        self.indices.start() << u32::from(!self.wide)
    }
}

/// The range of an edge's polyline.
#[derive(Clone, Copy)]
pub(super) struct Line {
    pub(super) points: Range,
    pub(super) segments: u32,
}

/// Bytes of a pair of indices.
const INDEX_UNIT: u64 = 4;
/// Bytes of a point of an edge.
const POINT_UNIT: u64 = 12;

/// Pages of vertices, indices and edge points, with the staging that fills them.
pub(super) struct Store {
    pub(super) vertices: Pages,
    pub(super) indices: Pages,
    pub(super) points: Pages,
    pub(super) staging: Staging,
    encoded: Encoded,
    line: Vec<[f32; 3]>,
    cells: Vec<CellPlace>,
}

impl Store {
    pub(super) fn new() -> Self {
        let readable = BufferUsages::STORAGE;
        Self {
            vertices: Pages::new("vertices", BufferUsages::VERTEX | readable, size_of::<Vertex>() as u64, 1 << 15, 24),
            indices: Pages::new("indices", BufferUsages::INDEX | readable, INDEX_UNIT, 1 << 16, 48),
            points: Pages::new("edge points", readable, POINT_UNIT, 1 << 13, 8),
            staging: Staging::new(),
            encoded: Encoded::default(),
            line: Vec::new(),
            cells: Vec::new(),
        }
    }

    /// Turns lattice positions of vertices on or off. Vertices already stored have none until they are sent again.
    pub(super) fn keep_cells(&mut self, gpu: &Gpu, keep: bool) -> Result<(), RenderError> {
        self.vertices.keep_beside(gpu, keep.then_some(size_of::<CellPlace>() as u64))
    }

    /// Uploads a tile. `None` if it has no triangles. Free it with [`drop_tile`](Self::drop_tile).
    pub(super) fn tile(&mut self, gpu: &Gpu, batch: &Batch, centre: DVec3) -> Result<Option<StoredTile>, RenderError> {
        self.encoded.tile(&batch.mesh, centre);
        let Encoded { vertices, indices, triangles, wide } = &self.encoded;
        if *triangles == 0 {
            return Ok(None);
        }
        let count = |n: usize| u32::try_from(n).map_err(|_| RenderError::Device(format!("a tile of {n} vertices")));
        let at = self.vertices.allocate(gpu, count(vertices.len())?)?;
        let indices_at = match count(indices.len()).and_then(|n| self.indices.allocate(gpu, n)) {
            Ok(range) => range,
            Err(error) => {
                self.vertices.free(at);
                return Err(error);
            }
        };
        let tile = StoredTile {
            vertices: at,
            indices: indices_at,
            triangles: *triangles,
            wide: *wide,
            face: batch.face,
            worker: batch.worker,
            rate: rate(batch),
        };
        let bytes = bytemuck::cast_slice(vertices);
        let written =
            self.staging.write(gpu, self.vertices.buffer(at.page), self.vertices.offset(&at), bytes).and_then(|()| {
                let bytes = bytemuck::cast_slice(indices);
                self.staging.write(gpu, self.indices.buffer(indices_at.page), self.indices.offset(&indices_at), bytes)
            });
        let written = written.and_then(|()| {
            let Some((buffer, offset)) = self.vertices.beside(&at) else { return Ok(()) };
            self.cells.clear();
            self.cells.extend(cells(&batch.mesh));
            self.staging.write(gpu, buffer, offset, bytemuck::cast_slice(&self.cells))
        });
        if let Err(error) = written {
            self.drop_tile(tile);
            return Err(error);
        }
        Ok(Some(tile))
    }

    /// Uploads the polyline of an edge. `None` if it has no segments. Free it with [`drop_line`](Self::drop_line).
    pub(super) fn line(&mut self, gpu: &Gpu, points: &[DVec3], centre: DVec3) -> Result<Option<Line>, RenderError> {
        if points.len() < 2 {
            return Ok(None);
        }
        self.line.clear();
        self.line.extend(points.iter().map(|&point| (point - centre).as_vec3().to_array()));
        let units = u32::try_from(points.len());
        let units = units.map_err(|_| RenderError::Device(format!("an edge of {} points", points.len())))?;
        let at = self.points.allocate(gpu, units)?;
        let bytes = bytemuck::cast_slice(&self.line);
        if let Err(error) = self.staging.write(gpu, self.points.buffer(at.page), self.points.offset(&at), bytes) {
            self.points.free(at);
            return Err(error);
        }
        Ok(Some(Line { points: at, segments: units - 1 }))
    }

    pub(super) fn drop_tile(&mut self, tile: StoredTile) {
        self.vertices.free(tile.vertices);
        self.indices.free(tile.indices);
    }

    pub(super) fn drop_line(&mut self, line: Line) {
        self.points.free(line.points);
    }
}
