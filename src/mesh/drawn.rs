//! The set of drawn tiles per view and instance, one bit per tile. Instances that draw nothing take no room.

use crate::math::bits::ones;
use crate::model::TileId;

/// The tiles that each instance draws in each view. The default value has no views and means: everything, in every
/// view.
///
/// Memory and the cost of comparing two of them follow what is drawn, not the number of instances.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DrawnTiles {
    /// `None` if everything is drawn.
    views: Option<u32>,
    /// Of the instances that draw any tile, ascending.
    rows: Vec<Row>,
    /// One row after the other, each up to its last word that is not 0.
    words: Vec<u64>,
}

/// What an instance draws in a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Row {
    view: u32,
    instance: u32,
    /// The end of its words. They start where those of the row before end.
    end: u32,
}

impl Row {
    fn key(&self) -> (usize, usize) {
        (self.view as usize, self.instance as usize)
    }
}

impl DrawnTiles {
    /// No tile of no view.
    pub const NONE: Self = Self { views: Some(0), rows: Vec::new(), words: Vec::new() };

    /// Becomes the empty set for `views` views, and reuses the memory.
    pub fn reset(&mut self, views: usize) {
        self.views = Some(views as u32);
        self.rows.clear();
        self.words.clear();
    }

    /// Becomes the tiles of `all` that `others` do not have, and reuses the memory. Both are of views. Cost: a pass
    /// over both.
    pub fn set_difference(&mut self, all: &Self, others: &Self) {
        self.reset(all.views());
        let mut others = others.rows().peekable();
        for (view, instance, words) in all.rows() {
            while others.next_if(|&(v, i, _)| (v, i) < (view, instance)).is_some() {}
            let same = others.next_if(|&(v, i, _)| (v, i) == (view, instance)).map_or(&[][..], |(.., words)| words);
            let start = self.words.len();
            let same = same.iter().chain(std::iter::repeat(&0));
            self.words.extend(words.iter().zip(same).map(|(word, same)| word & !same));
            let used = self.words[start..].iter().rposition(|&word| word != 0).map_or(0, |last| last + 1);
            self.words.truncate(start + used);
            if used > 0 {
                self.rows.push(Row { view: view as u32, instance: instance as u32, end: self.words.len() as u32 });
            }
        }
    }

    /// Removes instances, whose rows ascend. The rows of later ones decrease.
    pub(crate) fn remove_instances(&mut self, rows: &[usize]) {
        let before = std::mem::take(self);
        self.reset(before.views());
        for (view, instance, words) in before.rows() {
            let below = rows.partition_point(|row| *row < instance);
            if rows.get(below) != Some(&instance) {
                self.push(view, instance - below, 0, words);
            }
        }
    }

    /// Whether everything is drawn in every view.
    #[must_use]
    pub fn is_everything(&self) -> bool {
        self.views.is_none()
    }

    /// Number of views. 0 if [everything](Self::is_everything) is drawn.
    #[must_use]
    pub fn views(&self) -> usize {
        self.views.unwrap_or(0) as usize
    }

    /// The words of a row; none if a damaged recording says where they would be.
    fn words_of(&self, row: usize) -> &[u64] {
        let start = if row == 0 { 0 } else { self.rows[row - 1].end };
        self.words.get(start as usize..self.rows[row].end as usize).unwrap_or_default()
    }

    /// The words of an instance in a view, up to the last one that is not 0.
    fn words(&self, view: usize, instance: usize) -> &[u64] {
        let found = self.rows.binary_search_by_key(&(view, instance), Row::key);
        found.map_or(&[], |row| self.words_of(row))
    }

    /// Whether a tile of an instance is drawn in a view.
    #[must_use]
    pub fn contains(&self, view: usize, instance: usize, tile: TileId) -> bool {
        self.word(view, instance, tile.index() >> 6) >> (tile.0 & 63) & 1 == 1
    }

    /// Bits of tiles `64 k .. 64 k + 64` of an instance in a view, lowest bit first. All ones if everything is drawn.
    #[must_use]
    pub fn word(&self, view: usize, instance: usize, k: usize) -> u64 {
        if self.is_everything() { u64::MAX } else { self.words(view, instance).get(k).copied().unwrap_or(0) }
    }

    /// Adds tiles `64 k ..` of an instance in a view, lowest bit of each word first. Not all words are 0. Calls since
    /// [`reset`](Self::reset) are in ascending order of (view, instance, k), and their words do not overlap.
    ///
    /// # Panics
    /// If the words overlap.
    pub fn push(&mut self, view: usize, instance: usize, k: usize, words: &[u64]) {
        let used = words.iter().rposition(|&word| word != 0).map_or(0, |last| last + 1);
        if self.rows.last().is_none_or(|row| row.key() != (view, instance)) {
            self.rows.push(Row { view: view as u32, instance: instance as u32, end: self.words.len() as u32 });
        }
        let known = self.words_of(self.rows.len() - 1).len();
        assert!(known <= k, "words from {k} on, of which {known} are there");
        self.words.resize(self.words.len() + k - known, 0);
        self.words.extend(&words[..used]);
        let end = self.words.len() as u32;
        self.rows.last_mut().expect("a row").end = end;
    }

    /// The instances that draw something, ascending: view, instance, and its words, as [`word`](Self::word) has them,
    /// up to the last one that is not 0. Empty if everything is drawn.
    pub fn rows(&self) -> impl Iterator<Item = (usize, usize, &[u64])> {
        self.rows.iter().enumerate().map(|(k, row)| (row.view as usize, row.instance as usize, self.words_of(k)))
    }

