//! A frame on its way to the device: what it has put there so far.

use super::shown::{Place, Shown};
use super::store::{Line, Tile};
use crate::mesh::Drawn;
use crate::model::{EdgeId, TileId};

/// A frame that has begun.
pub(super) struct Pending {
    pub(super) base: Base,
    /// With the numbers of their parts.
    pub(super) tiles: Vec<(u32, TileId, Option<Tile>)>,
    pub(super) lines: Vec<(u32, EdgeId, Option<Line>)>,
    pub(super) drawn: Drawn,
}

/// What a frame's tiles are put into.
pub(super) enum Base {
    /// Nothing.
    Whole(Shown),
    /// The frame that is drawn, with these instances.
    Changes(Vec<Place>),
}
