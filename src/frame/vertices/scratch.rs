//! Buffers that a worker reuses for all its tiles.

use super::lattice::EvaluateScratch;
use crate::frame::trim::climb::TrimScratch;
use crate::frame::trim::output::TrimOutput;
use crate::mesh::TileMesh;
use glam::DVec2;

/// Work space that one worker reuses for all its tiles. Does not affect results.
#[derive(Default)]
pub struct Scratch {
    /// Cell coordinates of the vertices, tessellants first.
    pub(crate) cells: Vec<DVec2>,
    /// Parameters of the vertices.
    pub(crate) uvs: Vec<DVec2>,
    pub(crate) loop_starts: Vec<u32>,
    /// Parameters of the tessellants of one use of an edge.
    pub(crate) ts: Vec<f64>,
    /// Vertex of each lattice point, or `NONE`.
    pub(crate) corners: Vec<u32>,
    /// The lattice points that have a vertex, in its order.
    pub(crate) used: Vec<[u32; 2]>,
    /// Vertices of full cells.
    pub(crate) quads: Vec<[u32; 4]>,
    /// Triangles that may be folded, ascending.
    pub(crate) doubtful: Vec<usize>,
    pub(crate) trim: TrimScratch,
    pub(crate) trimmed: TrimOutput,
    pub(crate) evaluate: EvaluateScratch,
    /// Empty, with the room of the last tile's mesh.
    mesh: TileMesh,
}

impl Scratch {
    /// An empty mesh, with the room of the last one that came back.
    pub(crate) fn take_mesh(&mut self) -> TileMesh {
        std::mem::take(&mut self.mesh)
    }

    /// Gives the room of the last tile's mesh to the next one. Without it, each tile gets new memory.
    pub fn reuse(&mut self, mut mesh: TileMesh) {
        mesh.clear();
        self.mesh = mesh;
    }
}
