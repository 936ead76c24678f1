//! Values with small integer keys -> one list per key, contiguous in memory, by a counting sort.

use std::ops::Range;

/// Values sorted by key; those of one key keep their order.
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

    /// All values.
    pub(crate) fn all(&self) -> &[T] {
        &self.values
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
}
