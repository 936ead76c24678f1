//! Buffers that a worker reuses for all its tiles.

use super::lattice::EvaluateScratch;
use crate::frame::trim::climb::TrimScratch;
use crate::frame::trim::output::TrimOutput;
use crate::mesh::{Origin, TileMesh};
use glam::{DVec2, DVec3};

/// Work space that one worker reuses for all its tiles. Does not affect results.
#[derive(Default)]
pub struct Scratch {
    /// Positions of the tessellants.
    pub(crate) outline: Vec<DVec3>,
    /// Where the vertices come from, tessellants first.
    pub(crate) origins: Vec<Origin>,
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
    /// Runs of full cells along a row: column and row of the first, and how many.
    pub(crate) runs: Vec<[u32; 3]>,
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
