//! Reasons why loops or trims cannot be cut or linked, raised where the face is not known yet.

use glam::DVec2;
use std::fmt;

/// The winding numbers along the lines of a tile are inconsistent: a crossing of a loop with a line was missed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tangled {
    /// The tile's middle.
    pub(crate) at: DVec2,
}

/// The arcs that bound the region do not close to loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoRegion {
    /// Where, in (u,v).
    pub at: DVec2,
}

impl fmt::Display for NoRegion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the trimming curves cannot be told apart around (u, v) = ({:.6}, {:.6})", self.at.x, self.at.y)
    }
}

impl std::error::Error for NoRegion {}
