//! Numbers of rows of parts -> lists of rows for the threads of a plan.

use super::rows::BLOCK;
use std::ops::Range;

/// Rows of parts: from a part and the number of its row up to another.
pub(super) type Span = Range<(usize, usize)>;

/// A part, and some of its rows.
pub(super) type Stretch = (usize, Range<usize>);

/// All rows of some of the parts in lists that become shorter, down to [`BLOCK`]: few lists, and threads that end at
/// about the same time. Parts are cut between blocks. All in one list if there is one thread. `counts`: numbers of rows
/// of all parts.
pub(super) fn lists(threads: usize, parts: Range<usize>, counts: &[usize]) -> Vec<Span> {
    /// The size of a list: as if the rows left were cut into so many equal lists per thread.
    const PER_THREAD: usize = 2;
    let size = |left: usize| if threads == 1 { usize::MAX } else { BLOCK.max(left / (PER_THREAD * threads)) };
    let mut left = counts[parts.clone()].iter().sum();
    let (mut lists, mut begin, mut room) = (Vec::new(), (parts.start, 0), size(left));
    for part in parts {
        let (count, mut from) = (counts[part], 0_usize);
        while from < count {
            let to = count.min(from.saturating_add(room.div_ceil(BLOCK).saturating_mul(BLOCK)));
            (room, left) = (room.saturating_sub(to - from), left - (to - from));
            from = to;
            if room == 0 || left == 0 {
                lists.push(begin..(part, to));
                (begin, room) = ((part, to), size(left));
            }
        }
    }
    lists
}

/// The rows of a list by part, for the same `counts`.
pub(super) fn stretches(list: Span, counts: &[usize]) -> impl Iterator<Item = Stretch> {
    let Range { start, end } = list;
    let rows = move |part| {
        let from = if part == start.0 { start.1 } else { 0 };
        (part, from..if part == end.0 { end.1 } else { counts[part] })
    };
    (start.0..=end.0).map(rows).filter(|(_, rows)| !rows.is_empty())
}
