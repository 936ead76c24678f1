//! Integers with keys -> their sums by key.

/// Sorts by key and sums what has the same key. Sums may be 0.
pub(crate) fn sums_by_key<K: Ord + Copy>(mut all: Vec<(K, i32)>) -> Vec<(K, i32)> {
    all.sort_unstable_by_key(|one| one.0);
    all.dedup_by(|next, first| {
        let same = next.0 == first.0;
        first.1 += if same { next.1 } else { 0 };
        same
    });
    all
}
