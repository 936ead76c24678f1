//! Tiles in the caller's memory: workers ask for room, and write vertices and indices into it.

use crate::border::{Caller, User, lend, versioned, zeros};
use crate::status::Failure;
use std::ffi::c_void;
use std::ptr;
use trimtess::mesh::{SinkError, TileMemory, WrittenTile};

/// A tile, as callbacks get it. Pointers are valid until the callback returns.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_tile {
    /// `sizeof(tt_tile)` of the library.
    pub size: u32,
    /// The part, or the level of detail of one, see `tt_scene`.
    pub part: u32,
    /// The face within the part.
    pub face: u32,
    /// The tile within the part.
    pub tile: u32,
    /// The worker that made it, from 0. This and `place` alone depend on who works.
    pub worker: u32,
    /// Number of vertices.
    pub vertices: u32,
    /// Number of triangles. 0: the tile is gone, and has no place.
    pub triangles: u32,
    /// Bytes of an index: 2 or 4. There are 3 indices per triangle, which count from the tile's first vertex.
    pub index_bytes: u32,
    /// Bytes of a vertex; 0 in sessions without a layout.
    pub stride: u32,
    /// 1 with TT_POSITION_GRID: the coordinates k mean the position `centre + step * (corner + k)`, where `centre` is
    /// the part's.
    pub has_grid: u32,
    pub corner: [i32; 3],
    /// 0.
    pub reserved: u32,
    /// A power of two, millimetres.
    pub step: f64,
    /// What `tt_memory.room` gave for it.
    pub place: u64,
    /// Sessions without a layout: 3 numbers per vertex, millimetres, part coordinates. Else null, as those below.
    pub positions: *const f64,
    /// 3 numbers per vertex: unit normals that point outwards.
    pub normals: *const f32,
    /// 2 numbers per vertex, in the natural parameters of the face's surface.
    pub uvs: *const f32,
    /// 3 per triangle, counter-clockwise seen from outside.
    pub indices: *const u32,
}
versioned!(tt_tile, reserved);

/// Room for a tile: what `tt_memory.room` fills in.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_room {
    /// `sizeof(tt_room)` of the library.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Room for `vertices * stride` bytes, of any alignment. The library writes each byte once, in order, and reads
    /// none.
    pub vertices: *mut c_void,
    /// Room for `3 * triangles * index_bytes` bytes.
    pub indices: *mut c_void,
    /// Any number by which the caller finds the room: it becomes the tile's `place`.
    pub place: u64,
}

/// Where the memory of tiles comes from. Its functions are called by workers, on any thread, several at the same time,
/// each for its own tiles. They make no call of the session.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_memory {
    /// `sizeof(tt_memory)`.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Passed to the functions. Valid until the session is freed, or writes elsewhere.
    pub user: *mut c_void,
    /// Fills in the room for a tile, and returns 0. It is written after this returned, until `tt_sink.tile` hears of
    /// the tile, or `release` does. Another number refuses: the frame is not committed, its tiles are part of the next
    /// one.
    pub room: Option<extern "C" fn(user: *mut c_void, tile: *const tt_tile, room: *mut tt_room) -> i32>,
    /// Takes back the room of a tile of which the sink never hears, because its frame was cancelled or refused.
    pub release: Option<extern "C" fn(user: *mut c_void, tile: *const tt_tile)>,
}
versioned!(tt_memory, reserved);

type Room = extern "C" fn(*mut c_void, *const tt_tile, *mut tt_room) -> i32;
type Release = extern "C" fn(*mut c_void, *const tt_tile);

pub(crate) struct Memory {
    user: User,
    room: Room,
    release: Release,
}

impl Memory {
    pub(crate) fn of(c: &Caller, from: *const tt_memory) -> Result<Self, Failure> {
        let from = c.read("memory", from)?;
        let (Some(room), Some(release)) = (from.room, from.release) else {
            return Err(Failure::argument("memory.room and memory.release must be functions"));
        };
        Ok(Self { user: User::of(from.user), room, release })
    }
}

/// A tile whose vertices are in the caller's memory.
pub(crate) fn written(tile: &WrittenTile) -> tt_tile {
    let WrittenTile { part, face, tile: id, worker, vertices, triangles, wide, layout, grid, place } = *tile;
    tt_tile {
        size: size_of::<tt_tile>() as u32,
        part: part.0,
        face: face.0,
        tile: id.0,
        worker,
        vertices,
        triangles,
        index_bytes: if wide { 4 } else { 2 },
        stride: layout.stride() as u32,
        has_grid: grid.is_some().into(),
        corner: grid.map_or([0; 3], |grid| grid.corner),
        step: grid.map_or(0.0, |grid| grid.step),
        place,
        ..zeros()
    }
}

/// What a callback that returned another number than 0 means.
pub(crate) fn refused(name: &str, number: i32) -> SinkError {
    SinkError::new(name, std::io::Error::other(format!("it returned {number}")))
}

impl TileMemory for Memory {
    fn write(&self, tile: &WrittenTile, fill: &mut dyn FnMut(&mut [u8], &mut [u8])) -> Result<u64, SinkError> {
        let size = size_of::<tt_room>() as u32;
        let mut room = tt_room { size, reserved: 0, vertices: ptr::null_mut(), indices: ptr::null_mut(), place: 0 };
        match (self.room)(self.user.get(), &written(tile), &mut room) {
            0 if room.vertices.is_null() || room.indices.is_null() => {
                Err(SinkError::new("tt_memory.room", std::io::Error::other("it gave null")))
            }
            0 => {
                let vertices = (room.vertices.cast(), tile.vertex_bytes());
                // SAFETY: the room that C gave for this tile alone, as large as `tt_room` asks for.
                unsafe { lend(vertices, (room.indices.cast(), tile.index_bytes()), fill) };
                Ok(room.place)
            }
            number => Err(refused("tt_memory.room", number)),
        }
    }

    fn release(&self, tile: &WrittenTile) {
        (self.release)(self.user.get(), &written(tile));
    }
}
