//! Tiles that workers write straight into a sink's memory, in the layout that it asks for, and why a sink fails.

use super::vertex_layout::{NormalFormat, PositionFormat, VertexLayout, octahedral};
use super::{Origin, TileMesh};
use crate::math::boxes::around;
use crate::math::lanes::widest;
use crate::model::{FaceId, PartId, TileId};
use glam::{DVec3, Vec2, Vec3};

/// Why a sink failed, usually I/O.
#[derive(Debug, thiserror::Error)]
#[error("{context}: {cause}")]
#[non_exhaustive]
pub struct SinkError {
    /// What the sink was doing (a path, a buffer).
    pub context: String,
    /// The cause.
    pub cause: std::io::Error,
}

impl SinkError {
    /// An error of a sink that was doing `context` (a path, a buffer).
    ///
    /// ```
    /// use std::io::{Error, ErrorKind};
    /// use trimtess::mesh::SinkError;
    ///
    /// assert_eq!(SinkError::new("vertex buffer", ErrorKind::OutOfMemory).to_string(), "vertex buffer: out of memory");
    /// assert_eq!(SinkError::new("a.obj", Error::other("disk is full")).to_string(), "a.obj: disk is full");
    /// ```
    #[must_use]
    pub fn new(context: impl Into<String>, cause: impl Into<std::io::Error>) -> Self {
        Self { context: context.into(), cause: cause.into() }
    }
}

/// Where the memory of tiles comes from: mapped buffers, an arena, one block per tile.
///
/// Workers call it, on any thread, at the same time, each for its own tiles. An arena per
/// [`worker`](WrittenTile::worker) needs no lock that is ever waited for.
pub trait TileMemory: Send + Sync {
    /// Hands `fill` the room for a tile: [`vertex_bytes`](WrittenTile::vertex_bytes) and
    /// [`index_bytes`](WrittenTile::index_bytes), exactly. `fill` writes each byte once, in order, and reads none.
    /// Returns any number by which the sink finds the room: it becomes [`WrittenTile::place`].
    ///
    /// # Errors
    /// When there is no room: the frame is not committed, and its tiles are part of the next one.
    fn write(&self, tile: &WrittenTile, fill: &mut dyn FnMut(&mut [u8], &mut [u8])) -> Result<u64, SinkError>;

    /// Takes back the room of a tile that the sink never hears of, because its frame was cancelled or refused.
    fn release(&self, tile: &WrittenTile);
}

/// A tile whose vertices and indices are in the memory of the sink.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrittenTile {
    /// The part.
    pub part: PartId,
    /// The face within the part.
    pub face: FaceId,
    /// The tile within the part.
    pub tile: TileId,
    /// The worker that made it. The only field besides `place` that depends on who works.
    pub worker: u32,
    /// Number of vertices.
    pub vertices: u32,
    /// Number of triangles. 0: the tile is gone, and has no place.
    pub triangles: u32,
    /// Whether indices have four bytes.
    pub wide: bool,
    /// The layout of its vertices.
    pub layout: VertexLayout,
    /// Where its coordinates count from. With [`PositionFormat::Grid`] only.
    pub grid: Option<TileGrid>,
    /// What [`TileMemory::write`] returned.
    pub place: u64,
}

/// What the integer coordinates `k` of a tile mean: the position `centre + step * (corner + k)`, where `centre` is the
/// part's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileGrid {
    /// Step of the part's grid, millimetres: a power of two.
    pub step: f64,
    /// Smallest coordinates of the tile, in steps.
    pub corner: [i32; 3],
}

/// A tile that the grid of its part is too coarse for.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "part {}, tile {}: a grid of 16 bits moves vertices by up to {moved:.1e} mm, more than a tenth of the tolerance \
     ({chord:.1e} mm)",
    .part.0, .tile.0
)]
pub struct GridTooCoarse {
    /// The part.
    pub part: PartId,
    /// The tile.
    pub tile: TileId,
    /// Distance by which rounding to the grid may move a vertex, millimetres.
    pub moved: f64,
    /// The chord tolerance of the tile, millimetres.
    pub chord: f64,
}

/// Share of a tile's tolerance that rounding to the grid may take.
const SHARE: f64 = 0.1;

/// The grid of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PartGrid {
    pub(crate) centre: DVec3,
    pub(crate) step: f64,
}

