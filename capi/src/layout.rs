//! How vertices and indices lie in the caller's memory.

use crate::border::{Caller, entry, versioned};
use crate::limits::choice;
use crate::status::{Failure, tt_status};
use trimtess::mesh::{IndexFormat, NormalFormat, PositionFormat, VertexLayout};

/// Format of positions. Equal positions of a part are equal in every tile, so borders stay closed.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum tt_position {
    /// 3 floats, relative to the part's centre, millimetres: 12 bytes.
    TT_POSITION_F32 = 0,
    /// 3 doubles, part coordinates, millimetres: 24 bytes.
    TT_POSITION_F64 = 1,
    /// 4 unsigned integers of 16 bits, the last one 0: steps from the tile's corner, see `tt_tile`. 8 bytes. A frame is
    /// refused with TT_ERROR_GRID if rounding would take more than a tenth of its tolerance.
    TT_POSITION_GRID = 2,
}

/// Format of normals.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum tt_normal {
    /// 2 normalised integers of 16 bits: octahedral coordinates, off by less than 0.01 degrees. 4 bytes.
    TT_NORMAL_OCTAHEDRAL = 0,
    /// 3 floats: 12 bytes.
    TT_NORMAL_F32 = 1,
    /// None.
    TT_NORMAL_NONE = 2,
}

/// Attributes of a vertex, in this order, little-endian, without gaps. Zeros are 16 bytes per vertex: f32 positions and
/// octahedral normals, with indices of 16 bits where they suffice.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_layout {
    /// `sizeof(tt_layout)`.
    pub size: u32,
    /// A `tt_position`.
    pub position: u32,
    /// A `tt_normal`.
    pub normal: u32,
    /// 1 adds parameters: 2 floats, in the natural parameters of the face's surface.
    pub uv: u32,
    /// 1 adds a tangent: 3 floats, of unit length, in the direction in which u increases; zero where that has none.
    pub tangent: u32,
    /// 1 adds where the vertex comes from: 3 unsigned integers of 32 bits. The first is 0 for a lattice point (line of
    /// u, line of v), 1 for a point of an edge (edge, index along it), 2 for a crossing of boundaries, 3 for a point
    /// within, 4 for a border between tiles (border, index along it).
    pub origin: u32,
    /// 1 makes all indices 32 bits wide; 0 only those of tiles with more than 65535 vertices. So no index of 16 bits is
    /// 65535, at which WebGL 2 restarts primitives.
    pub wide_indices: u32,
    /// 0.
    pub reserved: u32,
}
versioned!(tt_layout, reserved);

pub(crate) fn layout(c: &Caller, from: *const tt_layout) -> Result<VertexLayout, Failure> {
    let from = c.read_or_zeros("layout", from)?;
    let position = choice!("format of positions", from.position, tt_position {
        TT_POSITION_F32 => PositionFormat::F32,
        TT_POSITION_F64 => PositionFormat::F64,
        TT_POSITION_GRID => PositionFormat::Grid,
    });
    let normal = choice!("format of normals", from.normal, tt_normal {
        TT_NORMAL_OCTAHEDRAL => NormalFormat::Octahedral,
        TT_NORMAL_F32 => NormalFormat::F32,
        TT_NORMAL_NONE => NormalFormat::None,
    });
    let index = if from.wide_indices != 0 { IndexFormat::U32 } else { IndexFormat::Smallest };
    let layout = VertexLayout::COMPACT.with_position(position).with_normal(normal).with_index(index);
    Ok(layout.with_uv(from.uv != 0).with_tangent(from.tangent != 0).with_origin(from.origin != 0))
}

/// Bytes from one vertex to the next.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_layout_get_stride(layout: *const tt_layout, stride: *mut u32) -> tt_status {
    entry!(c => {
        let out = c.out("stride", stride)?;
        out.give(self::layout(c, layout)?.stride() as u32);
        Ok(())
    })
}
