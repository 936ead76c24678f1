//! The triangles of one tile.

use crate::model::{EdgeId, FaceId, PartId, TileId};
use glam::{DVec3, Vec2, Vec3};

/// Where a vertex came from. Vertices of one part with equal `edge` origins have bit-identical positions.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Origin {
    /// Lattice point (line of u, line of v) of the tile.
    Lattice {
        /// Line of u.
        i: u32,
        /// Line of v.
        j: u32,
    },
    /// Tessellant `k` of a B-rep edge.
    Edge {
        /// The edge.
        edge: EdgeId,
        /// Index along the edge, from its start; 0 and the last are the edge's vertices.
        k: u32,
    },
    /// A point where two boundary segments of a self-crossing face meet: its neighbours do not know of it.
    Crossing {
        /// Number within the tile.
        k: u32,
    },
    /// A point within the tile, off its lattice: where tessellants are so far apart that the triangles between them would
    /// leave the surface.
    Inner {
        /// Number among the tile's vertices.
        k: u32,
    },
    /// Tessellant `k` of a border between tiles, a seam or a pole of the face.
    Border {
        /// Border number within the part's prepared edges.
        border: u32,
        /// Index along the border.
        k: u32,
    },
}

/// Triangles of one tile, in the part's coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileMesh {
    /// Positions, millimetres, f64: what all arithmetic of topology and the f64 file formats use.
    pub positions: Vec<DVec3>,
    /// Unit normals that point out of the face (face orientation applied).
    pub normals: Vec<Vec3>,
    /// Surface parameters of each vertex, in the surface's natural parameters.
    pub uvs: Vec<Vec2>,
    /// The lattice's u-lines and v-lines in the same parameters, from one border of the tile to the other; empty where there is
    /// no lattice.
    pub lines: [Vec<f32>; 2],
    /// Where each vertex came from.
    pub origins: Vec<Origin>,
    /// Vertex indices, counter-clockwise seen from the outside. No triangle repeats a position.
    pub triangles: Vec<[u32; 3]>,
}

impl TileMesh {
    /// Empties all lists and keeps their memory.
    pub fn clear(&mut self) {
        let Self { positions, normals, uvs, lines, origins, triangles } = self;
        positions.clear();
        normals.clear();
        uvs.clear();
        lines.iter_mut().for_each(Vec::clear);
        origins.clear();
        triangles.clear();
    }
}

/// One tile's triangles on their way out.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// The part.
    pub part: PartId,
    /// The face within the part.
    pub face: FaceId,
    /// The tile within the part.
    pub tile: TileId,
    /// Which worker made it (0 for the serial path). Not part of the result: it depends on the worker count.
    pub worker: u32,
    /// The triangles.
    pub mesh: TileMesh,
}

/// The polyline of one B-rep edge: tessellants in order, from start to end.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeLine {
    /// The part.
    pub part: PartId,
    /// The edge.
    pub edge: EdgeId,
    /// Points, millimetres, part coordinates.
    pub points: Vec<DVec3>,
}
