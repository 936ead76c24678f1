//! The data section of a text -> its instances, parsed in pieces on all threads.
//!
//! The text is cut where an instance seems to start, near multiples of a length. Such a place may lie in a string or
//! a comment. But parsing from a place on depends on nothing before it. A piece counts if the one before it stopped
//! where it starts, and if all its records are sound and end within it. Else it is parsed again, with all that follows
//! at hand. So the result is that of parsing from beginning to end.

use super::options::{StepError, proceed};
use super::records::{Fault, Parsed, Reach, parse, starts_instance};
use super::token::next_ink;
use super::values::Row;
use crate::control::Call;
use crate::model::{SyntaxCut, SyntaxFault};
use std::ops::Range;
use std::sync::Mutex;

/// Length of a piece up to the end of an instance, bytes, unless shorter ones are worth it. Cancelling takes effect
/// between pieces.
pub(super) const PIECE: usize = 128 << 10;
/// Length that is worth a piece of its own, bytes.
const SHORT: usize = PIECE / 8;
/// Pieces longer than this are parsed one at a time: the values of open lists are held twice, and the bound on memory
/// counts that once.
const LONG: usize = 8 * PIECE;

/// What the data sections of a text state.
pub(super) struct Data {
    /// In the order of the text. No two instances have the same number.
    pub(super) pieces: Vec<Parsed>,
    /// Whether the numbers of instances ascend through all of them.
    pub(super) is_in_order: bool,
    /// In the order of their records.
    pub(super) faults: Vec<Fault>,
    /// Behind the end of the file.
    pub(super) end: usize,
}

/// Length of the pieces of a text of `length` bytes: short enough that all threads end at about the same time.
pub(super) fn piece(length: usize, threads: usize) -> usize {
    /// Pieces that each thread gets.
    const PIECES: usize = 32;
    if threads == 1 { PIECE } else { (length / (PIECES * threads)).clamp(SHORT, PIECE) }
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
    let guessed = call.each(1, ranges(text, start, size), |range| {
        let _turn = (range.len() > LONG).then(|| one_at_a_time.lock());
        proceed(call.control)?;
        // A guess that starts in a string could read to the end of the text, and so could all others.
        Ok(parse(&text[..range.end.min(text.len())], range, 0))
    });
    let mut data = Data { pieces: Vec::new(), is_in_order: true, faults: Vec::new(), end: start };
    let mut reach = Reach::Next;
    let mut last = None;
    for piece in guessed {
        proceed(call.control)?;
        let mut piece = piece?;
        if reach != Reach::Next || piece.range.end <= data.end {
            continue;
        }
        if piece.range.start != data.end || !piece.faults.is_empty() {
            piece = parse(text, data.end..piece.range.end, most_faults.saturating_sub(data.faults.len()));
        }
        (data.end, reach) = (piece.stop, piece.reach);
        data.faults.append(&mut piece.faults);
        if let [first, ..] = piece.rows[..] {
            data.is_in_order &= piece.is_in_order && last < Some(first.id);
            last = piece.rows.last().map(|row| row.id);
        }
        data.pieces.push(piece);
    }
    // Nearly all files are in order.
    if !data.is_in_order {
        data.drop_repeated(text, most_faults);
    }
    Ok(data)
}

/// Cuts the data section at `start` into pieces. The last one ends behind the text, so that the end of the text is
/// noticed in it.
fn ranges(text: &[u8], start: usize, size: usize) -> Vec<Range<usize>> {
    let mut ranges = Vec::new();
    let mut from = start;
    let mut at = start;
    loop {
        at = at.max(from.saturating_add(size));
        let end =
            text.get(at..).and_then(|rest| rest.iter().position(|byte| *byte == b';')).map(|length| at + length + 1);
        let Some(end) = end else { break };
        if next_ink(text, end).is_some_and(|next| starts_instance(&text[next..])) {
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
        let mut order: Vec<(u64, usize)> = Vec::new();
        for Parsed { range, rows, .. } in &self.pieces {
            order.extend(rows.iter().map(|row| (row.id, range.start + row.at as usize)));
        }
        order.sort_unstable();
        let mut repeated = Vec::new();
        let mut first: Option<(u64, usize)> = None;
        for (id, at) in order {
            match first {
                Some((known, place)) if known == id => repeated.push((at, id, place)),
                _ => first = Some((id, at)),
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
            Fault { start: at, at, fault, cut: SyntaxCut::Instance(format!("#{id}")) }
        }));
        self.faults.sort_by_key(|fault| fault.start);
    }
}

/// Line and column of a byte of the text, counted from 1. A column is a character of UTF-8.
pub(super) fn position(text: &[u8], at: usize) -> (usize, usize) {
    let before = &text[..at.min(text.len())];
    let line = before.iter().rposition(|byte| *byte == b'\n').map_or(0, |found| found + 1);
    let column = before[line..].iter().filter(|byte| **byte & 0xC0 != 0x80).count();
    (before.iter().filter(|byte| **byte == b'\n').count() + 1, column + 1)
}
