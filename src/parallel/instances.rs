//! Names of a session's instances. Rows shift when an instance goes; keys do not.

use crate::math::rows::take_rows;
use slotmap::{DefaultKey, Key, KeyData, SlotMap};
use std::fmt;

/// Names an instance of a session. Stays the same when other instances come and go. Once the instance is removed, its
/// key names none, also after others were added; a key is given again only after 2³¹ instances had its place.
///
/// Means nothing to other sessions.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InstanceKey(DefaultKey);

impl InstanceKey {
    /// The key as a number, for other languages. Never 0.
    #[must_use]
    pub fn to_bits(self) -> u64 {
        self.0.data().as_ffi()
    }

    /// The key that this number stands for. Any number is allowed: most name no instance.
    #[must_use]
    pub fn from_bits(bits: u64) -> Self {
        let key = KeyData::from_ffi(bits);
        Self(if key.as_ffi() == bits { key.into() } else { DefaultKey::null() })
    }
}

/// Place and generation.
impl fmt::Debug for InstanceKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.data().fmt(f)
    }
}

/// The rows of a session's instances.
pub(super) struct Instances {
    rows: SlotMap<DefaultKey, usize>,
    /// By row.
    keys: Vec<InstanceKey>,
}

impl Instances {
    /// So many rows.
    pub(super) fn of(count: usize) -> Self {
        let mut new = Self { rows: SlotMap::new(), keys: Vec::new() };
        new.update(count);
        new
    }

    /// Replaces all rows. Keys of those before name none from now on.
    pub(super) fn update(&mut self, count: usize) {
        self.rows.clear();
        self.keys.clear();
        (0..count).for_each(|_| _ = self.push());
    }

    /// Appends a row.
    pub(super) fn push(&mut self) -> InstanceKey {
        let key = InstanceKey(self.rows.insert(self.keys.len()));
        self.keys.push(key);
        key
    }

    /// Removes rows, which ascend. Those of later instances decrease.
    pub(super) fn remove(&mut self, rows: &[usize]) {
        for key in take_rows(&mut self.keys, rows) {
            self.rows.remove(key.0);
        }
        let first = rows.first().map_or(self.keys.len(), |first| *first);
        for (row, key) in self.keys.iter().enumerate().skip(first) {
            self.rows.get_mut(key.0).into_iter().for_each(|known| *known = row);
        }
    }

    pub(super) fn row(&self, key: InstanceKey) -> Option<usize> {
        self.rows.get(key.0).copied()
    }

    pub(super) fn key(&self, row: usize) -> Option<InstanceKey> {
        self.keys.get(row).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_stay_while_rows_shift_and_are_not_given_twice() {
        let mut instances = Instances::of(4);
        let keys: Vec<InstanceKey> = (0..4).filter_map(|row| instances.key(row)).collect();
        instances.remove(&[1]);
        assert_eq!(keys.iter().map(|&key| instances.row(key)).collect::<Vec<_>>(), [Some(0), None, Some(1), Some(2)]);
        let new = instances.push();
        assert_eq!((instances.row(new), instances.key(3), instances.row(keys[1])), (Some(3), Some(new), None));
        assert!(!keys.contains(&new));
        for key in keys.iter().chain([&new]) {
            assert_eq!(InstanceKey::from_bits(key.to_bits()), *key);
        }
        instances.update(2);
        assert!(keys.iter().chain([&new]).all(|&key| instances.row(key).is_none()));
        assert_eq!([0, 1, 2].map(|row| instances.key(row).is_some()), [true, true, false]);
        assert_eq!([0, 1, u64::MAX].map(|bits| instances.row(InstanceKey::from_bits(bits))), [None; 3]);
    }
}
