//! The rows of a plan, in blocks: threads fill places for blocks side by side, free blocks side by side, and no row
//! moves.

use crate::prepare::internals::EDGES_PER_BOX;
use std::iter::{FilterMap, Flatten};
use std::ops::{Index, IndexMut};
use std::slice;
use std::sync::{Arc, OnceLock};

/// Rows of a block, so that each block of edges has one box. The last block of a part may have fewer.
pub(crate) const BLOCK: usize = EDGES_PER_BOX;

/// [`BLOCK`] rows, or those that are left.
type Block<T> = Vec<Arc<T>>;

/// A block, once a thread has filled it.
type Place<T> = OnceLock<Block<T>>;

/// One row per tile, or per edge, of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanRows<T>(Vec<Place<T>>);

/// References to rows in their order.
pub(crate) type Rows<'a, T> = Flatten<FilterMap<slice::Iter<'a, Place<T>>, fn(&'a Place<T>) -> Option<&'a Block<T>>>>;
/// The same, mutable.
pub(crate) type RowsMut<'a, T> =
    Flatten<FilterMap<slice::IterMut<'a, Place<T>>, fn(&'a mut Place<T>) -> Option<&'a mut Block<T>>>>;

impl<T> PlanRows<T> {
    /// Places for the blocks of so many rows, which threads [`fill`](Self::fill).
    pub(super) fn empty(rows: usize) -> Self {
        Self((0..rows.div_ceil(BLOCK)).map(|_| OnceLock::new()).collect())
    }

    /// Fills the place of the block that begins with this row. Does nothing if it is filled.
    pub(super) fn fill(&self, row: usize, block: Block<T>) {
        let _ = self.0[row / BLOCK].set(block);
    }

    /// Appends a block. All blocks before it are full.
    pub(crate) fn push_block(&mut self, block: Place<T>) {
        let len = |block: &Place<T>| block.get().map_or(0, Vec::len);
        debug_assert!(self.0.last().is_none_or(|last| len(last) == BLOCK) && (1..=BLOCK).contains(&len(&block)));
        self.0.push(block);
    }

    /// No rows, with room for so many.
    pub(crate) fn with_room(rows: usize) -> Self {
        Self(Vec::with_capacity(rows.div_ceil(BLOCK)))
    }

    /// The blocks in their order.
    pub(crate) fn blocks(&self) -> &[Place<T>] {
        &self.0
    }

    /// Takes the last blocks, so many if there are.
    pub(super) fn take_last(&mut self, blocks: usize) -> Self {
        Self(self.0.split_off(self.0.len().saturating_sub(blocks)))
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.last().map_or(0, |last| BLOCK * (self.0.len() - 1) + last.get().map_or(0, Vec::len))
    }

    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The rows in their order.
    pub fn iter(&self) -> Rows<'_, T> {
        self.into_iter()
    }
}

impl<'a, T> IntoIterator for &'a PlanRows<T> {
    type Item = &'a Arc<T>;
    type IntoIter = Rows<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter().filter_map(OnceLock::get as fn(_) -> _).flatten()
    }
}

impl<'a, T> IntoIterator for &'a mut PlanRows<T> {
    type Item = &'a mut Arc<T>;
    type IntoIter = RowsMut<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter_mut().filter_map(OnceLock::get_mut as fn(_) -> _).flatten()
    }
}

impl<T> FromIterator<Arc<T>> for PlanRows<T> {
    fn from_iter<I: IntoIterator<Item = Arc<T>>>(rows: I) -> Self {
        let mut rows = rows.into_iter();
        let mut out = Self::with_room(rows.size_hint().0);
        loop {
            let block: Vec<_> = rows.by_ref().take(BLOCK).collect();
            if block.is_empty() {
                return out;
            }
            out.push_block(block.into());
        }
    }
}

impl<T> Default for PlanRows<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Index<usize> for PlanRows<T> {
    type Output = Arc<T>;

    #[inline]
    fn index(&self, row: usize) -> &Arc<T> {
        &self.0[row / BLOCK].get().map_or(&[][..], |block| block)[row % BLOCK]
    }
}

impl<T> IndexMut<usize> for PlanRows<T> {
    fn index_mut(&mut self, row: usize) -> &mut Arc<T> {
        &mut self.0[row / BLOCK].get_mut().map_or(&mut [][..], |block| block)[row % BLOCK]
    }
}

/// As one list, whatever the blocks.
#[cfg(feature = "serde")]
impl<T: serde::Serialize> serde::Serialize for PlanRows<T> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeSeq as _;
        let mut list = serializer.serialize_seq(Some(self.len()))?;
        self.iter().try_for_each(|row| list.serialize_element(row))?;
        list.end()
    }
}

#[cfg(feature = "serde")]
impl<'de, T: serde::Deserialize<'de>> serde::Deserialize<'de> for PlanRows<T> {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Vec::deserialize(deserializer)?.into_iter().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_found_in_their_blocks() {
        for count in [0, 1, 63, 64, 65, 200] {
            let list: Vec<Arc<usize>> = (0..count).map(Arc::new).collect();
            let mut rows: PlanRows<usize> = list.iter().cloned().collect();
            assert_eq!((rows.len(), rows.is_empty()), (count, count == 0));
            assert!(rows.iter().eq(&list) && (0..count).all(|row| *rows[row] == row));
            if count > 64 {
                rows[64] = Arc::new(0);
                assert_eq!([63, 64].map(|row| *rows[row]), [63, 0]);
            }
            let all = count.div_ceil(64);
            assert_eq!(rows.blocks().len(), all);
            let last = rows.take_last(2);
            assert_eq!([&rows, &last].map(|rows| rows.blocks().len()), [all.saturating_sub(2), all.min(2)]);
            assert_eq!(rows.iter().chain(&last).count(), count);
        }
    }
}
