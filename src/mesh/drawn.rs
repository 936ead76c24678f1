//! The set of drawn tiles per view and instance, one bit per tile.

use crate::model::TileId;

/// The tiles that each instance draws in each view. The default value has no rows and means: everything, in every view.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DrawnTiles {
    /// Start of each (view, instance) row in `words`, view-major, then the end.
    starts: Vec<u32>,
    instances: u32,
    words: Vec<u64>,
}

impl DrawnTiles {
    /// The empty set for `views` views; `tiles[i]` is the number of tiles of instance `i`.
    #[must_use]
    pub fn none(views: usize, tiles: &[usize]) -> Self {
        let mut drawn = Self::default();
        drawn.reset(views, tiles);
        drawn
    }

    /// Becomes [`none`](Self::none) of these arguments, and reuses the memory.
    pub fn reset(&mut self, views: usize, tiles: &[usize]) {
        self.starts.clear();
        self.words.clear();
        self.instances = tiles.len() as u32;
        let mut next = 0;
        self.starts.push(next);
        for _ in 0..views {
            for tiles in tiles {
                next += tiles.div_ceil(64) as u32;
                self.starts.push(next);
            }
        }
        self.words.resize(next as usize, 0);
    }

    /// Whether everything is drawn in every view.
    #[must_use]
    pub fn is_everything(&self) -> bool {
        self.starts.is_empty()
    }

    /// Number of views. 0 if [everything](Self::is_everything) is drawn.
    #[must_use]
    pub fn views(&self) -> usize {
        self.starts.len().saturating_sub(1) / (self.instances as usize).max(1)
    }

    fn row(&self, view: usize, instance: usize) -> std::ops::Range<usize> {
        let row = view * self.instances as usize + instance;
        self.starts[row] as usize..self.starts[row + 1] as usize
    }

    /// Whether a tile of an instance is drawn in a view.
    ///
    /// # Panics
    /// If the view, instance or tile is out of range, unless everything is drawn.
    #[must_use]
    pub fn contains(&self, view: usize, instance: usize, tile: TileId) -> bool {
        let tile = tile.0 as usize;
        self.is_everything() || self.words[self.row(view, instance)][tile >> 6] >> (tile & 63) & 1 == 1
    }

    /// Bits of tiles `64 k .. 64 k + 64` of an instance in a view, lowest bit first. All ones if everything is drawn.
    ///
    /// # Panics
    /// As [`contains`](Self::contains).
    #[must_use]
    pub fn word(&self, view: usize, instance: usize, k: usize) -> u64 {
        if self.is_everything() { u64::MAX } else { self.words[self.row(view, instance)][k] }
    }

    /// All words of an instance in a view, as [`word`](Self::word) has them. Empty if everything is drawn.
    pub(crate) fn words(&self, view: usize, instance: usize) -> &[u64] {
        if self.is_everything() { &[] } else { &self.words[self.row(view, instance)] }
    }

    /// Adds a tile of an instance to a view.
    ///
    /// # Panics
    /// As [`contains`](Self::contains), and if everything is drawn: there are no rows then.
    pub fn insert(&mut self, view: usize, instance: usize, tile: TileId) {
        let (row, tile) = (self.row(view, instance), tile.0 as usize);
        self.words[row][tile >> 6] |= 1 << (tile & 63);
    }

    /// Sets the bits of tiles `64 k ..` of an instance in a view, lowest bit of each word first.
    pub(crate) fn set_words(&mut self, view: usize, instance: usize, k: usize, words: &[u64]) {
        let row = self.row(view, instance);
        self.words[row][k..k + words.len()].copy_from_slice(words);
    }

    /// The drawn tiles of an instance in a view, ascending. Empty if everything is drawn: there are no rows then.
    pub fn tiles(&self, view: usize, instance: usize) -> impl Iterator<Item = TileId> + '_ {
        let row = if self.is_everything() { 0..0 } else { self.row(view, instance) };
        self.words[row].iter().enumerate().flat_map(|(k, &word)| tiles_of_word(word, k))
    }
}

/// The tiles whose bits are set in word number `k` of a row, ascending.
pub(crate) fn tiles_of_word(mut word: u64, k: usize) -> impl Iterator<Item = TileId> {
    std::iter::from_fn(move || {
        let bit = (word != 0).then(|| word.trailing_zeros())?;
        word &= word - 1;
        Some(TileId(64 * k as u32 + bit))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds_one_bit_per_tile_instance_and_view() {
        let mut drawn = DrawnTiles::none(2, &[70, 0, 3]);
        assert!(!drawn.is_everything() && drawn.views() == 2);
        for (view, instance, tile) in [(0, 0, 69), (1, 0, 0), (1, 0, 64), (1, 2, 2)] {
            drawn.insert(view, instance, TileId(tile));
            assert!(drawn.contains(view, instance, TileId(tile)));
        }
        let tiles = |view, instance| drawn.tiles(view, instance).map(|t| t.0).collect::<Vec<_>>();
        assert_eq!(
            [tiles(0, 0), tiles(0, 2), tiles(1, 0), tiles(1, 1), tiles(1, 2)],
            [vec![69], vec![], vec![0, 64], vec![], vec![2]]
        );
        assert_eq!((drawn.word(1, 0, 0), drawn.word(1, 0, 1)), (1, 1));
        drawn.reset(1, &[2]);
        assert_eq!(drawn, DrawnTiles::none(1, &[2]));
        assert!(DrawnTiles::default().contains(3, 7, TileId(9)) && DrawnTiles::default().views() == 0);
    }
}
