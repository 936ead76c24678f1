//! A frame to PLY, binary little-endian: f64 positions in millimetres and world coordinates, f32 normals, and the face
//! of each triangle.

use super::placed::{distinct, placed};
use crate::mesh::FrameView;
use glam::DVec3;
use std::io::{self, Write};

/// Writes every instance. Vertices are shared within a batch only. `face_id` numbers faces across all instances
/// ([`SceneInstance::first_face`](crate::mesh::SceneInstance::first_face) + face).
///
/// # Errors
/// I/O errors of `file`, or 2³² vertices or more.
pub fn write_ply<'a>(frame: impl Into<FrameView<'a>>, file: &mut impl Write) -> io::Result<()> {
    let frame = &frame.into();
    let by_part = frame.batches_by_part();
    let (mut vertices, mut triangles) = (0_u64, 0_u64);
    let mut world: Vec<DVec3> = Vec::new();
    for (_, placement, batches) in placed(frame, &by_part) {
        for batch in batches {
            world.clear();
            world.extend(batch.mesh.positions.iter().map(|&point| placement.position(point)));
            vertices += world.len() as u64;
            triangles += distinct(&batch.mesh, &world).count() as u64;
        }
    }
    if u32::try_from(vertices).is_err() {
        return Err(io::Error::other(format!("{vertices} vertices exceed the 32-bit indices of PLY ({})", u32::MAX)));
    }
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\ncomment millimetres\n\
         element vertex {vertices}\nproperty double x\nproperty double y\nproperty double z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         element face {triangles}\nproperty list uchar uint vertex_indices\nproperty int face_id\nend_header\n"
    )?;
    let mut bytes = Vec::new();
    for (_, placement, batches) in placed(frame, &by_part) {
        for batch in batches {
            bytes.clear();
            for (index, &point) in batch.mesh.positions.iter().enumerate() {
                let normal = batch.mesh.normals.get(index).copied().unwrap_or_default();
                for coordinate in placement.position(point).to_array() {
                    bytes.extend_from_slice(&coordinate.to_le_bytes());
                }
                for coordinate in placement.normal(normal).as_vec3().to_array() {
                    bytes.extend_from_slice(&coordinate.to_le_bytes());
                }
            }
            file.write_all(&bytes)?;
        }
    }
    let mut first = 0_u32;
    for (instance, placement, batches) in placed(frame, &by_part) {
        for batch in batches {
            bytes.clear();
            world.clear();
            world.extend(batch.mesh.positions.iter().map(|&point| placement.position(point)));
            let face_id = instance.first_face.wrapping_add(batch.face.0);
            for corners in distinct(&batch.mesh, &world) {
                bytes.push(3);
                for corner in placement.winding(corners) {
                    bytes.extend_from_slice(&(first + corner).to_le_bytes());
                }
                bytes.extend_from_slice(&face_id.to_le_bytes());
            }
            file.write_all(&bytes)?;
            first += batch.mesh.positions.len() as u32;
        }
    }
    Ok(())
}
