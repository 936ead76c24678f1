//! A frame to binary STL: single-precision millimetres in world coordinates, a flat normal per triangle.

use super::making::{Making, Pieces};
use super::plain::{pieces, to_single};
use super::rounding::Rounding;
use super::save_error::{SaveError, counted};
use crate::mesh::FrameView;
use glam::Vec3;

/// Makes the file.
pub(super) fn stl(making: &Making<'_>, frame: &FrameView<'_>) -> Result<(Pieces, Rounding), SaveError> {
    let (mut pieces, rounding) = pieces(making, frame, |run| {
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
    let count = counted(rounding.triangles, "triangles")?;
    // The header must not start with "solid": readers would take the file for text STL.
    let mut head = vec![b' '; 80];
    let title = b"binary STL, millimetres, written by trimtess";
    head[..title.len()].copy_from_slice(title);
    head.extend_from_slice(&count.to_le_bytes());
    pieces.insert(0, head);
    Ok((pieces, rounding))
}
