//! A frame that is being uploaded.

use super::device_scene::{DevicePart, DevicePlace, DeviceScene};
use super::store::{Line, StoredTile};
use crate::mesh::DrawnTiles;
use crate::model::{EdgeId, PartId, TileId};

/// A frame that has begun and not ended, with what it has uploaded so far.
pub(super) struct Pending {
    pub(super) base: Base,
    /// Rows of the part's number, the tile, and its data.
    pub(super) tiles: Vec<(u32, TileId, Option<StoredTile>)>,
    pub(super) lines: Vec<(u32, EdgeId, Option<Line>)>,
    pub(super) drawn: DrawnTiles,
}

/// What a frame builds on.
pub(super) enum Base {
    /// A new scene. Each of its parts starts with the tiles and lines of a part that is drawn, or with none; all start
    /// with none where the list is empty.
    New(DeviceScene, Vec<Option<PartId>>),
    /// The frame that is drawn, with these instances.
    Instances(Vec<DevicePlace>),
    /// The frame that is drawn, with its instances but these: indices of [`DeviceScene::places`].
    Changes(Vec<(usize, DevicePlace)>),
}

impl Base {
    /// The parts of the frame. `shown` is the one that is drawn.
    pub(super) fn parts<'a>(&'a self, shown: &'a DeviceScene) -> &'a [DevicePart] {
        match self {
            Self::New(shown, _) => &shown.parts,
            Self::Instances(_) | Self::Changes(_) => &shown.parts,
        }
    }
}
