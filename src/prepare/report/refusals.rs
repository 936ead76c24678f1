//! Why loops or trims cannot be cut or linked, before it is known of which face.

use glam::DVec2;
use std::fmt;

/// The windings along the lines of a tile do not add up: the loops cross a line unseen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tangled {
    /// The tile's middle.
    pub(crate) at: DVec2,
}

/// The arcs that bound the region do not close to loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoRegion {
    /// Where.
    pub at: DVec2,
}

impl fmt::Display for NoRegion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the trimming curves cannot be told apart around (u, v) = ({:.6}, {:.6})", self.at.x, self.at.y)
    }
}

impl std::error::Error for NoRegion {}
