//! Part 21 bytes -> an instance table. Instances with syntax errors are cut out one at a time, so that one bad line
//! does not cost the file.

use super::budget::ReadBudget;
use super::options::{BYTES_PER_BYTE, StepError, StepOptions};
use super::sections::{
    Done, cut_behind_end, data_section, end_of_signed, find, settle, without_extra, without_resources,
};
use super::table::Table;
use crate::control::Control;
use crate::model::{Diagnostic, Severity, StepOutcome, SyntaxCut};
use std::borrow::Cow;
use step_io::{Error, parser};

const MAGIC: &[u8] = b"ISO-10303-21";
/// Number of bytes in which the magic must appear. A byte order mark or a comment may precede it.
pub(super) const MAGIC_WITHIN: usize = 4096;
/// Number of repaired syntax errors that get a note each.
const LISTED_WARNINGS: usize = 8;

/// Where the text starts, from the first [`MAGIC_WITHIN`] bytes of a file.
pub(super) fn magic(bytes: &[u8]) -> Result<usize, StepError> {
    let head = &bytes[..bytes.len().min(MAGIC_WITHIN)];
    find(head, MAGIC).ok_or_else(|| StepError::NotStep { looks_like: guess(head) })
}

/// Parses the whole text.
pub(super) fn parse(
    bytes: &[u8],
    options: &StepOptions,
    control: &Control,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<Table, StepError> {
    let start = magic(bytes)?;
    let entities = entities_in(bytes, options.max_entities);
    if entities > options.max_entities {
        return Err(StepError::TooManyEntities { entities, limit: options.max_entities });
    }
    let needed = memory_for(bytes, options.max_memory);
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
    let mut cuts = 0;
    loop {
        if control.is_cancelled() {
            return Err(StepError::Cancelled);
        }
        let error = match parser::parse(&text[..]) {
            Ok(graph) => {
                for warning in graph.warnings.iter().take(LISTED_WARNINGS) {
                    let what = StepOutcome::SyntaxRepaired { message: warning.to_string() };
                    diagnostics.push(file_note(Severity::Note, what));
                }
                if let Some(count) = graph.warnings.len().checked_sub(LISTED_WARNINGS).filter(|n| *n > 0) {
                    diagnostics.push(file_note(Severity::Note, StepOutcome::MoreRepairs { count }));
                }
                let budget = ReadBudget::new(bytes.len(), needed, options.max_memory, control);
                return Ok(Table::new(graph.entities.into_values().collect(), elsewhere, budget));
            }
            Err(error) => error,
        };
        if cuts == options.max_syntax_repairs {
            return Err(StepError::Syntax { message: error.to_string(), repairs: cuts });
        }
        let Some(done) = mend(text.to_mut(), &error) else {
            return Err(StepError::Syntax { message: error.to_string(), repairs: cuts });
        };
        diagnostics.extend(done.into_iter().map(|(severity, what)| file_note(severity, what)));
        cuts += 1;
    }
}

/// Memory that a text and its instances take, bytes: an estimate, and an upper bound where it is near `limit`.
///
/// Most files take less than [`BYTES_PER_BYTE`]. Lists of one digit take 47 bytes per byte, those of blanks 150. The
/// parser holds 32 bytes per item of a list, and twice that again while it reads the longest one.
fn memory_for(bytes: &[u8], limit: u64) -> u64 {
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
        return length * BYTES_PER_BYTE;
    }
    let (mut items, mut longest) = (0, 0);
    let (mut other, mut before) = (0, b' ');
    for &byte in bytes {
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
    (TEXT * length + other + LONGEST * longest.max(items)).max(length * BYTES_PER_BYTE)
}

/// Counts the instances of a text before parsing: every `=` that follows `#` and a number, in strings too. 0 for a text
/// that is too short to have more than `limit`.
fn entities_in(bytes: &[u8], limit: u64) -> u64 {
    /// As in `#1=A();`
    const SHORTEST: u64 = 7;
    if bytes.len() as u64 / SHORTEST <= limit {
        return 0;
    }
    let (mut count, mut in_number) = (0, false);
    for byte in bytes {
        match byte {
            b'#' => in_number = true,
            b'0'..=b'9' | b' ' | b'\t' | b'\r' | b'\n' => {}
            _ => {
                count += u64::from(in_number && *byte == b'=');
                in_number = false;
            }
        }
    }
    count
}

fn file_note(severity: Severity, what: StepOutcome) -> Diagnostic {
    Diagnostic::new(severity, what)
}

/// Changes the text so that the parser gets past `error`. Returns the changes, or `None` if there is no remedy.
fn mend(text: &mut Vec<u8>, error: &Error) -> Option<Vec<Done>> {
    // Syntax that a later edition allows is not an error.
    settle(text).or_else(|| Some(vec![cut(text, error)?]))
}

/// Cuts out the text at which the parser stopped.
fn cut(text: &mut Vec<u8>, error: &Error) -> Option<Done> {
    let lost = |cut| (Severity::Error, StepOutcome::SyntaxCut { message: error.to_string(), cut });
    let at = match error {
        Error::Lex(lex) => lex.span.start,
        Error::UnexpectedToken { span, .. }
        | Error::InvalidAttributePosition { span, .. }
        | Error::MalformedFileSchema { span }
        | Error::NestingTooDeep { span } => span.start,
        Error::MissingHeaderEntity { .. } => 0,
        Error::DuplicateEntityId { id, line, .. } => repeat_of(text, *id, *line)?,
        Error::UnexpectedEof { .. } => {
            return close(text).then(|| lost(SyntaxCut::End));
        }
        _ => return None,
    };
    let at = usize::try_from(at).ok()?.min(text.len());
    let data = data_section(text)?;
    if at < data {
        return new_header(text).then(|| lost(SyntaxCut::Header));
    }
    if let Some(done) = cut_behind_end(text, at) {
        return Some(done);
    }
    // The parser notices a stray quote only at the end of the string that it opens, many instances later.
    let at = runaway_string(text, data).unwrap_or(at);
    let (from, to) = instance_around(text, at)?;
    let number = number(&text[from..to]);
    for byte in &mut text[from..to] {
        if *byte != b'\n' {
            *byte = b' ';
        }
    }
    Some(lost(SyntaxCut::Instance(number)))
}

/// The number of the instance at the start of the text, with its `#`.
fn number(instance: &[u8]) -> String {
    let digits = instance.iter().skip(1).take_while(|b| b.is_ascii_digit()).take(20);
    std::iter::once('#').chain(digits.map(|b| char::from(*b))).collect()
}

/// Start of the first string that extends over the end of an instance into the next one.
fn runaway_string(text: &[u8], data: usize) -> Option<usize> {
    let mut start = None;
    for (i, byte) in text.iter().enumerate().skip(data) {
        match (byte, start) {
            // A doubled quote inside a string ends the string and opens it again, which is harmless here.
            (b'\'', None) => start = Some(i),
            (b'\'', Some(_)) => start = None,
            (b';', Some(from)) => {
                let next = text[i + 1..].iter().position(|b| !b.is_ascii_whitespace()).map(|skip| i + 1 + skip);
                let defines = next.is_some_and(|next| {
                    let rest = &text[next..];
                    let digits = rest.iter().skip(1).take_while(|b| b.is_ascii_digit()).count();
                    let after = rest.iter().skip(1 + digits).find(|b| !b.is_ascii_whitespace());
                    rest.first() == Some(&b'#') && digits > 0 && after == Some(&b'=')
                });
                if defines {
                    return Some(from);
                }
            }
            _ => {}
        }
    }
    None
}

/// Replaces the header, which holds nothing that is needed, by an empty one. Lines keep their numbers.
fn new_header(text: &mut Vec<u8>) -> bool {
    const EMPTY: &str = "ISO-10303-21;HEADER;FILE_DESCRIPTION((''),'2;1');FILE_NAME('','',(''),(''),'','','');\
                         FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));ENDSEC;";
    if text.starts_with(EMPTY.as_bytes()) {
        return false;
    }
    let Some(data) = data_section(text) else { return false };
    let lines = text[..data].iter().filter(|b| **b == b'\n').count();
    let header: Vec<u8> = EMPTY.bytes().chain(std::iter::repeat_n(b'\n', lines)).collect();
    text.splice(..data, header);
    true
}

/// Byte range of the instance that contains `at`: from its `#` to after its `;`.
fn instance_around(text: &[u8], at: usize) -> Option<(usize, usize)> {
    let data = data_section(text)?;
    let starts = |i: usize| text[i] == b'#' && last_ink(text, i) == Some(b';');
    let from = (data..=at.min(text.len().checked_sub(1)?)).rev().find(|i| starts(*i))?;
    let to = (at.max(from)..text.len())
        .find(|i| text[*i] == b';' && matches!(next_ink(text, *i), Some(b'#' | b'E' | b'e') | None))
        .map_or(text.len(), |i| i + 1);
    Some((from, to))
}

/// Position where instance `id` is defined, on or after `line` (counted from 1).
fn repeat_of(text: &[u8], id: u64, line: u32) -> Option<u64> {
    let start = match (line as usize).checked_sub(2) {
        None => 0,
        Some(nth) => text.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(i, _)| i + 1).nth(nth)?,
    };
    let name = format!("#{id}");
    let defines = |i: &usize| {
        text[*i..].starts_with(name.as_bytes())
            && text[i + name.len()..].iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'=')
    };
    u64::try_from((start..text.len()).find(defines)?).ok()
}

fn last_ink(text: &[u8], before: usize) -> Option<u8> {
    text[..before].iter().rev().copied().find(|b| !b.is_ascii_whitespace())
}

fn next_ink(text: &[u8], after: usize) -> Option<u8> {
    text[after + 1..].iter().copied().find(|b| !b.is_ascii_whitespace())
}

/// Repairs a text that stops in the data section: cuts the unfinished instance and closes section and file.
fn close(text: &mut Vec<u8>) -> bool {
    const END: &[u8] = b"\nENDSEC;\nEND-ISO-10303-21;\n";
    let Some(data) = data_section(text) else { return false };
    if text.ends_with(END) {
        return false;
    }
    let Some(last) = text.iter().rposition(|b| *b == b';').filter(|i| *i > data) else { return false };
    text.truncate(last + 1);
    text.extend_from_slice(END);
    true
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
