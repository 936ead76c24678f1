//! Rows of buffers on the device, as shaders read them.

use bytemuck::{Pod, Zeroable};

/// Where a vertex is in its tile's lattice: cells and parts of cells from the first u-line and the first v-line.
pub(super) type CellPlace = [f32; 2];

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct Vertex {
    /// Relative to the part's centre, millimetres.
    pub(super) position: [f32; 3],
    /// On the octahedron unfolded to a square, -32767 to 32767.
    pub(super) normal: [i16; 2],
}

/// What a tile of an instance is drawn with: a row of a vertex buffer that the draw's instance number points to.
#[repr(C)]
#[derive(Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub(super) struct Record {
    /// Its top bit says that indices have four bytes.
    pub(super) first_index: u32,
    pub(super) base_vertex: u32,
    pub(super) place: u32,
    pub(super) colour: [u8; 4],
}
