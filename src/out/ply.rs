//! A frame to PLY, binary little-endian: f64 positions in millimetres and world coordinates, f32 normals, and the face
//! of each triangle.

use super::plain::{Pieces, pieces, to_double, write_alone};
use super::rounding::Rounding;
use crate::control::Call;
use crate::mesh::FrameView;
use std::io::{self, Write};

/// Bytes of a vertex.
const VERTEX: usize = 3 * 8 + 3 * 4;

/// Writes every instance. Vertices are shared within a batch only. `face_id` numbers faces across all instances
/// ([`SceneInstance::face_number`](crate::mesh::SceneInstance::face_number)). The whole file is in memory before it
/// is written.
///
/// # Errors
/// I/O errors of `file`, or 2³² vertices or more.
pub fn write_ply<'a>(frame: impl Into<FrameView<'a>>, file: &mut impl Write) -> io::Result<()> {
    write_alone(file, |call| ply(call, &frame.into())).map(drop)
}

/// Makes the file.
pub(super) fn ply(call: Call<'_>, frame: &FrameView<'_>) -> io::Result<(Pieces, Rounding)> {
    let (pieces, rounding) = pieces(call, frame, |run| {
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        // Too many vertices are refused below.
        let mut first = run.first as u32;
        let count = run.round(to_double, |batch, world, triangles| {
            for (index, point) in world.iter().enumerate() {
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
    if u32::try_from(vertices).is_err() {
        return Err(io::Error::other(format!("{vertices} vertices exceed the 32-bit indices of PLY ({})", u32::MAX)));
    }
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
