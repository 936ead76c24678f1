//! Tiles of instances to what their draws say: where the triangles are, which placement, which colour.

use super::super::ColourBy;
use super::super::layout::Record;
use super::super::palette::{MARKED, Painted, Palette};
use super::shown::ShownScene;
use crate::model::{FaceId, InstanceId};

/// The top bit of [`Record::first_index`].
const WIDE: u32 = 1 << 31;

/// A row for each tile of each instance: those of an instance follow one another in the order of tiles.
#[derive(Default)]
pub(super) struct Records {
    pub(super) rows: Vec<Record>,
    /// The first row of each place.
    firsts: Vec<u32>,
    palette: Palette,
    /// The instance and the face that stand out.
    marked: Option<(InstanceId, FaceId)>,
    all: bool,
    /// Parts and tiles whose rows are to be made again.
    stale: Vec<(u32, u32)>,
}

impl Records {
    /// Has a face of an instance stand out, and no other.
    pub(super) fn mark(&mut self, face: Option<(InstanceId, FaceId)>) {
        self.all |= self.marked != face;
        self.marked = face;
    }

    /// Has every row made again.
    pub(super) fn stale_all(&mut self) {
        self.all = true;
    }

    /// Has the rows of a tile made again. Frames that nobody draws do not pile up.
    pub(super) fn stale(&mut self, part: u32, tile: u32) {
        self.all |= self.stale.len() > self.rows.len();
        if self.all {
            self.stale.clear();
        } else {
            self.stale.push((part, tile));
        }
    }

    /// The row of a tile of a place.
    pub(super) fn row(&self, place: u32, tile: u32) -> u32 {
        self.firsts[place as usize] + tile
    }

    /// The place and the tile of a row.
    pub(super) fn tile_of(&self, row: u32) -> (u32, u32) {
        // Places without tiles start where the next one does.
        let place = self.firsts.partition_point(|&first| first <= row) - 1;
        (place as u32, row - self.firsts[place])
    }

    /// Brings the rows up to date; says which of them have changed.
    pub(super) fn refresh(&mut self, shown: &ShownScene, by: ColourBy) -> std::ops::Range<usize> {
        let palette = Palette::new(by, shown.tiles().map(|tile| tile.rate));
        let grown = || self.stale.iter().any(|&(part, tile)| self.is_beyond(shown, part, tile));
        if self.all || palette != self.palette || grown() {
            self.palette = palette;
            return self.refresh_all(shown);
        }
        let (mut first, mut end) = (usize::MAX, 0);
        for (part, tile) in std::mem::take(&mut self.stale) {
            for place in shown.parts[part as usize].places.clone() {
                let row = self.row(place, tile) as usize;
                self.rows[row] = self.made(shown, place, tile);
                (first, end) = (first.min(row), end.max(row + 1));
            }
        }
        first.min(end)..end
    }

    fn refresh_all(&mut self, shown: &ShownScene) -> std::ops::Range<usize> {
        (self.all, self.stale) = (false, Vec::new());
        self.firsts.clear();
        self.rows.clear();
        for (number, place) in shown.places.iter().enumerate() {
            self.firsts.push(self.rows.len() as u32);
            for tile in 0..shown.parts[place.part as usize].tiles.len() {
                self.rows.push(self.made(shown, number as u32, tile as u32));
            }
        }
        0..self.rows.len()
    }

    /// Whether a part has more tiles than there are rows for.
    fn is_beyond(&self, shown: &ShownScene, part: u32, tile: u32) -> bool {
        shown.parts[part as usize].places.clone().any(|place| {
            let end = self.firsts.get(place as usize + 1).copied().unwrap_or(self.rows.len() as u32);
            self.firsts.get(place as usize).is_none_or(|first| first + tile >= end)
        })
    }

    /// The row of a tile; of nothing where it has no triangles.
    fn made(&self, shown: &ShownScene, place: u32, number: u32) -> Record {
        let at = &shown.places[place as usize];
        let part = &shown.parts[at.part as usize];
        let Some(tile) = &part.tiles[number as usize] else { return Record::default() };
        let marked = self.marked == Some((InstanceId(at.instance), tile.face));
        let painted = Painted {
            part: part.number,
            face: at.first_face.wrapping_add(tile.face.0),
            tile: number,
            worker: tile.worker,
            rate: tile.rate,
            own: at.colour.or(part.face_colours.get(tile.face.index()).copied().flatten()),
        };
        Record {
            first_index: tile.first_index() | if tile.wide { WIDE } else { 0 },
            base_vertex: tile.vertices.start(),
            place,
            colour: if marked { MARKED } else { self.palette.of(&painted) },
        }
    }
}
