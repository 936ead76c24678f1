//! Positions in double precision to single precision, or an error where they overflow.

use glam::{DVec3, Vec3};
use std::io;

/// A position that overflows single precision (3.4e38).
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
#[error(
    "the position ({:e}, {:e}, {:e}) overflows the file format's single precision (up to {:e})",
    .position.x, .position.y, .position.z, f32::MAX
)]
pub struct BeyondSingle {
    /// The position, in the file's units and axes.
    pub position: DVec3,
}

impl From<BeyondSingle> for io::Error {
    fn from(beyond: BeyondSingle) -> Self {
        Self::new(io::ErrorKind::InvalidData, beyond)
    }
}

/// Rounds to the nearest position in single precision. Never -0.0.
///
/// # Errors
/// If a coordinate is not finite before or after rounding.
pub(super) fn single(position: DVec3) -> Result<Vec3, BeyondSingle> {
    let rounded = position.as_vec3() + Vec3::ZERO;
    if rounded.is_finite() { Ok(rounded) } else { Err(BeyondSingle { position }) }
}
