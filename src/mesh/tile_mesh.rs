//! The triangles of one tile, and where their vertices come from.

use crate::model::{EdgeId, FaceId, PartId, TileId};
use glam::{DVec3, Vec2, Vec3};

/// Where a vertex comes from. Vertices of a part with equal [`Edge`](Self::Edge) origins have bit-identical positions.
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
    /// A point where two boundary segments of a self-crossing face meet. Neighbouring tiles do not have it.
    Crossing {
        /// Index among the tile's crossings.
        k: u32,
    },
    /// A point inside the tile, off its lattice. Inserted where triangles between tessellants alone would deviate from
    /// the surface by more than the tolerance.
    Inner {
        /// Index of the vertex in the tile.
        k: u32,
    },
    /// Tessellant `k` of a border between tiles, a seam or a pole of the face.
    Border {
        /// Number of the border among those of the part.
        border: u32,
        /// Index along the border.
        k: u32,
    },
}

impl Origin {
    /// Three words: the variant (0 [`Lattice`](Self::Lattice), 1 [`Edge`](Self::Edge), 2 [`Crossing`](Self::Crossing),
    /// 3 [`Inner`](Self::Inner), 4 [`Border`](Self::Border)) and its fields in order, then zeros.
    #[must_use]
    pub const fn words(&self) -> [u32; 3] {
        match *self {
            Self::Lattice { i, j } => [0, i, j],
            Self::Edge { edge, k } => [1, edge.0, k],
            Self::Crossing { k } => [2, k, 0],
            Self::Inner { k } => [3, k, 0],
            Self::Border { border, k } => [4, border, k],
        }
    }
}

/// Lists of a [`TileMesh`] that not every sink reads. Positions, normals and triangles are always there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshLists {
    /// [`TileMesh::uvs`].
    pub uvs: bool,
    /// [`TileMesh::lines`].
    pub lines: bool,
    /// [`TileMesh::origins`].
    pub origins: bool,
}

impl Default for MeshLists {
    /// [`ALL`](Self::ALL).
    fn default() -> Self {
        Self::ALL
    }
}

impl MeshLists {
    /// All lists.
    pub const ALL: Self = Self { uvs: true, lines: true, origins: true };
    /// None of these.
    pub const NONE: Self = Self { uvs: false, lines: false, origins: false };

    /// Whether all of `others` are among them.
    #[must_use]
    pub fn contain(self, others: Self) -> bool {
        let Self { uvs, lines, origins } = others;
        uvs <= self.uvs && lines <= self.lines && origins <= self.origins
    }
}

/// Triangles of one tile, in the part's coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileMesh {
    /// Positions, millimetres.
    pub positions: Vec<DVec3>,
    /// Unit normals that point outwards: the face's orientation is applied.
    pub normals: Vec<Vec3>,
    /// Parameters of each vertex, in the surface's natural parametrisation.
    pub uvs: Vec<Vec2>,
    /// The lattice's u-lines and v-lines in the same parametrisation, borders included. Empty without a lattice.
    pub lines: [Vec<f32>; 2],
    /// Where each vertex came from.
    pub origins: Vec<Origin>,
    /// Vertex indices, counter-clockwise seen from outside. No triangle has two corners at the same position.
    pub triangles: Vec<[u32; 3]>,
}

impl TileMesh {
    /// Bytes of its lists, without spare capacity.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let Self { positions, normals, uvs, lines, origins, triangles } = self;
        let lines = lines.iter().map(|lines| size_of_val(&lines[..])).sum::<usize>();
        size_of_val(&positions[..])
            + size_of_val(&normals[..])
            + size_of_val(&uvs[..])
            + lines
            + size_of_val(&origins[..])
            + size_of_val(&triangles[..])
    }

    pub(crate) fn shrink_to_fit(&mut self) {
        let Self { positions, normals, uvs, lines, origins, triangles } = self;
        positions.shrink_to_fit();
        normals.shrink_to_fit();
        uvs.shrink_to_fit();
        lines.iter_mut().for_each(Vec::shrink_to_fit);
        origins.shrink_to_fit();
        triangles.shrink_to_fit();
    }

    /// Empties all lists and keeps their capacity.
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

/// One tile's triangles, as sent to a [`MeshSink`](crate::mesh::MeshSink).
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// The part.
    pub part: PartId,
    /// The face within the part.
    pub face: FaceId,
    /// The tile within the part.
    pub tile: TileId,
    /// The worker that made it, 0 in [`serial`](crate::parallel::serial). The only field that depends on who works.
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
