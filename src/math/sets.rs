//! Disjoint sets of integers (Galler and Fischer 1964), with path halving.

/// A partition of the integers `0..len`.
#[derive(Clone, Debug, Default)]
pub(crate) struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// Every integer below `count` in a set of its own.
    pub(crate) fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// Number of integers, not of sets.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// Adds the next integer in a set of its own and returns it.
    #[cfg(any(test, feature = "step"))]
    pub(crate) fn push(&mut self) -> u32 {
        let next = self.0.len() as u32;
        self.0.push(next);
        next
    }

    /// The representative of the set that contains `at`.
    pub(crate) fn root(&mut self, at: u32) -> u32 {
        let mut at = at;
        while self.0[at as usize] != at {
            let above = self.0[self.0[at as usize] as usize];
            self.0[at as usize] = above;
            at = above;
        }
        at
    }

    /// Merges two sets. The smaller of their roots becomes the root.
    pub(crate) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_numbers_have_one_root() {
        let mut sets = DisjointSets::new(6);
        sets.join(4, 2);
        sets.join(5, 4);
        assert_eq!((0..6).map(|k| sets.root(k)).collect::<Vec<_>>(), [0, 1, 2, 3, 2, 2]);
        assert_eq!((sets.push(), sets.len()), (6, 7));
    }
}
