//! Syntax errors -> text without them. What is wrong is blanked, cut off or replaced, so that lines keep their numbers.

use super::options::{StepError, proceed};
use super::sections::{Done, cut_behind_end, data_section, settle};
use crate::control::Control;
use crate::model::{Severity, StepOutcome, SyntaxCut};
use std::ops::Range;
use step_io::Error;

/// Changes of a text, and the bytes outside which the text is as before, at the same places.
pub(super) struct Mended {
    pub(super) done: Vec<Done>,
    pub(super) changed: Range<usize>,
}

/// Changes the text so that the parser gets past `error`. `None` if there is no remedy.
pub(super) fn mend(text: &mut Vec<u8>, error: &Error, control: &Control) -> Result<Option<Mended>, StepError> {
    // Syntax that a later edition allows is not an error.
    if let Some((done, changed)) = settle(text) {
        return Ok(Some(Mended { done, changed }));
    }
    proceed(control)?;
    Ok(cut(text, error).map(|(done, changed)| Mended { done: vec![done], changed }))
}

/// Cuts out the text at which the parser stopped.
fn cut(text: &mut Vec<u8>, error: &Error) -> Option<(Done, Range<usize>)> {
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
            let end = close(text)?;
            return Some((lost(SyntaxCut::End), end..usize::MAX));
        }
        _ => return None,
    };
    let at = usize::try_from(at).ok()?.min(text.len());
    let data = data_section(text)?;
    if at < data {
        return new_header(text).then(|| (lost(SyntaxCut::Header), 0..usize::MAX));
    }
    if let Some(done) = cut_behind_end(text, at) {
        return Some((done, text.len()..usize::MAX));
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
    Some((lost(SyntaxCut::Instance(number)), from..to))
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

/// Repairs a text that stops in the data section: cuts the unfinished instance and closes section and file. Returns
/// where the old text ends.
fn close(text: &mut Vec<u8>) -> Option<usize> {
    const END: &[u8] = b"\nENDSEC;\nEND-ISO-10303-21;\n";
    let data = data_section(text)?;
    if text.ends_with(END) {
        return None;
    }
    let end = 1 + text.iter().rposition(|b| *b == b';').filter(|i| *i > data)?;
    text.truncate(end);
    text.extend_from_slice(END);
    Some(end)
}
