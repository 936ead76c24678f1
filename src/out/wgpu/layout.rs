//! Layout of vertex buffers on the device.

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
}
