//! Positions in double precision to single precision, or an error where they overflow.

use glam::{DVec3, Vec3};
use std::{error, fmt, io};

/// A position that overflows single precision (3.4e38).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BeyondSingle {
    /// The position, in the file's units and axes.
    pub position: DVec3,
}

impl fmt::Display for BeyondSingle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DVec3 { x, y, z } = self.position;
        let most = f32::MAX;
        write!(f, "the position ({x:e}, {y:e}, {z:e}) overflows the file format's single precision (up to {most:e})")
    }
}

impl error::Error for BeyondSingle {}

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
