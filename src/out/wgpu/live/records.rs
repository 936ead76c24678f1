//! Tiles of instances to per-draw records: range of indices, placement, colour.

use super::super::ColourBy;
use super::super::gpu::Gpu;
use super::super::palette::{MARKED, Palette, TileColours};
use super::super::pipelines::{INSTANCE_FORMAT, RECORD_FORMAT, Record};
use super::device_scene::DeviceScene;
use super::rows::{Rows, Texels};
use crate::model::{FaceId, InstanceId};
use ::wgpu::{Buffer, BufferUsages, TextureView};
use std::ops::Range;

/// The top bit of [`Record::first_index`].
const WIDE: u32 = 1 << 31;

/// What is known of an instance: its number in the scene, its part's in the model, its first record, and nothing.
type InstanceRow = [u32; 4];

/// Which number of an [`InstanceRow`] is the first record.
const FIRST: usize = 2;

/// Whose rows are outdated.
pub(super) enum Stale {
    /// Those of a tile of a part.
    Tile(u32, u32),
    /// Those of a place, of which the colour has changed.
    Place(u32),
}

/// One record per tile of each instance, ordered by place, then tile.
#[derive(Default)]
pub(super) struct Records {
    pub(super) rows: Vec<Record>,
    /// By place.
    pub(super) instances: Vec<InstanceRow>,
    palette: Palette,
    /// The highlighted face.
    marked: Option<(InstanceId, FaceId)>,
    /// All rows are outdated.
    all: bool,
    /// Whose rows are outdated.
    stale: Vec<Stale>,
    /// Counts changes of `instances`, and of the frame's instances, which `instances` follow with the next refresh.
    pub(super) layout: u64,
}

impl Records {
    /// Sets the highlighted face.
    pub(super) fn mark(&mut self, face: Option<(InstanceId, FaceId)>) {
        self.all |= self.marked != face;
        self.marked = face;
    }

    /// Marks all rows as outdated.
    pub(super) fn stale_all(&mut self) {
        self.all = true;
    }

    /// Marks all rows as outdated, because instances came or went.
    pub(super) fn leave_instances(&mut self) {
        self.stale_all();
        self.layout += 1;
    }

    /// Marks rows as outdated. The list stays bounded if nothing is drawn for many frames.
    pub(super) fn stale(&mut self, whose: Stale) {
        self.all |= self.stale.len() > self.rows.len() + self.instances.len();
        if self.all {
            self.stale.clear();
        } else {
            self.stale.push(whose);
        }
    }

    /// The row of a tile at a place.
    pub(super) fn row(&self, place: u32, tile: u32) -> u32 {
        self.instances[place as usize][FIRST] + tile
    }

    /// The place and the tile of a row.
    pub(super) fn tile_of(&self, row: u32) -> (u32, u32) {
        // The last of several places with the same first row: those before it have no tiles.
        let place = self.instances.partition_point(|instance| instance[FIRST] <= row) - 1;
        (place as u32, row - self.instances[place][FIRST])
    }

    /// Rebuilds outdated rows. Returns the range of rows that changed.
    pub(super) fn refresh(&mut self, shown: &DeviceScene, by: ColourBy) -> std::ops::Range<usize> {
        let palette = Palette::new(by, shown.tiles().map(|tile| tile.rate));
        let grown = || self.stale.iter().any(|whose| self.is_beyond(shown, whose));
        if self.all || palette != self.palette || grown() {
            self.palette = palette;
            return self.refresh_all(shown);
        }
        let (mut first, mut end) = (usize::MAX, 0);
        for whose in std::mem::take(&mut self.stale) {
            let (places, tiles) = match whose {
                Stale::Tile(part, tile) => (shown.parts[part as usize].places.clone(), tile..tile + 1),
                Stale::Place(place) => (place..place + 1, 0..self.end(place) - self.row(place, 0)),
            };
            for (place, tile) in places.flat_map(|place| tiles.clone().map(move |tile| (place, tile))) {
                let row = self.row(place, tile) as usize;
                self.rows[row] = self.made(shown, place, tile);
                (first, end) = (first.min(row), end.max(row + 1));
            }
        }
        first.min(end)..end
    }

    /// The end of the rows of a place.
    fn end(&self, place: u32) -> u32 {
        self.instances.get(place as usize + 1).map_or(self.rows.len() as u32, |next| next[FIRST])
    }

