//! Parameters of a tile's vertices -> positions and normals.

use super::evaluate::evaluate_points;
use super::lattice::evaluate_lattice;
use super::scratch::Scratch;
use crate::frame::plan::output::TileLattice;
use crate::mesh::TileMesh;
use crate::prepare::internals::PreparedFace;
use glam::{DVec3, Vec3};

/// Fewest lattice points to evaluate line by line. With fewer, setting up the lines costs more than it saves.
const LATTICE_FROM: usize = 16;
/// Evaluates line by line only if at least one in this many of the lattice's points is used.
const LATTICE_SHARE: usize = 4;

/// Evaluates the positions of lattice points and crossings, and the normals of all vertices. A plane has one normal.
///
/// Positions of tessellants are those of their edges. Lattices that are largely used are evaluated line by line, all
/// else point by point. Both give the same bits.
pub(crate) fn evaluate_vertices(
    face: &PreparedFace,
    lattice: &TileLattice,
    corners_used: usize,
    s: &mut Scratch,
    mesh: &mut TileMesh,
) {
    let Scratch { outline, uvs, corners, evaluate, .. } = s;
    let (tessellants, side) = (outline.len(), if face.reversed { -1.0 } else { 1.0 });
    let TileMesh { positions, normals, .. } = mesh;
    positions.reserve_exact(uvs.len());
    positions.extend_from_slice(outline);
    // All are evaluated below. A position that stays NaN fails every check.
    positions.resize(uvs.len(), DVec3::NAN);
    if let Some(normal) = face.plane_normal {
        normals.resize(uvs.len(), (normal * side).as_vec3());
        let positions = &mut positions[tessellants..];
        evaluate_points(&face.patches, &uvs[tessellants..], &mut |first, points| {
            positions[first..].iter_mut().zip(points.iter()).for_each(|(to, (position, _))| *to = position);
        });
        return;
    }
    normals.resize(uvs.len(), Vec3::Z);
    let (positions, normals) = (&mut positions[tessellants..], &mut normals[..]);
    let normal = move |n: DVec3| (n * side).as_vec3();
    evaluate_points(&face.patches, &uvs[..tessellants], &mut |first, points| {
        normals[first..].iter_mut().zip(points.iter()).for_each(|(to, (_, n))| *to = normal(n));
    });
    let normals = &mut normals[tessellants..];
    let mut rest = &uvs[tessellants..];
    let mut first = 0;
    if corners_used >= LATTICE_FROM && corners_used * LATTICE_SHARE >= corners.len() {
        let (positions, normals) = (&mut *positions, &mut *normals);
        // Owns its slices: if it referred to them, they would be loaded again for each point.
        let put = move |vertex: usize, position: DVec3, n: DVec3| {
            let k = vertex - tessellants;
            positions[k] = position;
            normals[k] = normal(n);
        };
        evaluate_lattice(&face.patches, &lattice.us, &lattice.vs, corners, evaluate, put);
        (first, rest) = (corners_used, &rest[corners_used..]);
    }
    evaluate_points(&face.patches, rest, &mut |k, points| {
        for (k, (position, n)) in (first + k..).zip(points.iter()) {
            positions[k] = position;
            normals[k] = normal(n);
        }
    });
}
