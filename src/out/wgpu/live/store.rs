//! Tiles to bytes, and to ranges of buffers on the device. A vertex has 16 bytes (octahedral normals, Meyer et al.), an
//! index 2 in tiles of up to 65535 vertices, else 4. Small writes to many buffers are gathered to one upload.

use super::super::gpu::{Gpu, RenderError};
use super::super::palette::rate;
use super::super::pipelines::{CellPlace, TileOfVertex, Vertex};
use super::pages::{Companion, Pages, Range};
use crate::mesh::{Batch, SHORT_VERTICES, TileMesh, octahedral};
use crate::model::FaceId;
use ::wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoderDescriptor};
use glam::DVec3;

/// Encoded tile. The buffers are reused.
#[derive(Default)]
struct Encoded {
    vertices: Vec<Vertex>,
    /// Pairs of two-byte indices, the first in the lower half (the last upper half may be unused), or indices of four
    /// bytes.
    indices: Vec<u32>,
    triangles: u32,
    /// Whether indices have four bytes.
    wide: bool,
}

impl Encoded {
    /// Encodes `mesh` with positions relative to `centre`. Triangles with a missing vertex are skipped. Indices are in
    /// `pairs` where they fit.
    fn tile(&mut self, mesh: &TileMesh, centre: DVec3, pairs: bool) {
        let count = mesh.positions.len();
        self.vertices.clear();
        self.vertices.extend(mesh.positions.iter().enumerate().map(|(index, &position)| Vertex {
            position: (position - centre).as_vec3().to_array(),
            normal: octahedral(mesh.normals.get(index).copied().unwrap_or_default()),
        }));
        self.indices.clear();
        self.wide = !pairs || count > SHORT_VERTICES;
        let sound = mesh.triangles.iter().filter(|corners| corners.iter().all(|&corner| (corner as usize) < count));
        let mut corners = sound.flatten().copied();
        if self.wide {
            self.indices.extend(corners);
            self.triangles = (self.indices.len() / 3) as u32;
            return;
        }
        let mut written = 0;
        while let Some(low) = corners.next() {
            let high = corners.next();
            written += 1 + u32::from(high.is_some());
            self.indices.push(low | high.unwrap_or(0) << 16);
        }
        self.triangles = written / 3;
    }
}

/// Lattice positions of a tile's vertices; all zero if the tile has no lattice.
fn cells(mesh: &TileMesh) -> impl Iterator<Item = CellPlace> {
    let at = |lines: &[f32], x: f32| {
        let upwards = lines.first() <= lines.last();
        let below = lines.partition_point(|&line| if upwards { line <= x } else { line >= x });
        let Some(cell) = below.clamp(1, lines.len().max(2) - 1).checked_sub(1) else { return 0.0 };
        let (Some(low), Some(high)) = (lines.get(cell), lines.get(cell + 1)) else { return 0.0 };
        cell as f32 + ((x - low) / (high - low)).clamp(0.0, 1.0)
    };
    (0..mesh.positions.len()).map(move |k| {
        let uv = mesh.uvs.get(k).copied().unwrap_or_default();
        [at(&mesh.lines[0], uv.x), at(&mesh.lines[1], uv.y)]
    })
}

/// Bytes gathered before a flush: some hundred tiles.
const CAPACITY: usize = 1 << 18;

/// Gathers writes in memory, uploads them to one buffer on the device, and copies them from there.
///
/// `Queue::write_buffer` allocates a staging buffer per call, which would cost more than the tile it uploads.
pub(super) struct Staging {
    inbox: Option<Buffer>,
    bytes: Vec<u8>,
    copies: Vec<Copy>,
    /// Bytes submitted since the last frame.
    pub(super) count: u64,
}

struct Copy {
    to: Buffer,
    offset: u64,
    size: u64,
}

impl Staging {
    pub(super) fn new() -> Self {
        Self { inbox: None, bytes: Vec::new(), copies: Vec::new(), count: 0 }
    }

    /// Queues a write of `bytes` to `offset` of a buffer. Offset and length must be multiples of 4.
    pub(super) fn write(&mut self, gpu: &Gpu, to: &Buffer, offset: u64, bytes: &[u8]) -> Result<(), RenderError> {
        let mut at = offset;
        for piece in bytes.chunks(CAPACITY) {
            if self.bytes.len() + piece.len() > CAPACITY {
                self.flush(gpu)?;
            }
            self.bytes.extend_from_slice(piece);
            let size = piece.len() as u64;
            match self.copies.last_mut() {
                Some(last) if last.offset + last.size == at && last.to == *to => last.size += size,
                _ => self.copies.push(Copy { to: to.clone(), offset: at, size }),
            }
            at += size;
        }
        Ok(())
    }

