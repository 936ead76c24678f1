//! Positions in double precision to single precision, or the number that it has none for.

use glam::{DVec3, Vec3};
use std::{error, fmt, io};

/// A position that single precision cannot hold: its numbers end at 3.4e38.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BeyondSingle {
    /// The position, in the file's units and axes.
    pub position: DVec3,
}

impl fmt::Display for BeyondSingle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DVec3 { x, y, z } = self.position;
        let most = f32::MAX;
        write!(
            f,
            "a position of ({x:e}, {y:e}, {z:e}) does not fit the file's single precision, which ends at {most:e}"
        )
    }
}

impl error::Error for BeyondSingle {}

impl From<BeyondSingle> for io::Error {
    fn from(beyond: BeyondSingle) -> Self {
        Self::new(io::ErrorKind::InvalidData, beyond)
    }
}

/// The nearest position in single precision. Never -0.0.
///
/// # Errors
/// Where a coordinate is not finite, or would not be.
pub(super) fn single(position: DVec3) -> Result<Vec3, BeyondSingle> {
    let rounded = position.as_vec3() + Vec3::ZERO;
    if rounded.is_finite() { Ok(rounded) } else { Err(BeyondSingle { position }) }
}
