//! A frame to binary STL: single-precision millimetres in world coordinates, a flat normal per triangle.

use super::placed::{Placement, distinct, placed};
use super::single::{BeyondSingle, single};
use crate::mesh::{BatchView, FrameView};
use glam::Vec3;
use std::io::{self, Write};

/// Writes every instance.
///
/// Positions are rounded once, from world coordinates, so the file is closed wherever the mesh is. Triangles whose
/// rounded corners coincide are left out.
///
/// # Errors
/// I/O errors of `file`. 2³² triangles or more, or a position [beyond single precision](BeyondSingle); nothing is
/// written then.
pub fn write_stl<'a>(frame: impl Into<FrameView<'a>>, file: &mut impl Write) -> io::Result<()> {
    let frame = &frame.into();
    let by_part = frame.batches_by_part();
    let mut world = Vec::new();
    let mut triangles = 0_u64;
    for (_, placement, batches) in placed(frame, &by_part) {
        for batch in batches {
            round(batch, &placement, &mut world)?;
            triangles += distinct(&batch.mesh, &world).count() as u64;
        }
    }
    let count = u32::try_from(triangles)
        .map_err(|_| io::Error::other(format!("{triangles} triangles exceed the STL limit of {}", u32::MAX)))?;
    // The header must not start with "solid": readers would take the file for text STL.
    let mut head = [b' '; 80];
    let title = b"binary STL, millimetres, written by trimtess";
    head[..title.len()].copy_from_slice(title);
    file.write_all(&head)?;
    file.write_all(&count.to_le_bytes())?;
    let mut bytes = Vec::new();
    for (_, placement, batches) in placed(frame, &by_part) {
        for batch in batches {
            round(batch, &placement, &mut world)?;
            bytes.clear();
            for corners in distinct(&batch.mesh, &world) {
                let [a, b, c] = placement.winding(corners).map(|corner| world[corner as usize]);
                let normal = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize_or_zero().as_vec3();
                for coordinate in [normal, a, b, c].iter().flat_map(Vec3::to_array) {
                    bytes.extend_from_slice(&coordinate.to_le_bytes());
                }
                bytes.extend_from_slice(&[0, 0]);
            }
            file.write_all(&bytes)?;
        }
    }
    Ok(())
}

fn round(batch: &BatchView<'_>, placement: &Placement, world: &mut Vec<Vec3>) -> Result<(), BeyondSingle> {
    world.clear();
    for &point in batch.mesh.positions {
        world.push(single(placement.position(point))?);
    }
    Ok(())
}
