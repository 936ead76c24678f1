//! Part 21 bytes -> an instance table. Instances with syntax errors are cut out one at a time, so that one bad line
//! does not cost the file.

use super::budget::ReadBudget;
use super::mend::mend;
use super::options::{BYTES_PER_BYTE, StepError, StepOptions, proceed};
use super::pieces::{Joined, Pieces};
use super::sections::{end_of_signed, find, without_extra, without_resources};
use super::table::Table;
use crate::control::{Call, Control};
use crate::model::{Diagnostic, Severity, StepOutcome};
use std::borrow::Cow;

const MAGIC: &[u8] = b"ISO-10303-21";
/// Number of bytes in which the magic must appear. A byte order mark or a comment may precede it.
pub(super) const MAGIC_WITHIN: usize = 4096;
/// Number of bytes that are counted between two looks whether reading is cancelled.
const STRETCH: usize = 1 << 20;

/// Where the text starts, from the first [`MAGIC_WITHIN`] bytes of a file.
pub(super) fn magic(bytes: &[u8]) -> Result<usize, StepError> {
    let head = &bytes[..bytes.len().min(MAGIC_WITHIN)];
    find(head, MAGIC).ok_or_else(|| StepError::NotStep { looks_like: guess(head) })
}

/// Parses the whole text, in pieces of `piece` bytes. The result does not depend on their length.
pub(super) fn parse(
    call: Call<'_>,
    bytes: &[u8],
    options: &StepOptions,
    piece: usize,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<Table, StepError> {
    let control = call.control;
    let start = magic(bytes)?;
    let entities = entities_in(bytes, options.max_entities, control)?;
    if entities > options.max_entities {
        return Err(StepError::TooManyEntities { entities, limit: options.max_entities });
    }
    let needed = memory_for(bytes, options.max_memory, control)?;
    if needed > options.max_memory {
        return Err(StepError::TooMuchMemory { needed, limit: options.max_memory });
    }
    let mut text = &bytes[start..];
    if let Some(end) = end_of_signed(text) {
        diagnostics.push(file_note(Severity::Note, StepOutcome::Signature));
        text = &text[..end];
    }
    let mut text = Cow::Borrowed(text);
    let (sections, elsewhere) = without_extra(&mut text);
    if !sections.is_empty() {
        diagnostics.push(file_note(Severity::Note, StepOutcome::Sections { names: sections }));
    }
    if !elsewhere.is_empty() {
        let what = StepOutcome::ForeignInstances { count: elsewhere.len() };
        diagnostics.push(file_note(Severity::Note, what));
    }
    let resources = without_resources(&mut text);
    if resources > 0 {
        let what = StepOutcome::ForeignValues { count: resources, form: "<…>" };
        diagnostics.push(file_note(Severity::Warning, what));
    }
    let mut pieces = Pieces::new(piece, call);
    let (mut changed, mut cuts) = (0..usize::MAX, 0);
    loop {
        pieces.cut(&text, &changed)?;
        let Some(error) = pieces.parse(&text)? else { break };
        let refused = || StepError::Syntax { message: error.to_string(), repairs: cuts };
        if cuts == options.max_syntax_repairs {
            return Err(refused());
        }
        let mended = mend(text.to_mut(), &error, control)?.ok_or_else(refused)?;
        diagnostics.extend(mended.done.into_iter().map(|(severity, what)| file_note(severity, what)));
        changed = mended.changed;
        cuts += 1;
    }
    let Joined { rows, warnings, warned } = pieces.join(&text);
    let more = warned - warnings.len();
    let repaired = |message| file_note(Severity::Note, StepOutcome::SyntaxRepaired { message });
    diagnostics.extend(warnings.into_iter().map(repaired));
    if more > 0 {
        diagnostics.push(file_note(Severity::Note, StepOutcome::MoreRepairs { count: more }));
    }
    Ok(Table::new(rows, elsewhere, ReadBudget::new(bytes.len(), needed, options.max_memory, control)))
}

/// Memory that a text and its instances take, bytes: an estimate, and an upper bound where it is near `limit`.
///
/// Most files take less than [`BYTES_PER_BYTE`]. Lists of one digit take 47 bytes per byte, those of blanks 150. The
/// parser holds 32 bytes per item of a list, and twice that again while it reads the longest one.
fn memory_for(bytes: &[u8], limit: u64, control: &Control) -> Result<u64, StepError> {
    /// No byte takes more.
    const MOST: u64 = 210;
    const TEXT: u64 = 2;
    const ENTITY: u64 = 200;
    const KEYWORD: u64 = 80;
    const LIST: u64 = 32;
    const ITEM: u64 = 32;
    const LONGEST: u64 = 64;
    const BLANK: u64 = 112;
    const QUOTE: u64 = 4;
    let length = bytes.len() as u64;
    if length.saturating_mul(MOST) <= limit {
        return Ok(length * BYTES_PER_BYTE);
    }
    let (mut items, mut longest) = (0, 0);
    let (mut other, mut before) = (0, b' ');
    for stretch in bytes.chunks(STRETCH) {
        proceed(control)?;
        for &byte in stretch {
            let after_comma = before == b',';
            match byte {
                b' ' | b'\n' | b'\r' | b'\t' => continue,
                b',' => {
                    items += 1;
                    other += ITEM + if after_comma || before == b'(' { BLANK } else { 0 };
                }
                b'(' => other += if before.is_ascii_alphanumeric() || before == b'_' { KEYWORD } else { LIST },
                b')' if after_comma => other += BLANK,
                b'\'' => other += QUOTE,
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

fn file_note(severity: Severity, what: StepOutcome) -> Diagnostic {
    Diagnostic::new(severity, what)
}

/// Guesses the format of a file that is not Part 21 text.
fn guess(bytes: &[u8]) -> &'static str {
    match bytes {
        [] => "an empty file",
        [b'P', b'K', 3, 4, ..] => "a ZIP archive: unpack it and read the .stp file inside",
        [0x1f, 0x8b, ..] => "a gzip file: unpack it first",
        _ if bytes.starts_with(b"<?xml") => "XML: export Part 21 text (.stp, .step) instead",
        _ if bytes.starts_with(b"solid") => "an STL mesh: export STEP from the CAD system",
        _ if bytes.get(72) == Some(&b'S') => "IGES: export STEP from the CAD system",
        _ => "no Part 21 text: check that the download or export is complete",
    }
}
