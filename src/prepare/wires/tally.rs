//! What faces do with edges, use by use -> its sum for each shell and edge.

/// What one or more faces of a shell do with an edge.
pub(crate) trait EdgeSum: Copy {
    /// Shell and edge.
    fn key(&self) -> (u32, u32);
    /// Adds what is done with the same edge in the same shell, and was stated later.
    fn add(&mut self, next: &Self);
}

/// Adds up what faces do with edges, by shell and edge.
///
/// Cost: a look-up per use. Only uses of an edge by a further shell are sorted, and the sums if there are several shells.
pub(crate) struct Tally<T> {
    /// By edge: the sum of the first shell that uses it.
    first: Vec<Option<T>>,
    /// Uses by other shells, and of edges that do not exist.
    others: Vec<T>,
}

impl<T: EdgeSum> Tally<T> {
    /// No use so far of so many edges.
    pub(crate) fn new(edges: usize) -> Self {
        Self { first: vec![None; edges], others: Vec::new() }
    }

    /// Adds a use.
    pub(crate) fn add(&mut self, one: T) {
        let (shell, edge) = one.key();
        match self.first.get_mut(edge as usize) {
            Some(Some(known)) if known.key().0 == shell => known.add(&one),
            Some(empty @ None) => *empty = Some(one),
            _ => self.others.push(one),
        }
    }

    /// The sums that satisfy `is_wanted`, ascending by shell and edge.
    pub(crate) fn into_sums(self, is_wanted: impl Fn(&T) -> bool) -> Vec<T> {
        // One number compares faster than two.
        let number = |one: &T| u64::from(one.key().0) << 32 | u64::from(one.key().1);
        let Self { first, mut others } = self;
        // Uses of one edge stay in order.
        others.sort_by_key(number);
        others.dedup_by(|next, first| {
            let same = next.key() == first.key();
            if same {
                first.add(next);
            }
            same
        });
        let mut sums: Vec<T> = first.into_iter().flatten().filter(|sum| is_wanted(sum)).collect();
        sums.extend(others.into_iter().filter(|sum| is_wanted(sum)));
        if !sums.is_sorted_by_key(number) {
            sums.sort_unstable_by_key(number);
        }
        sums
    }
}