impl PartGrid {
    /// The finest grid for a part with this box whose tiles are at most so large, millimetres.
    pub(crate) fn new(centre: DVec3, radius: f64, largest: f64) -> Self {
        /// Steps across the largest tile: a little less than 16 bits hold, since edges may leave the tile's box.
        const ACROSS: f64 = 60_000.0;
        let finest = (largest / ACROSS).max(radius / f64::from(1 << 29)).max(f64::MIN_POSITIVE);
        Self { centre, step: libm::exp2(libm::log2(finest).ceil()) }
    }

    /// Distance by which rounding moves a point at most.
    fn moves(&self) -> f64 {
        0.5 * 3_f64.sqrt() * self.step
    }

    fn steps(&self, position: DVec3) -> DVec3 {
        ((position - self.centre) / self.step).round()
    }

    /// The grid of one tile; `None` if it is too large for it.
    fn tile(&self, positions: &[DVec3]) -> Option<TileGrid> {
        let [low, high] = around(positions.iter().map(|&position| self.steps(position)));
        let fits = (high - low).max_element() <= f64::from(u16::MAX);
        let near = low.abs().max_element() < f64::from(i32::MAX);
        (fits && near).then(|| TileGrid { step: self.step, corner: low.to_array().map(|x| x as i32) })
    }
}

/// Why a tile was not written.
#[derive(Debug)]
pub(crate) enum NotWritten {
    Sink(SinkError),
    Grid(GridTooCoarse),
}

impl WrittenTile {
    /// Bytes of its vertices.
    #[must_use]
    pub fn vertex_bytes(&self) -> usize {
        self.vertices as usize * self.layout.stride()
    }

    /// Bytes of its indices.
    #[must_use]
    pub fn index_bytes(&self) -> usize {
        3 * self.triangles as usize * if self.wide { 4 } else { 2 }
    }

    /// A tile without triangles.
    pub(crate) fn gone((part, face, tile): (PartId, FaceId, TileId), layout: VertexLayout) -> Self {
        Self { part, face, tile, worker: 0, vertices: 0, triangles: 0, wide: false, layout, grid: None, place: 0 }
    }

    /// Writes `mesh` into memory for this tile, whose counts and place it sets. `chord`: the tile's tolerance.
    /// `tangent`: the tangent at parameters.
    pub(crate) fn write(
        mut self,
        mesh: &TileMesh,
        (grid, chord): (&PartGrid, f64),
        tangent: &dyn Fn(Vec2) -> Vec3,
        memory: &dyn TileMemory,
    ) -> Result<Self, NotWritten> {
        if mesh.triangles.is_empty() {
            return Ok(self);
        }
        let count = |n: usize| {
            let cause = || std::io::Error::other(format!("{n} vertices or triangles exceed 32 bits"));
            u32::try_from(n).map_err(|_| NotWritten::Sink(SinkError::new("a tile", cause())))
        };
        (self.vertices, self.triangles) = (count(mesh.positions.len())?, count(mesh.triangles.len())?);
        self.wide = self.layout.is_wide(mesh.positions.len());
        if self.layout.position == PositionFormat::Grid {
            let moved = grid.moves();
            self.grid = grid.tile(&mesh.positions).filter(|_| moved <= SHARE * chord);
            if self.grid.is_none() {
                return Err(NotWritten::Grid(GridTooCoarse { part: self.part, tile: self.tile, moved, chord }));
            }
        }
        let mut written = None;
        let place = memory.write(&self, &mut |vertices, indices| {
            let fits = (vertices.len(), indices.len()) == (self.vertex_bytes(), self.index_bytes());
            if fits {
                widest(
                    #[inline(always)]
                    || {
                        self.vertices_to(mesh, grid, tangent, vertices);
                        self.indices_to(mesh, indices);
                    },
                );
            }
            written = Some(fits);
        });
        self.place = place.map_err(NotWritten::Sink)?;
        if written == Some(true) {
            return Ok(self);
        }
        memory.release(&self);
        let (vertices, indices) = (self.vertex_bytes(), self.index_bytes());
        let cause = std::io::Error::other(format!("{vertices} + {indices} bytes asked for"));
        Err(NotWritten::Sink(SinkError::new("room of another size, or none, for a tile", cause)))
    }

