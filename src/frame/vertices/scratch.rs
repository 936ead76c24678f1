//! Buffers that a worker reuses for all its tiles.

use super::evaluate::EvaluateScratch;
use crate::frame::trim::climb::TrimScratch;
use crate::frame::trim::output::TrimOutput;
use crate::mesh::TileMesh;
use glam::{DVec2, DVec3};

/// Work space that one worker reuses for all its tiles. Does not affect results.
#[derive(Default)]
pub struct Scratch {
    pub(crate) cells: Vec<DVec2>,
    pub(crate) uvs: Vec<DVec2>,
    pub(crate) loop_starts: Vec<u32>,
    /// Vertex of each lattice point, or `NONE`.
    pub(crate) corners: Vec<u32>,
    pub(crate) normals: Vec<DVec3>,
    pub(crate) points: Vec<DVec3>,
    /// Points and normals of the whole lattice.
    pub(crate) lattice: (Vec<DVec3>, Vec<DVec3>),
    pub(crate) trim: TrimScratch,
    pub(crate) trimmed: TrimOutput,
    pub(crate) evaluate: EvaluateScratch,
    /// Buffers for later tiles.
    spare: Vec<TileMesh>,
}

impl Scratch {
    /// An empty mesh, with the memory of a used one if there is any.
    pub(crate) fn spare(&mut self) -> TileMesh {
        self.spare.pop().unwrap_or_default()
    }

    /// Gives the buffers of `mesh` to later tiles.
    pub fn reuse(&mut self, mut mesh: TileMesh) {
        mesh.clear();
        self.spare.push(mesh);
    }
}
