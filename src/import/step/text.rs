//! Part 21 bytes -> an instance table. Instances with syntax errors are left out one at a time, so that one bad line
//! does not cost the file.

use super::budget::ReadBudget;
use super::options::{BYTES_PER_BYTE, StepError, StepOptions, proceed};
use super::pieces::{self, Data, position};
use super::records::{Fault, LISTED_REPAIRS};
use super::sections::{Prologue, epilogue, find};
use super::table::Table;
use crate::control::{Call, Control};
use crate::model::{Diagnostic, Severity, StepOutcome, SyntaxError, SyntaxFault};
use std::borrow::Cow;

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
    let error = |fault: Fault| (placed(text, fault.at, fault.fault), fault.cut);
    let refused = |fault: Fault, repairs: usize| StepError::Syntax { error: error(fault).0, repairs };
    let Prologue { data: from, fault, mut repairs, sections, elsewhere } =
        Prologue::read(text).map_err(|fault| refused(fault, 0))?;
    let Data { pieces, is_in_order, mut faults, end } =
        pieces::data(call, text, from, piece, options.max_syntax_repairs)?;
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

fn placed(text: &[u8], at: usize, what: SyntaxFault) -> SyntaxError {
    let (line, column) = position(text, at);
    SyntaxError { line, column, what }
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

/// Whether a text starts as OpenCASCADE's own format does: with its version, after the name of a class in some files.
fn is_brep(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(64)];
    start.windows(16).any(|w| w == b"CASCADE Topology")
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
        _ if is_brep(bytes) => "a BREP file of OpenCASCADE: export STEP instead",
        _ => "a file with no Part 21 text: check that the download or export is complete",
    }
}