    /// Writes the vertices by a loop for their formats of position and normal.
    #[inline(always)]
    fn vertices_to(&self, mesh: &TileMesh, part: &PartGrid, tangent: &dyn Fn(Vec2) -> Vec3, bytes: &mut [u8]) {
        let corner = self.grid.map_or(DVec3::ZERO, |grid| DVec3::from(grid.corner.map(f64::from)));
        let bytes = (bytes, mesh, tangent);
        match self.layout.position {
            PositionFormat::F64 => self.with_positions(bytes, |p| {
                let [x, y, z] = p.to_array().map(f64::to_bits);
                [x as u32, (x >> 32) as u32, y as u32, (y >> 32) as u32, z as u32, (z >> 32) as u32]
            }),
            PositionFormat::F32 => {
                self.with_positions(bytes, |p| (p - part.centre).as_vec3().to_array().map(f32::to_bits));
            }
            PositionFormat::Grid => self.with_positions(bytes, |p| {
                let [x, y, z] = (part.steps(p) - corner).to_array().map(|x| u32::from(x as u16));
                [x | y << 16, z]
            }),
        }
    }

    #[inline(always)]
    fn with_positions<const N: usize>(
        &self,
        bytes: (&mut [u8], &TileMesh, &dyn Fn(Vec2) -> Vec3),
        position: impl Fn(DVec3) -> [u32; N],
    ) {
        match self.layout.normal {
            NormalFormat::None => self.vertex_by_vertex(bytes, position, |_| []),
            NormalFormat::F32 => self.vertex_by_vertex(bytes, position, |n| n.to_array().map(f32::to_bits)),
            NormalFormat::Octahedral => self.vertex_by_vertex(bytes, position, |n| {
                let [x, y] = octahedral(n).map(|x| u32::from(x.cast_unsigned()));
                [x | y << 16]
            }),
        }
    }

    #[inline(always)]
    fn vertex_by_vertex<const N: usize, const M: usize>(
        &self,
        (bytes, mesh, tangent): (&mut [u8], &TileMesh, &dyn Fn(Vec2) -> Vec3),
        position: impl Fn(DVec3) -> [u32; N],
        normal: impl Fn(Vec3) -> [u32; M],
    ) {
        let VertexLayout { uv: with_uv, tangent: with_tangent, origin: with_origin, .. } = self.layout;
        let uv = |k: usize| mesh.uvs.get(k).copied().unwrap_or_default();
        let words = |uv: Vec2| uv.to_array().map(f32::to_bits);
        let to = bytes.as_chunks_mut().0;
        // A loop for each of the usual layouts: to ask for each vertex takes as long as to write it.
        match (with_tangent || with_origin, with_uv) {
            (false, false) => put_vertices(to, mesh, position, normal, |_, _| ()),
            (false, true) => put_vertices(to, mesh, position, normal, |k, rest| put(rest, words(uv(k)))),
            (true, _) => put_vertices(to, mesh, position, normal, |k, rest| {
                if with_uv {
                    put(rest, words(uv(k)));
                }
                if with_tangent {
                    put(rest, tangent(uv(k)).to_array().map(f32::to_bits));
                }
                if with_origin {
                    put(rest, mesh.origins.get(k).map_or([u32::MAX; 3], Origin::words));
                }
            }),
        }
    }

    #[inline(always)]
    fn indices_to(&self, mesh: &TileMesh, bytes: &mut [u8]) {
        let corners = mesh.triangles.as_flattened();
        if self.wide {
            bytes.as_chunks_mut().0.iter_mut().zip(corners).for_each(|(to, corner)| *to = corner.to_le_bytes());
        } else {
            bytes
                .as_chunks_mut()
                .0
                .iter_mut()
                .zip(corners)
                .for_each(|(to, corner)| *to = (*corner as u16).to_le_bytes());
        }
    }
}

/// Writes the words of each vertex: position, normal, and what `others` writes after these.
#[inline(always)]
fn put_vertices<const N: usize, const M: usize>(
    mut rest: &mut [[u8; 4]],
    mesh: &TileMesh,
    position: impl Fn(DVec3) -> [u32; N],
    normal: impl Fn(Vec3) -> [u32; M],
    others: impl Fn(usize, &mut &mut [[u8; 4]]),
) {
    for (k, (&at, &outwards)) in mesh.positions.iter().zip(&mesh.normals).enumerate() {
        put(&mut rest, position(at));
        put(&mut rest, normal(outwards));
        others(k, &mut rest);
    }
}

/// Writes the next words.
#[inline(always)]
fn put<const N: usize>(rest: &mut &mut [[u8; 4]], values: [u32; N]) {
    if let Some((head, tail)) = std::mem::take(rest).split_first_chunk_mut::<N>() {
        *head = values.map(u32::to_le_bytes);
        *rest = tail;
    }
}