    /// The instances that draw any tile in a view, ascending. Empty if everything is drawn.
    pub fn instances(&self, view: usize) -> impl Iterator<Item = usize> + '_ {
        let start = self.rows.partition_point(|row| (row.view as usize) < view);
        self.rows[start..].iter().take_while(move |row| row.view as usize == view).map(|row| row.instance as usize)
    }

    /// The drawn tiles of an instance in a view, ascending. Empty if everything is drawn.
    pub fn tiles(&self, view: usize, instance: usize) -> impl Iterator<Item = TileId> + '_ {
        self.words(view, instance).iter().enumerate().flat_map(|(k, &word)| tiles_of_word(word, k))
    }
}

/// The tiles whose bits are set in word number `k` of a row, ascending.
pub(crate) fn tiles_of_word(word: u64, k: usize) -> impl Iterator<Item = TileId> {
    ones(word).map(move |bit| TileId::new(64 * k + bit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;
    use std::collections::BTreeSet;

    #[test]
    fn holds_one_bit_per_tile_instance_and_view() {
        let mut drawn = DrawnTiles::default();
        assert!(drawn.contains(3, 7, TileId(9)) && drawn.is_everything() && drawn.views() == 0);
        drawn.reset(2);
        assert!(!drawn.is_everything() && drawn.views() == 2);
        let tiles = [(0, 0, 69), (0, 0, 300), (1, 0, 0), (1, 0, 64), (1, 2, 2)].map(|(v, i, t)| (v, i, TileId(t)));
        assert!(tiles.iter().all(|&(view, instance, tile)| !drawn.contains(view, instance, tile)));
        drawn.push(0, 0, 0, &[0, 1 << 5, 0]);
        drawn.push(0, 0, 4, &[1 << 44, 0]);
        drawn.push(1, 0, 0, &[1, 1]);
        drawn.push(1, 2, 0, &[4]);
        assert!(tiles.iter().all(|&(view, instance, tile)| drawn.contains(view, instance, tile)));
        let of = |view, instance| drawn.tiles(view, instance).map(|t| t.0).collect::<Vec<_>>();
        assert_eq!(
            [of(0, 0), of(0, 2), of(1, 0), of(1, 1), of(1, 2)],
            [vec![69, 300], vec![], vec![0, 64], vec![], vec![2]]
        );
        assert_eq!((drawn.word(1, 0, 0), drawn.word(1, 0, 1), drawn.word(1, 0, 2)), (1, 1, 0));
        let instances = [0, 1, 2].map(|view| drawn.instances(view).collect::<Vec<_>>());
        assert_eq!(instances, [vec![0], vec![0, 2], vec![]]);

        assert_eq!(drawn.rows().map(|(_, _, words)| words.len()).collect::<Vec<_>>(), [5, 2, 1]);

        drawn.reset(1);
        assert!(drawn.rows().next().is_none() && drawn.views() == 1);
    }

    #[test]
    fn damaged_rows_draw_nothing() {
        let row = |instance: u32, end: u32| Row { view: 0, instance, end };
        let mut drawn = DrawnTiles { views: Some(1), rows: vec![row(0, 1), row(1, 9), row(2, 1)], words: vec![1] };
        let of = |drawn: &DrawnTiles| [0, 1, 2].map(|instance| drawn.contains(0, instance, TileId(0)));
        assert_eq!(of(&drawn), [true, false, false]);
        drawn.remove_instances(&[0]);
        assert_eq!((of(&drawn), drawn.rows().count()), ([false; 3], 2));
    }

    type Tiles = BTreeSet<(usize, usize, u32)>;

    fn random(draw: &mut SplitMix) -> (DrawnTiles, Tiles) {
        let (mut drawn, views) = (DrawnTiles::NONE, draw.below(3) as usize);
        drawn.reset(views);
        let mut tiles = Tiles::new();
        for (view, instance) in (0..views).flat_map(|view| (0..5).map(move |instance| (view, instance))) {
            let words: Vec<u64> = (0..draw.below(4)).map(|_| draw.bits() & draw.bits() & draw.bits()).collect();
            if words.iter().any(|word| *word != 0) {
                drawn.push(view, instance, 0, &words);
                tiles.extend(drawn.tiles(view, instance).map(|tile| (view, instance, tile.0)));
            }
        }
        (drawn, tiles)
    }

    fn listed(drawn: &DrawnTiles) -> Tiles {
        let tiles = |(view, instance, _)| drawn.tiles(view, instance).map(move |tile| (view, instance, tile.0));
        drawn.rows().flat_map(tiles).collect()
    }

    #[test]
    fn differences_and_removals_are_those_of_sets() {
        let (mut draw, mut difference) = (SplitMix(79), DrawnTiles::default());
        for _ in 0..2000 {
            let ((a, of_a), (b, of_b)) = (random(&mut draw), random(&mut draw));
            difference.set_difference(&a, &b);
            assert_eq!(listed(&difference), &of_a - &of_b);
            assert!(difference.rows().all(|(_, _, words)| words.last().is_some_and(|word| *word != 0)));
            difference.set_difference(&a, &a);
            assert!(difference.rows().next().is_none() && difference.views() == a.views());
            let gone: Vec<usize> = (0..5).filter(|_| draw.below(3) == 0).collect();
            let mut left = a.clone();
            left.remove_instances(&gone);
            let below = |instance: usize| gone.iter().filter(|gone| **gone < instance).count();
            let stays = of_a.iter().filter(|(_, instance, _)| !gone.contains(instance));
            assert_eq!(listed(&left), stays.map(|&(v, i, t)| (v, i - below(i), t)).collect());
        }
    }
}
