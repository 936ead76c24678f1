//! Names of a session's instances. Rows shift when an instance goes; keys do not.

use crate::model::PartId;
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
    /// The model's part of each row, whatever its current LOD.
    parts: Vec<PartId>,
}

impl Instances {
    /// Instances of these parts, in the order of their rows.
    pub(super) fn of(parts: impl Iterator<Item = PartId>) -> Self {
        let mut new = Self { rows: SlotMap::new(), keys: Vec::new(), parts: Vec::new() };
        new.update(parts);
        new
    }

    /// Replaces all rows. Keys of those before name none from now on.
    pub(super) fn update(&mut self, parts: impl Iterator<Item = PartId>) {
        self.rows.clear();
        self.keys.clear();
        self.parts.clear();
        parts.for_each(|part| _ = self.push(part));
    }

    /// Appends a row.
    pub(super) fn push(&mut self, part: PartId) -> InstanceKey {
        let key = InstanceKey(self.rows.insert(self.keys.len()));
        self.keys.push(key);
        self.parts.push(part);
        key
    }

    /// Removes a row. Those of later instances decrease by one.
    pub(super) fn remove(&mut self, row: usize) {
        self.rows.remove(self.keys.remove(row).0);
        self.parts.remove(row);
        for key in &self.keys[row..] {
            self.rows.get_mut(key.0).into_iter().for_each(|row| *row -= 1);
        }
    }

    pub(super) fn row(&self, key: InstanceKey) -> Option<usize> {
        self.rows.get(key.0).copied()
    }

    pub(super) fn key(&self, row: usize) -> Option<InstanceKey> {
        self.keys.get(row).copied()
    }

    pub(super) fn part(&self, row: usize) -> Option<PartId> {
        self.parts.get(row).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_stay_while_rows_shift_and_are_not_given_twice() {
        let mut instances = Instances::of((0..4).map(PartId));
        let keys: Vec<InstanceKey> = (0..4).filter_map(|row| instances.key(row)).collect();
        instances.remove(1);
        assert_eq!(keys.iter().map(|&key| instances.row(key)).collect::<Vec<_>>(), [Some(0), None, Some(1), Some(2)]);
        assert_eq!(
            [0, 1, 2, 3].map(|row| instances.part(row)),
            [0, 2, 3, 9].map(PartId).map(|p| (p.0 < 9).then_some(p))
        );
        let new = instances.push(PartId(7));
        assert_eq!((instances.row(new), instances.key(3), instances.row(keys[1])), (Some(3), Some(new), None));
        assert!(!keys.contains(&new));
        for key in keys.iter().chain([&new]) {
            assert_eq!(InstanceKey::from_bits(key.to_bits()), *key);
        }
        instances.update([4, 5].map(PartId).into_iter());
        assert!(keys.iter().chain([&new]).all(|&key| instances.row(key).is_none()));
        assert_eq!([0, 1, 2].map(|row| instances.part(row)), [Some(PartId(4)), Some(PartId(5)), None]);
        assert_eq!([0, 1, u64::MAX].map(|bits| instances.row(InstanceKey::from_bits(bits))), [None; 3]);
    }
}
