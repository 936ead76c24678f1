//! Lists whose items have keys or row numbers -> the items grouped, summed, matched or removed by them.

use std::collections::HashMap;
use std::hash::Hash;
use std::ops::Range;

/// Values sorted by small integer keys, by a counting sort; those of one key keep their order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Buckets<T> {
    /// Where the values of each key start.
    starts: Vec<u32>,
    values: Vec<T>,
}

impl<T: Copy + Default> Buckets<T> {
    /// Sorts values with keys below `count`, in two passes over `values`.
    pub(crate) fn of(count: usize, values: impl Iterator<Item = (u32, T)> + Clone) -> Self {
        // Counts are shifted by one more place: filling advances each start to where it belongs.
        let mut starts = vec![0_u32; count + 2];
        values.clone().for_each(|(k, _)| starts[k as usize + 2] += 1);
        (2..starts.len()).for_each(|k| starts[k] += starts[k - 1]);
        let mut sorted = vec![T::default(); starts[count + 1] as usize];
        for (k, value) in values {
            let at = &mut starts[k as usize + 1];
            sorted[*at as usize] = value;
            *at += 1;
        }
        Self { starts, values: sorted }
    }

    /// Estimated bytes.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.values[..])
    }

    /// Where the values of a key are among all; empty if no key is that large.
    #[inline]
    pub(crate) fn range(&self, k: u32) -> Range<usize> {
        match self.starts.get(k as usize..k as usize + 2) {
            Some(&[from, to]) => from as usize..to as usize,
            _ => 0..0,
        }
    }

    /// The values of a key; empty if no key is that large.
    #[inline]
    pub(crate) fn at(&self, k: u32) -> &[T] {
        &self.values[self.range(k)]
    }

    /// The values of a key, mutable.
    pub(crate) fn at_mut(&mut self, k: u32) -> &mut [T] {
        let range = self.range(k);
        &mut self.values[range]
    }
}

/// Sorts by key, and adds to the first item of each key those after it, in order.
fn summed_by<T, K: Ord>(mut all: Vec<T>, key: impl Fn(&T) -> K, add: impl Fn(&mut T, &T)) -> Vec<T> {
    all.sort_by_key(&key);
    all.dedup_by(|next, first| {
        let same = key(next) == key(first);
        if same {
            add(first, next);
        }
        same
    });
    all
}

/// [`summed_by`] of items whose keys are pairs. Cost: a look-up per item where the second number is below `count` and
/// always comes with the same first number. Other items are sorted, and the sums where first numbers differ.
pub(crate) fn summed_by_pair<T: Copy>(
    count: usize,
    all: impl IntoIterator<Item = T>,
    key: impl Fn(&T) -> (u32, u32),
    add: impl Fn(&mut T, &T),
) -> Vec<T> {
    let mut known: Vec<Option<T>> = vec![None; count];
    let mut others = Vec::new();
    for one in all {
        match known.get_mut(key(&one).1 as usize) {
            Some(Some(sum)) if key(sum) == key(&one) => add(sum, &one),
            Some(empty @ None) => *empty = Some(one),
            _ => others.push(one),
        }
    }
    let mut sums: Vec<T> = known.into_iter().flatten().chain(summed_by(others, &key, &add)).collect();
    if !sums.is_sorted_by_key(&key) {
        sums.sort_unstable_by_key(&key);
    }
    sums
}

/// The sums of integers by key. Sums may be 0.
pub(crate) fn sums_by_key<K: Ord + Copy>(all: Vec<(K, i32)>) -> Vec<(K, i32)> {
    summed_by(all, |one| one.0, |sum, next| sum.1 += next.1)
}

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

/// Removes the rows with these numbers, which ascend, and returns them. Later rows move up. Numbers beyond the end are
/// skipped. Cost: one pass from the first of them.
pub(crate) fn take_rows<T>(list: &mut Vec<T>, rows: &[usize]) -> Vec<T> {
    let Some(&first) = rows.first().filter(|first| **first < list.len()) else { return Vec::new() };
    let (mut row, mut left) = (first, rows.iter().peekable());
    let goes = |_: &mut T| {
        row += 1;
        left.next_if(|gone| **gone + 1 == row).is_some()
    };
    list.extract_if(first.., goes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_keep_their_order() {
        let mut buckets = Buckets::of(4, [(2, 'a'), (0, 'b'), (2, 'c'), (3, 'd')].into_iter());
        assert_eq!(
            [0, 1, 2, 3, 4].map(|k| buckets.at(k).to_vec()),
            [vec!['b'], vec![], vec!['a', 'c'], vec!['d'], vec![]]
        );
        buckets.at_mut(2).reverse();
        assert_eq!(buckets.at(2), ['c', 'a']);
        assert!(Buckets::<u32>::of(0, std::iter::empty()).at(0).is_empty());
    }

    #[test]
    fn rows_stay_where_they_can_and_none_is_given_twice() {
        assert_eq!(matched(&[1, 2, 3], &[1, 9, 2, 3]), [Some(0), None, Some(1), Some(2)]);
        assert_eq!(matched(&[1, 2, 3], &[3, 2]), [Some(2), Some(1)]);
        assert_eq!(matched(&[7, 7, 7], &[5, 7, 7, 7]), [None, Some(1), Some(2), Some(0)]);
        assert_eq!(matched(&[7, 7], &[7, 7, 7]), [Some(0), Some(1), None]);
        assert_eq!(matched(&[], &[1]), [None]);
    }

    #[test]
    fn rows_go_in_one_pass() {
        for (rows, gone, left) in [
            (&[][..], &[][..], &[10, 11, 12, 13][..]),
            (&[0], &[10], &[11, 12, 13]),
            (&[1, 2], &[11, 12], &[10, 13]),
            (&[0, 3, 7], &[10, 13], &[11, 12]),
            (&[4], &[], &[10, 11, 12, 13]),
        ] {
            let mut list = vec![10, 11, 12, 13];
            assert_eq!(take_rows(&mut list, rows), gone);
            assert_eq!(list, left);
        }
    }
}
