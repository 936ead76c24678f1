//! A frame to binary STL: single-precision millimetres in world coordinates, a flat normal per triangle.

use super::plain::{Pieces, pieces, to_single, write_alone};
use super::rounding::Rounding;
use crate::control::Call;
use crate::mesh::FrameView;
use glam::Vec3;
use std::io::{self, Write};

/// Writes every instance.
///
/// Positions are rounded once, from world coordinates, so the file is closed wherever the mesh is. Triangles whose
/// rounded corners coincide are left out. The whole file is in memory before it is written.
///
/// # Errors
/// I/O errors of `file`. 2³² triangles or more, or a position [beyond single precision](super::BeyondSingle); nothing
/// is written then.
pub fn write_stl<'a>(frame: impl Into<FrameView<'a>>, file: &mut impl Write) -> io::Result<()> {
    write_alone(file, |call| stl(call, &frame.into())).map(drop)
}

/// Makes the file.
pub(super) fn stl(call: Call<'_>, frame: &FrameView<'_>) -> io::Result<(Pieces, Rounding)> {
    let (mut pieces, rounding) = pieces(call, frame, |run| {
        let mut bytes = Vec::new();
        let count = run.round(to_single, |_, world, triangles| {
            for corners in triangles {
                let [a, b, c] = corners.map(|corner| world[corner as usize]);
                let normal = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize_or_zero().as_vec3();
                for coordinate in [normal, a, b, c].iter().flat_map(Vec3::to_array) {
                    bytes.extend_from_slice(&coordinate.to_le_bytes());
                }
                bytes.extend_from_slice(&[0, 0]);
            }
        })?;
        Ok((bytes, count))
    })?;
    let triangles = rounding.triangles;
    let count = u32::try_from(triangles)
        .map_err(|_| io::Error::other(format!("{triangles} triangles exceed the STL limit of {}", u32::MAX)))?;
    // The header must not start with "solid": readers would take the file for text STL.
    let mut head = vec![b' '; 80];
    let title = b"binary STL, millimetres, written by trimtess";
    head[..title.len()].copy_from_slice(title);
    head.extend_from_slice(&count.to_le_bytes());
    pieces.insert(0, head);
    Ok((pieces, rounding))
}
