//! Layout of vertex buffers on the device.

use ::wgpu::{VertexAttribute, VertexBufferLayout, VertexStepMode, vertex_attr_array};
use bytemuck::{Pod, Zeroable};

/// Position of a vertex in its tile's lattice, in (fractional) cells from the first u-line and the first v-line.
pub(super) type CellPlace = [f32; 2];

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct Vertex {
    /// Relative to the part's centre, millimetres.
    pub(super) position: [f32; 3],
    /// Octahedral encoding, -32767 to 32767.
    pub(super) normal: [i16; 2],
}

/// Number of a vertex's tile within its part. On devices that merge tiles only.
pub(super) type TileOfVertex = u32;

/// Per-draw data of one tile of one instance, in a vertex buffer indexed by the draw's instance number.
#[repr(C)]
#[derive(Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub(super) struct Record {
    /// First index. The top bit is set if indices have four bytes.
    pub(super) first_index: u32,
    pub(super) base_vertex: u32,
    pub(super) place: u32,
    pub(super) colour: [u8; 4],
    /// The face within the part.
    pub(super) face: u32,
}

const VERTEX: [VertexAttribute; 2] = vertex_attr_array![0 => Float32x3, 1 => Snorm16x2];
const RECORD: [VertexAttribute; 5] =
    vertex_attr_array![5 => Uint32, 6 => Uint32, 2 => Uint32, 3 => Unorm8x4, 4 => Uint32];
/// Without what only lines read.
const RECORD_OF_SURFACE: [VertexAttribute; 3] = [RECORD[2], RECORD[3], RECORD[4]];
const TILE: [VertexAttribute; 1] = vertex_attr_array![2 => Uint32];
const CELL: [VertexAttribute; 1] = vertex_attr_array![7 => Float32x2];

/// Layout of a page of vertices.
pub(super) const VERTICES: VertexBufferLayout<'static> = per_vertex(size_of::<Vertex>(), &VERTEX);
/// Layout of the records.
pub(super) const RECORDS: VertexBufferLayout<'static> =
    VertexBufferLayout { step_mode: VertexStepMode::Instance, ..per_vertex(size_of::<Record>(), &RECORD) };
/// Layout of the records where surfaces are drawn.
pub(super) const SURFACE_RECORDS: VertexBufferLayout<'static> =
    VertexBufferLayout { step_mode: VertexStepMode::Instance, ..per_vertex(size_of::<Record>(), &RECORD_OF_SURFACE) };
/// Layout of the numbers of tiles next to a page of vertices.
pub(super) const TILES: VertexBufferLayout<'static> = per_vertex(size_of::<TileOfVertex>(), &TILE);
/// Layout of the places in the lattice next to a page of vertices.
pub(super) const CELLS: VertexBufferLayout<'static> = per_vertex(size_of::<CellPlace>(), &CELL);

const fn per_vertex(bytes: usize, attributes: &'static [VertexAttribute]) -> VertexBufferLayout<'static> {
    VertexBufferLayout { array_stride: bytes as u64, step_mode: VertexStepMode::Vertex, attributes }
}
