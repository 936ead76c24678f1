//! Rows of parts -> lists for the threads of a plan.

use super::rows::BLOCK;
use std::ops::Range;

/// A part, and some of its tiles or edges.
pub(super) type Stretch = (usize, Range<usize>);

/// The tiles or edges of parts, in lists that become shorter, down to [`BLOCK`]: few lists, and threads that end at
/// about the same time. Parts are cut between blocks. All in one list if there is one thread.
#[derive(Debug)]
pub(super) struct Lists {
    stretches: Vec<Stretch>,
    /// Where each list is among them.
    ranges: Vec<Range<usize>>,
}

impl Lists {
    /// Lists for so many threads. `counts`: parts, and their numbers of rows.
    pub(super) fn of(threads: usize, counts: &[(usize, usize)]) -> Self {
        /// Part of a thread's share of what is left that the next list is.
        const SHARE: usize = 2;
        let size = |left: usize| if threads == 1 { usize::MAX } else { BLOCK.max(left / (SHARE * threads)) };
        let mut left = counts.iter().map(|(_, count)| count).sum();
        let (mut stretches, mut ranges, mut room) = (Vec::with_capacity(2 * counts.len()), Vec::new(), size(left));
        let mut first = 0;
        for &(part, count) in counts {
            let mut from: usize = 0;
            while from < count {
                let to = count.min(from.saturating_add(room.div_ceil(BLOCK).saturating_mul(BLOCK)));
                stretches.push((part, from..to));
                (room, left) = (room.saturating_sub(to - from), left - (to - from));
                from = to;
                if room == 0 {
                    ranges.push(first..stretches.len());
                    (first, room) = (stretches.len(), size(left));
                }
            }
        }
        ranges.extend((first < stretches.len()).then_some(first..stretches.len()));
        Self { stretches, ranges }
    }

    /// Numbers of the lists.
    pub(super) fn numbers(&self) -> Vec<usize> {
        (0..self.ranges.len()).collect()
    }

    /// A list.
    pub(super) fn list(&self, number: usize) -> &[Stretch] {
        &self.stretches[self.ranges[number].clone()]
    }
}
