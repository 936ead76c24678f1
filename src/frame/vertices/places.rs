//! Parameters of a tile's vertices -> positions and normals.

use super::evaluate::{evaluate_lattice, evaluate_points};
use super::scratch::Scratch;
use crate::frame::plan::output::TileLattice;
use crate::frame::trim::input::NONE;
use crate::mesh::TileMesh;
use crate::prepare::internals::PreparedFace;
use glam::DVec3;

/// Fewest lattice points to evaluate line by line. With fewer, setting up the lines costs more than it saves.
const LATTICE_FROM: usize = 16;
/// Evaluates line by line only if at least one in this many of the lattice's points is used.
const LATTICE_SHARE: usize = 4;

/// Evaluates the positions of lattice points and crossings, and the normals of all vertices. A plane has one normal.
pub(crate) fn evaluate_vertices(
    face: &PreparedFace,
    lattice: &TileLattice,
    corners_used: usize,
    s: &mut Scratch,
    mesh: &mut TileMesh,
) {
    let (tessellants, side) = (s.cells.len(), if face.reversed { -1.0 } else { 1.0 });
    if let Some(normal) = face.plane_normal {
        // Positions of tessellants are those of their edges, so only the others are evaluated.
        if let others @ [_, ..] = &s.uvs[tessellants..] {
            evaluate_points(&face.patches, others, &mut s.points, &mut s.normals);
            mesh.positions.extend_from_slice(&s.points);
        }
        mesh.normals.resize(s.uvs.len(), (normal * side).as_vec3());
        return;
    }
    evaluate(face, lattice, tessellants, corners_used, s, &mut mesh.positions);
    mesh.normals.extend(s.normals.iter().map(|n| (*n * side).as_vec3()));
}

/// Puts the normals of all vertices into `s.normals`, and appends the positions of those that are not tessellants.
///
/// Lattices that are largely used are evaluated line by line, all else point by point. Both give the same bits.
fn evaluate(
    face: &PreparedFace,
    lattice: &TileLattice,
    tessellants: usize,
    corners_used: usize,
    s: &mut Scratch,
    positions: &mut Vec<DVec3>,
) {
    let Scratch { uvs, corners, normals, points, evaluate, lattice: on_lattice, .. } = s;
    if corners_used < LATTICE_FROM || corners_used * LATTICE_SHARE < corners.len() {
        evaluate_points(&face.patches, uvs, points, normals);
        positions.extend_from_slice(&points[tessellants..]);
        return;
    }
    let width = lattice.us.len();
    let wanted = |i: usize, j: usize| corners[j * width + i] != NONE;
    let (all_points, all_normals) = on_lattice;
    evaluate_lattice(&face.patches, &lattice.us, &lattice.vs, wanted, evaluate, all_points, all_normals);
    evaluate_points(&face.patches, &uvs[..tessellants], points, normals);
    positions.resize(tessellants + corners_used, DVec3::ZERO);
    normals.resize(tessellants + corners_used, DVec3::Z);
    let height = lattice.vs.len();
    for (c, &vertex) in corners.iter().enumerate().filter(|&(_, &vertex)| vertex != NONE) {
        let at = c % width * height + c / width;
        positions[vertex as usize] = all_points[at];
        normals[vertex as usize] = all_normals[at];
    }
    let crossings = &uvs[tessellants + corners_used..];
    if !crossings.is_empty() {
        let (all_points, all_normals) = on_lattice;
        evaluate_points(&face.patches, crossings, all_points, all_normals);
        positions.extend_from_slice(all_points);
        normals.extend_from_slice(all_normals);
    }
}