    fn refresh_all(&mut self, shown: &DeviceScene) -> std::ops::Range<usize> {
        (self.all, self.stale) = (false, Vec::new());
        let before = std::mem::take(&mut self.instances);
        self.rows.clear();
        for (number, place) in shown.places.iter().enumerate() {
            let part = &shown.parts[place.part as usize];
            self.instances.push([place.instance, part.number, self.rows.len() as u32, 0]);
            for tile in 0..part.tiles.len() {
                self.rows.push(self.made(shown, number as u32, tile as u32));
            }
        }
        self.layout += u64::from(before != self.instances);
        0..self.rows.len()
    }

    /// Whether some place of the part has no row for a tile.
    fn is_beyond(&self, shown: &DeviceScene, whose: &Stale) -> bool {
        let &Stale::Tile(part, tile) = whose else { return false };
        shown.parts[part as usize].places.clone().any(|place| {
            let first = self.instances.get(place as usize).map(|instance| instance[FIRST]);
            first.is_none_or(|first| first + tile >= self.end(place))
        })
    }

    /// Makes the record of a tile at a place. Tiles without triangles get the default record.
    fn made(&self, shown: &DeviceScene, place: u32, number: u32) -> Record {
        let at = &shown.places[place as usize];
        let part = &shown.parts[at.part as usize];
        let Some(tile) = &part.tiles[number as usize] else { return Record::default() };
        let marked = self.marked == Some((InstanceId(at.instance), tile.face));
        let painted = TileColours {
            part: part.number,
            face: at.first_face.wrapping_add(tile.face.0),
            tile: number,
            worker: tile.worker,
            rate: tile.rate,
            own: at.colour.or(part.face_colours.get(tile.face.index()).copied().flatten()),
        };
        Record {
            first_index: tile.indices().map_or(0, |(_, wide, first)| first | if wide { WIDE } else { 0 }),
            base_vertex: tile.vertices.start(),
            place,
            colour: if marked { MARKED } else { self.palette.of(&painted) },
            face: tile.face.0,
        }
    }
}

/// Records on the device, and what is known of instances.
pub(super) struct RecordRows {
    rows: RowsOfTiles,
    instances: Texels,
    /// [`Records::layout`] that `instances` has; `None` before the first.
    layout: Option<u64>,
}

enum RowsOfTiles {
    /// Read as an attribute of the draw.
    PerDraw(Rows),
    /// Colours and faces, read by the instance's first row and the tile of the vertex.
    Merged(Texels),
}

impl RecordRows {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let rows = if gpu.indirect {
            RowsOfTiles::PerDraw(Rows::new(BufferUsages::VERTEX))
        } else {
            RowsOfTiles::Merged(Texels::new(RECORD_FORMAT))
        };
        Self { rows, instances: Texels::new(INSTANCE_FORMAT), layout: None }
    }

    /// Uploads the `changed` records, and instances if any changed. Returns the number of bytes uploaded.
    pub(super) fn write(&mut self, gpu: &Gpu, records: &Records, changed: Range<usize>) -> u64 {
        let mut bytes = 0;
        if self.layout.replace(records.layout) != Some(records.layout) {
            bytes += self.instances.write(gpu, &records.instances, 0..records.instances.len());
        }
        bytes += match &mut self.rows {
            RowsOfTiles::PerDraw(rows) => rows.write(gpu, &records.rows, changed),
            RowsOfTiles::Merged(texels) if changed.is_empty() && texels.view().is_some() => 0,
            RowsOfTiles::Merged(texels) => {
                let row = |record: &Record| [u32::from_le_bytes(record.colour), record.face];
                let rows: Vec<[u32; 2]> = records.rows.iter().map(row).collect();
                texels.write(gpu, &rows, changed)
            }
        };
        bytes
    }

    /// The records of draws, a vertex buffer. `None` where tiles are merged.
    pub(super) fn buffer(&self) -> Option<&Buffer> {
        match &self.rows {
            RowsOfTiles::PerDraw(rows) => rows.buffer(),
            RowsOfTiles::Merged(_) => None,
        }
    }

    /// What is bound: instances, and records where tiles are merged.
    pub(super) fn views(&self) -> impl Iterator<Item = &TextureView> {
        let records = match &self.rows {
            RowsOfTiles::PerDraw(_) => None,
            RowsOfTiles::Merged(texels) => texels.view(),
        };
        self.instances.view().into_iter().chain(records)
    }

    pub(super) fn bytes(&self) -> u64 {
        let rows = match &self.rows {
            RowsOfTiles::PerDraw(rows) => rows.bytes(),
            RowsOfTiles::Merged(texels) => texels.bytes(),
        };
        rows + self.instances.bytes()
    }
}