    /// Submits all queued writes.
    pub(super) fn flush(&mut self, gpu: &Gpu) -> Result<(), RenderError> {
        if self.bytes.is_empty() {
            return Ok(());
        }
        let copies = std::mem::take(&mut self.copies);
        let flushed = gpu.checked(|device| {
            let inbox = self.inbox.get_or_insert_with(|| {
                device.create_buffer(&BufferDescriptor {
                    label: Some("trimtess inbox"),
                    size: CAPACITY as u64,
                    usage: BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            });
            gpu.queue.write_buffer(inbox, 0, &self.bytes);
            let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
            let mut from = 0;
            for copy in &copies {
                encoder.copy_buffer_to_buffer(inbox, from, &copy.to, copy.offset, copy.size);
                from += copy.size;
            }
            gpu.queue.submit([encoder.finish()]);
        });
        self.count += self.bytes.len() as u64;
        self.bytes.clear();
        if flushed.is_err() {
            // It may be the buffer that failed.
            self.inbox = None;
        }
        flushed
    }

    /// Drops all queued writes, and counts from 0.
    pub(super) fn discard(&mut self) {
        self.bytes.clear();
        self.copies.clear();
        self.count = 0;
    }

    /// Size of the buffer on the device, in bytes.
    pub(super) fn held(&self) -> u64 {
        self.inbox.as_ref().map_or(0, Buffer::size)
    }
}

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
    /// Page of indices, whether they have four bytes, and the first in units of their width. `None` for those in
    /// memory.
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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn lattice_positions_count_cells() {
        let uvs = [[0.0, 5.0], [1.0, 4.0], [2.0, 2.0], [10.0, 1.0], [11.0, 0.0]].map(Vec2::from).to_vec();
        let lines = [vec![0.0, 2.0, 10.0], vec![5.0, 3.0, 1.0]];
        let mesh = TileMesh { positions: vec![DVec3::ZERO; 5], uvs, lines, ..TileMesh::default() };
        let places: Vec<CellPlace> = cells(&mesh).collect();
        assert_eq!(places, [[0.0, 0.0], [0.5, 0.5], [1.0, 1.5], [2.0, 2.0], [2.0, 2.0]]);
        let without = TileMesh { lines: [vec![1.0], Vec::new()], ..mesh };
        assert_eq!(cells(&without).collect::<Vec<_>>(), [[0.0; 2]; 5]);
    }

    #[test]
    fn indices_are_packed_in_pairs_and_bad_triangles_skipped() {
        let mut encoded = Encoded::default();
        let mut mesh = TileMesh { positions: vec![DVec3::ONE; 4], ..TileMesh::default() };
        mesh.triangles = vec![[0, 1, 2], [1, 2, 4], [3, 2, 1], [0, 2, 3]];
        encoded.tile(&mesh, DVec3::ONE, true);
        assert_eq!((encoded.triangles, encoded.wide, encoded.vertices.len()), (3, false, 4));
        assert_eq!(encoded.indices, [0x1_0000, 0x3_0002, 0x1_0002, 0x2_0000, 3]);
        assert_eq!(encoded.vertices[0].position, [0.0; 3]);
        mesh.positions = vec![DVec3::ONE; 65_535];
        mesh.triangles = vec![[0, 1, 65_534]];
        encoded.tile(&mesh, DVec3::ZERO, true);
        assert_eq!((&encoded.indices[..], encoded.triangles, encoded.wide), (&[0x1_0000, 65_534][..], 1, false));
        mesh.positions.push(DVec3::ONE);
        mesh.triangles = vec![[0, 1, 65_535]];
        encoded.tile(&mesh, DVec3::ZERO, true);
        assert_eq!((&encoded.indices[..], encoded.triangles, encoded.wide), (&[0, 1, 65_535][..], 1, true));
        assert_eq!(size_of::<Vertex>(), 16);
        mesh.positions.truncate(4);
        mesh.triangles = vec![[0, 1, 2]];
        encoded.tile(&mesh, DVec3::ZERO, false);
        assert_eq!((&encoded.indices[..], encoded.triangles, encoded.wide), (&[0, 1, 2][..], 1, true));
    }
}
