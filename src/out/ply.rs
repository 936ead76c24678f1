//! A frame to PLY, binary little-endian: f64 positions in millimetres and world coordinates, f32 normals, and the face
//! of each triangle.

use super::making::{Making, Pieces};
use super::plain::{pieces, to_double};
use super::rounding::Rounding;
use super::save_error::{SaveError, counted};
use crate::mesh::FrameView;

/// Bytes of a vertex.
const VERTEX: usize = 3 * 8 + 3 * 4;

/// Makes the file.
pub(super) fn ply(making: &Making<'_>, frame: &FrameView<'_>) -> Result<(Pieces, Rounding), SaveError> {
    let (pieces, rounding) = pieces(making, frame, |run| {
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        // Too many vertices are refused below.
        let mut first = run.first as u32;
        let count = run.round(to_double, |batch, world, triangles| {
            for (index, point) in making.call.while_wanted(world.iter().enumerate()) {
                let normal = batch.mesh.normals.get(index).copied().unwrap_or_default();
                for coordinate in point.to_array() {
                    vertices.extend_from_slice(&coordinate.to_le_bytes());
                }
                for coordinate in run.placement.normal(normal).as_vec3().to_array() {
                    vertices.extend_from_slice(&coordinate.to_le_bytes());
                }
            }
            let face_id = run.instance.face_number(batch.face);
            for corners in triangles {
                faces.push(3);
                for corner in corners {
                    faces.extend_from_slice(&first.wrapping_add(corner).to_le_bytes());
                }
                faces.extend_from_slice(&face_id.to_le_bytes());
            }
            first = first.wrapping_add(world.len() as u32);
        })?;
        Ok(((vertices, faces), count))
    })?;
    let vertices = pieces.iter().map(|(vertices, _)| (vertices.len() / VERTEX) as u64).sum::<u64>();
    counted(vertices, "vertices")?;
    let head = format!(
        "ply\nformat binary_little_endian 1.0\ncomment millimetres\n\
         element vertex {vertices}\nproperty double x\nproperty double y\nproperty double z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         element face {}\nproperty list uchar uint vertex_indices\nproperty uint face_id\nend_header\n",
        rounding.triangles
    );
    let (vertices, faces): (Pieces, Pieces) = pieces.into_iter().unzip();
    Ok((std::iter::once(head.into_bytes()).chain(vertices).chain(faces).collect(), rounding))
}
