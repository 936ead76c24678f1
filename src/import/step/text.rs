//! Part 21 bytes -> an instance table, parsed in pieces on all threads. Instances with syntax errors are left out one
//! at a time, so that one bad line does not cost the file.
//!
//! The data section is cut where an instance seems to start, near multiples of a length. Such a place may lie in a
//! string or a comment. But parsing from a place on depends on nothing before it. A piece counts if the one before it
//! stopped where it starts, and if all its records are sound and end within it. Else it is parsed again, with all that
//! follows at hand. So the result is that of parsing from beginning to end.

use super::budget::ReadBudget;
use super::options::{BYTES_PER_BYTE, StepError, StepOptions, proceed};
use super::records::{self, Fault, LISTED_REPAIRS, Parsed, Reach, starts_instance};
use super::sections::{Prologue, epilogue, find};
use super::table::Table;
use super::token::next_ink;
use super::values::Row;
use crate::control::{Call, Control};
use crate::model::{Diagnostic, Severity, StepOutcome, SyntaxCut, SyntaxError, SyntaxFault};
use std::borrow::Cow;
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
struct Data {
    /// In the order of the text. No two instances have the same number.
    pieces: Vec<Parsed>,
    /// Whether the numbers of instances ascend through all of them.
    is_in_order: bool,
    /// In the order of their records.
    faults: Vec<Fault>,
    /// Behind the end of the file.
    end: usize,
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
fn data(call: Call<'_>, text: &[u8], start: usize, size: usize, most_faults: usize) -> Result<Data, StepError> {
    let one_at_a_time = Mutex::new(());
    let guessed = call.each(1, ranges(text, start, size), |range| {
        let _turn = (range.len() > LONG).then(|| one_at_a_time.lock());
        proceed(call.control)?;
        // A guess that starts in a string could read to the end of the text, and so could all others.
        Ok(records::parse(&text[..range.end.min(text.len())], range, 0))
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
            piece = records::parse(text, data.end..piece.range.end, most_faults.saturating_sub(data.faults.len()));
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
fn position(text: &[u8], at: usize) -> (usize, usize) {
    let before = &text[..at.min(text.len())];
    let line = before.iter().rposition(|byte| *byte == b'\n').map_or(0, |found| found + 1);
    let column = before[line..].iter().filter(|byte| **byte & 0xC0 != 0x80).count();
    (before.iter().filter(|byte| **byte == b'\n').count() + 1, column + 1)
}

const MAGIC: &[u8] = b"ISO-10303-21";
/// Number of bytes in which the magic must appear. A byte order mark or a comment may precede it.
pub(super) const MAGIC_WITHIN: usize = 4096;
/// Number of bytes that are counted between two looks whether reading is cancelled.
const STRETCH: usize = 1 << 20;

/// Where the text starts, from the first [`MAGIC_WITHIN`] bytes of a file.
pub(super) fn magic(bytes: &[u8]) -> Result<usize, StepError> {
    let head = &bytes[..bytes.len().min(MAGIC_WITHIN)];
    find(head, 0, MAGIC).ok_or_else(|| StepError::NotStep { looks_like: guess(head) })
}

/// Parses the whole text, in pieces of about `piece` bytes. The result does not depend on their length. Frees the text
/// before it makes the table.
pub(super) fn parse(
    call: Call<'_>,
    bytes: Cow<'_, [u8]>,
    options: &StepOptions,
    piece: usize,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<Table, StepError> {
    let control = call.control;
    let start = magic(&bytes)?;
    let entities = entities_in(&bytes, options.max_entities, control)?;
    if entities > options.max_entities {
        return Err(StepError::TooManyEntities { entities, limit: options.max_entities });
    }
    let needed = memory_for(&bytes, options.max_memory, control)?;
    if needed > options.max_memory {
        return Err(StepError::TooMuchMemory { needed, limit: options.max_memory });
    }
    let text = &bytes[start..];
    let error = |Fault { at, fault: what, cut, .. }: Fault| {
        let (line, column) = position(text, at);
        (SyntaxError { line, column, what }, cut)
    };
    let refused = |fault: Fault, repairs: usize| StepError::Syntax { error: error(fault).0, repairs };
    let Prologue { data: from, fault, mut repairs, sections, elsewhere } =
        Prologue::read(text).map_err(|fault| refused(fault, 0))?;
    let Data { pieces, is_in_order, mut faults, end } = data(call, text, from, piece, options.max_syntax_repairs)?;
    faults.splice(..0, fault);
    if faults.len() > options.max_syntax_repairs {
        return Err(refused(faults.swap_remove(options.max_syntax_repairs), options.max_syntax_repairs));
    }
    let mut tell = |severity, what| diagnostics.push(Diagnostic::new(severity, what));
    if let Some((severity, what)) = epilogue(text, end) {
        tell(severity, what);
    }
    if !sections.is_empty() {
        tell(Severity::Note, StepOutcome::Sections { names: sections });
    }
    if !elsewhere.is_empty() {
        tell(Severity::Note, StepOutcome::ForeignInstances { count: elsewhere.len() });
    }
    for (k, form) in ["<…>", "@n, #NAME"].into_iter().enumerate() {
        let count = pieces.iter().map(|piece| piece.foreign[k]).sum();
        if count > 0 {
            tell(Severity::Warning, StepOutcome::ForeignValues { count, form });
        }
    }
    if pieces.iter().any(|piece| piece.joints > 0) {
        tell(Severity::Note, StepOutcome::DataSections);
    }
    for fault in faults {
        let (error, cut) = error(fault);
        tell(Severity::Error, StepOutcome::SyntaxCut { error, cut });
    }
    let repaired = repairs.len() + pieces.iter().map(|piece| piece.repaired).sum::<usize>();
    repairs.extend(pieces.iter().flat_map(|piece| piece.repairs.iter().copied()));
    repairs.truncate(LISTED_REPAIRS);
    let more = repaired - repairs.len();
    for (at, repair) in repairs {
        let (line, column) = position(text, at);
        tell(Severity::Note, StepOutcome::SyntaxRepaired { line, column, repair });
    }
    if more > 0 {
        tell(Severity::Note, StepOutcome::MoreRepairs { count: more });
    }
    let budget = ReadBudget::new(bytes.len(), needed, options.max_memory, control);
    drop(bytes);
    let pieces = pieces.into_iter().map(|piece| (piece.rows, piece.types, piece.values));
    Ok(Table::new(call, (pieces.collect(), is_in_order), elsewhere, budget))
}

/// Memory that a text and its instances take, bytes: an estimate, and an upper bound where it is near `limit`.
///
/// Most files take less than [`BYTES_PER_BYTE`]. Each item of a list counts 24 bytes, and 80 more in the longest list,
/// which is held several times while it grows: a list of blanks takes 107 bytes per byte.
fn memory_for(bytes: &[u8], limit: u64, control: &Control) -> Result<u64, StepError> {
    /// No byte takes more.
    const MOST: u64 = 130;
    const TEXT: u64 = 3;
    const ENTITY: u64 = 120;
    const KEYWORD: u64 = 160;
    const ITEM: u64 = 24;
    const LONGEST: u64 = 80;
    let length = bytes.len() as u64;
    if length.saturating_mul(MOST) <= limit {
        return Ok(length * BYTES_PER_BYTE);
    }
    let (mut items, mut longest) = (0, 0);
    let (mut other, mut before) = (0, b' ');
    for stretch in bytes.chunks(STRETCH) {
        proceed(control)?;
        for &byte in stretch {
            match byte {
                b' ' | b'\n' | b'\r' | b'\t' => continue,
                b',' => {
                    items += 1;
                    other += ITEM;
                }
                b'(' => {
                    items += 1;
                    other += if before.is_ascii_alphanumeric() || before == b'_' { KEYWORD } else { ITEM };
                }
                b'=' => other += ENTITY,
                b';' => (items, longest) = (0, longest.max(items)),
                _ => {}
            }
            before = byte;
        }
    }
    Ok((TEXT * length + other + LONGEST * longest.max(items)).max(length * BYTES_PER_BYTE))
}

/// Counts the instances of a text before parsing: every `=` that follows `#` and a number, in strings too. 0 for a text
/// that is too short to have more than `limit`.
fn entities_in(bytes: &[u8], limit: u64, control: &Control) -> Result<u64, StepError> {
    /// As in `#1=A();`
    const SHORTEST: u64 = 7;
    if bytes.len() as u64 / SHORTEST <= limit {
        return Ok(0);
    }
    let (mut count, mut in_number) = (0, false);
    for stretch in bytes.chunks(STRETCH) {
        proceed(control)?;
        for byte in stretch {
            match byte {
                b'#' => in_number = true,
                b'0'..=b'9' | b' ' | b'\t' | b'\r' | b'\n' => {}
                _ => {
                    count += u64::from(in_number && *byte == b'=');
                    in_number = false;
                }
            }
        }
    }
    Ok(count)
}

/// Guesses the format of a file that is not Part 21 text.
fn guess(bytes: &[u8]) -> &'static str {
    match bytes {
        [] => "an empty file",
        [b'P', b'K', 3, 4, ..] => "a ZIP archive: unpack it and read the .stp file inside",
        [0x1f, 0x8b, ..] => "a gzip file: unpack it first",
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "text in UTF-16: save it as UTF-8",
        _ if bytes.starts_with(b"<?xml") => "XML: export Part 21 text (.stp, .step) instead",
        _ if bytes.starts_with(b"solid") => "an STL mesh: export STEP from the CAD system",
        _ if bytes.get(72) == Some(&b'S') => "IGES: export STEP from the CAD system",
        // OpenCASCADE's format starts with its version, in some files after the name of a class.
        _ if find(&bytes[..bytes.len().min(64)], 0, b"CASCADE Topology").is_some() => {
            "a BREP file of OpenCASCADE: export STEP instead"
        }
        _ => "a file with no Part 21 text: check that the download or export is complete",
    }
}
