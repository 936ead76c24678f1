//! Reasons why loops or trims cannot be cut or linked, raised where the face is not known yet.

use glam::DVec2;

/// The winding numbers along the lines of a tile are inconsistent: a crossing of a loop with a line was missed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tangled {
    /// The tile's middle.
    pub(crate) at: DVec2,
}

/// The arcs that bound the region do not close to loops.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the trimming curves cannot be told apart around (u, v) = ({:.6}, {:.6})", .at.x, .at.y)]
pub struct NoRegion {
    /// Where, in (u,v).
    pub at: DVec2,
}
