//! Items with keys -> their sums by key.

/// Sorts by key, and adds to the first item of each key those after it, in order.
pub(crate) fn summed_by<T, K: Ord>(mut all: Vec<T>, key: impl Fn(&T) -> K, add: impl Fn(&mut T, &T)) -> Vec<T> {
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

/// The sums of integers by key. Sums may be 0.
pub(crate) fn sums_by_key<K: Ord + Copy>(all: Vec<(K, i32)>) -> Vec<(K, i32)> {
    summed_by(all, |one| one.0, |sum, next| sum.1 += next.1)
}
