//! A tile's boundary -> triangles that close it, from the points of its edges alone. For tiles whose surface or
//! parameters cannot be used.

use super::job::oriented;
use super::ladder::Rung;
use super::outcome::{Degradation, TileOutcome};
use crate::frame::plan::output::Plan;
use crate::frame::trim::climb::fill_loops;
use crate::frame::trim::input::TrimInput;
use crate::frame::trim::output::TrimOutput;
use crate::frame::vertices::boundary::trace_use;
use crate::mesh::TileMesh;
use crate::model::{PartId, TileId};
use crate::prepare::Prepared;
use glam::{DVec2, DVec3, Vec2};

/// Fills one tile's loops in space, after [`tessellate_tile`](crate::frame::internals::tessellate_tile) panicked. `why`
/// is the reason to report.
///
/// Uses only the points of edges. Normals are averaged from the triangles, parameters are zero.
#[must_use]
pub(crate) fn fill_tile(prepared: &Prepared, plan: &Plan, part: PartId, tile: TileId, why: String) -> TileOutcome {
    let (rows, plan) = (&prepared.parts[part.index()], &plan.parts[part.index()]);
    let tile = &rows.tiles[tile.0 as usize];
    let reversed = rows.face_of(tile).reversed;
    let mut mesh = TileMesh::default();
    let (mut loop_starts, mut ts) = (vec![0], Vec::new());
    for l in &tile.loops {
        for used in l {
            trace_use((rows, plan), used, &mut ts, (&mut mesh.positions, &mut mesh.origins));
        }
        loop_starts.push(mesh.positions.len() as u32);
    }
    let points = vec![DVec2::ZERO; mesh.positions.len()];
    let input = TrimInput { cells: (1, 1), points: &points, loop_starts: &loop_starts, places: &mesh.positions };
    let mut filled = TrimOutput::default();
    fill_loops(&input, &mut filled);
    mesh.triangles = filled.closing.iter().map(|&corners| oriented(corners, reversed)).collect();
    mesh.uvs = vec![Vec2::ZERO; mesh.positions.len()];
    let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
        corners.iter().for_each(|&v| normals[v as usize] += (b - a).cross(c - a));
    }
    mesh.normals = normals.iter().map(|n| n.normalize_or(DVec3::Z).as_vec3()).collect();
    let slivers = mesh.triangles.len() as u32;
    let degradation = Some(Degradation::Filled(why));
    TileOutcome { face: tile.face, mesh, rung: Rung::Filled, degradation, slivers, rewound: 0.0 }
}
