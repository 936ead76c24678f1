//! The data section of a text -> its instances, parsed in pieces on all threads.
//!
//! The text is cut where an instance seems to start, near multiples of a length. Such a place may lie in a string or
//! a comment. But parsing from a place on depends on nothing before it: a piece counts if the one before it stopped
//! where it starts, and is parsed again from there if not. So the result is that of parsing from beginning to end.

use super::options::{StepError, proceed};
use super::records::{Fault, Parsed, Reach, parse, starts_instance};
use super::values::Row;
use crate::control::Call;
use crate::model::{SyntaxCut, SyntaxFault};
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Length of a piece, bytes. Cancelling takes effect between pieces.
pub(super) const PIECE: usize = 128 << 10;
/// Pieces longer than this are parsed one at a time: the values of open lists are held twice, and the bound on memory
/// counts that once.
const LONG: usize = 8 * PIECE;

/// What the data sections of a text state.
pub(super) struct Data {
    /// In the order of the text, with the indices of their pieces. No two instances have the same number.
    pub(super) pieces: Vec<Parsed>,
    /// In the order of the text.
    pub(super) faults: Vec<Fault>,
    /// Behind the end of the file.
    pub(super) end: usize,
}

/// Parses the data sections from byte `start` on, in pieces of about `size` bytes.
///
/// # Errors
/// [`StepError::Cancelled`].
pub(super) fn data(
    call: Call<'_>,
    text: &[u8],
    start: usize,
    size: usize,
    most_faults: usize,
) -> Result<Data, StepError> {
    let one_at_a_time = Mutex::new(());
    // Texts with many faults are refused. Then the rest of the pieces need not be parsed.
    let found = AtomicUsize::new(0);
    let parsed = call.each(1, ranges(text, start, size), |range| {
        let _turn = (range.len() > LONG).then(|| one_at_a_time.lock());
        proceed(call.control)?;
        let mut known = 0;
        Ok(parse(text, range, |faults| {
            let fresh = faults - std::mem::replace(&mut known, faults);
            fresh > 0 && found.fetch_add(fresh, Ordering::Relaxed) + fresh > most_faults
        }))
    });
    let mut data = Data { pieces: Vec::new(), faults: Vec::new(), end: start };
    let mut reach = Reach::Next;
    for piece in parsed {
        let mut piece = piece?;
        if reach != Reach::Next || piece.range.end <= data.end {
            continue;
        }
        if piece.range.start != data.end || piece.reach == Reach::Faults {
            proceed(call.control)?;
            let left = most_faults.saturating_sub(data.faults.len());
            piece = parse(text, data.end..piece.range.end, |faults| faults > left);
        }
        (data.end, reach) = (piece.stop, piece.reach);
        data.faults.append(&mut piece.faults);
        let index = u32::try_from(data.pieces.len()).unwrap_or(u32::MAX);
        piece.rows.iter_mut().for_each(|row| row.piece = index);
        data.pieces.push(piece);
    }
    data.drop_repeated(text, most_faults);
    Ok(data)
}

/// Where the pieces of the data section that starts at `start` are. The last one ends behind the text, so that the end
/// of the text is noticed in it.
fn ranges(text: &[u8], start: usize, size: usize) -> Vec<Range<usize>> {
    let mut ranges = Vec::new();
    let mut from = start;
    let mut at = start;
    loop {
        at = at.max(from.saturating_add(size));
        let end =
            text.get(at..).and_then(|rest| rest.iter().position(|byte| *byte == b';')).map(|length| at + length + 1);
        let Some(end) = end else { break };
        let next = text[end..].iter().position(|byte| !byte.is_ascii_whitespace()).map(|skip| end + skip);
        if next.is_some_and(|next| starts_instance(&text[next..])) {
            ranges.push(from..end);
            from = end;
        }
        at = end;
    }
    ranges.push(from..text.len() + 1);
    ranges
}

impl Data {
    /// Leaves out instances whose number an earlier one has. Reports no more of them than it takes to refuse the text.
    fn drop_repeated(&mut self, text: &[u8], most_faults: usize) {
        let rows = || self.pieces.iter().flat_map(|piece| &piece.rows);
        // Nearly all files are in order.
        if rows().is_sorted_by(|a, b| a.id < b.id) {
            return;
        }
        let place = |row: &Row| self.pieces[row.piece as usize].range.start + row.at as usize;
        let mut order: Vec<(u64, usize)> = rows().map(|row| (row.id, place(row))).collect();
        order.sort_unstable();
        let mut repeated = Vec::new();
        let mut first = (u64::MAX, 0);
        for (id, at) in order {
            if id == first.0 {
                repeated.push((at, id, first.1));
            } else {
                first = (id, at);
            }
        }
        repeated.sort_unstable();
        for piece in &mut self.pieces {
            let start = piece.range.start;
            let is_repeated =
                |row: &Row| repeated.binary_search_by_key(&(start + row.at as usize), |(at, ..)| *at).is_ok();
            piece.rows.retain(|row| !is_repeated(row));
        }
        let told = repeated.into_iter().take(most_faults.saturating_add(1));
        self.faults.extend(told.map(|(at, id, first)| {
            let fault = SyntaxFault::Repeated { id, first_line: position(text, first).0 };
            Fault { at, fault, cut: SyntaxCut::Instance(format!("#{id}")) }
        }));
        self.faults.sort_by_key(|fault| fault.at);
    }
}

/// Line and column of a byte of the text, counted from 1. A column is a character of UTF-8.
pub(super) fn position(text: &[u8], at: usize) -> (usize, usize) {
    let before = &text[..at.min(text.len())];
    let line = before.iter().rposition(|byte| *byte == b'\n').map_or(0, |found| found + 1);
    let column = before[line..].iter().filter(|byte| **byte & 0xC0 != 0x80).count();
    (before.iter().filter(|byte| **byte == b'\n').count() + 1, column + 1)
}
