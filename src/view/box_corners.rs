//! A box to its corners, which cameras are fitted to.

use glam::DVec3;

/// The corners of a box from its least and its greatest one: x changes first, z last.
#[must_use]
pub fn box_corners(bounds: [DVec3; 2]) -> [DVec3; 8] {
    std::array::from_fn(|k| DVec3::from([0, 1, 2].map(|axis| bounds[k >> axis & 1][axis])))
}
