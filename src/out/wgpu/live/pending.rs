//! A frame on its way to the device: what it has put there so far.

use super::shown::{ShownPlace, ShownScene};
use super::store::{Line, StoredTile};
use crate::mesh::Drawn;
use crate::model::{EdgeId, TileId};

/// A frame that has begun.
pub(super) struct Pending {
    pub(super) base: Base,
    /// With the numbers of their parts.
    pub(super) tiles: Vec<(u32, TileId, Option<StoredTile>)>,
    pub(super) lines: Vec<(u32, EdgeId, Option<Line>)>,
    pub(super) drawn: Drawn,
}

/// What a frame's tiles are put into.
pub(super) enum Base {
    /// Nothing.
    Whole(ShownScene),
    /// The frame that is drawn, with these instances.
    Changes(Vec<ShownPlace>),
}
