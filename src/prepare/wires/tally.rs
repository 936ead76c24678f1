//! What faces do with edges, use by use -> its sum for each shell and edge.

/// What one or more faces of a shell do with an edge.
pub(crate) trait EdgeSum: Copy {
    /// Shell and edge.
    fn key(&self) -> (u32, u32);
    /// Adds what is done with the same edge in the same shell, and was stated later.
    fn add(&mut self, next: &Self);
}

/// Sums uses, ascending by shell and edge.
pub(crate) fn by_edge<T: EdgeSum>(mut uses: Vec<T>) -> Vec<T> {
    // One number compares faster than two. Uses of one edge stay in order.
    uses.sort_by_key(|one| u64::from(one.key().0) << 32 | u64::from(one.key().1));
    uses.dedup_by(|next, first| {
        let same = next.key() == first.key();
        if same {
            first.add(next);
        }
        same
    });
    uses
}
