//! Two lists of keys -> which row of the one is which row of the other.

use std::collections::HashMap;
use std::hash::Hash;

/// For each row of `new`, the row of `old` with an equal key, if any is left: its own index if that has the key, else
/// the first one that no other row has. No row of `old` is given twice.
pub(crate) fn matched<K: Eq + Hash>(old: &[K], new: &[K]) -> Vec<Option<usize>> {
    let stays = |row: usize| old.get(row).is_some_and(|key| *key == new[row]);
    let mut left: HashMap<&K, Vec<usize>> = HashMap::new();
    for (row, key) in old.iter().enumerate().rev() {
        if row >= new.len() || !stays(row) {
            left.entry(key).or_default().push(row);
        }
    }
    let found = |(row, key)| if stays(row) { Some(row) } else { left.get_mut(key)?.pop() };
    new.iter().enumerate().map(found).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stay_where_they_can_and_none_is_given_twice() {
        assert_eq!(matched(&[1, 2, 3], &[1, 9, 2, 3]), [Some(0), None, Some(1), Some(2)]);
        assert_eq!(matched(&[1, 2, 3], &[3, 2]), [Some(2), Some(1)]);
        assert_eq!(matched(&[7, 7, 7], &[5, 7, 7, 7]), [None, Some(1), Some(2), Some(0)]);
        assert_eq!(matched(&[7, 7], &[7, 7, 7]), [Some(0), Some(1), None]);
        assert_eq!(matched(&[], &[1]), [None]);
    }
}
