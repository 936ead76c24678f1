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
