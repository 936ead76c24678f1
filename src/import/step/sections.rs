//! Sections of an ISO 10303-21 edition 3 file -> the header and one data section, which the parser reads. Text is
//! blanked, not cut, so that lines keep their numbers.
//!
//! `ANCHOR` names instances for other files and is not needed. `REFERENCE` names instances of other files, which are
//! not read; diagnostics name the instances that use them. `SIGNATURE` sections are not verified. Several `DATA`
//! sections are read as one. Values from another file or a constant (`@n`, `#NAME`, `<resource>`) are read as unset.

use crate::model::{Severity, StepOutcome};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

/// Sections that may lie between header and data.
const BEFORE_DATA: [&[u8]; 3] = [b"ANCHOR", b"REFERENCE", b"SIGNATURE"];
const END: &[u8] = b"END-ISO-10303-21";

/// A change to the text, with its severity.
pub(super) type Done = (Severity, StepOutcome);

/// Position of the word `DATA` that opens the first data section, after the header and the sections that follow it.
pub(super) fn data_section(text: &[u8]) -> Option<usize> {
    let at = extra_sections(text)?.last().map_or_else(|| header_end(text), |(_, to)| Some(*to))?;
    find(&text[at..], b"DATA").map(|found| at + found)
}

/// Position of the first `ENDSEC`, normally the header's end. (A string in the header might contain the word.)
fn header_end(text: &[u8]) -> Option<usize> {
    find(text, b"ENDSEC")
}

/// The sections between header and data: from the first letter to after the semicolon.
fn extra_sections(text: &[u8]) -> Option<Vec<(usize, usize)>> {
    let mut at = behind(text, header_end(text)? + b"ENDSEC".len());
    let mut found = Vec::new();
    while let Some(name) = BEFORE_DATA.into_iter().find(|name| has_word(text, at, name)) {
        // If quotes do not match, take the next `ENDSEC`, even in a string.
        let from = at + name.len();
        let end = words(text, from).find(|i| has_word(text, *i, b"ENDSEC"));
        let end = end.or_else(|| find(&text[from..], b"ENDSEC").map(|i| from + i));
        let to = behind(text, end? + b"ENDSEC".len());
        found.push((at, to));
        at = to;
    }
    Some(found)
}

/// Blanks the sections between header and data. Returns their names, and the instances defined in other files.
///
/// The parser must not see them: it panics on a quote or semicolon between angle brackets (step-io 0.3.0, `find_cut`).
pub(super) fn without_extra(text: &mut Cow<'_, [u8]>) -> (Vec<String>, BTreeMap<u64, String>) {
    let (mut names, mut elsewhere) = (Vec::new(), BTreeMap::new());
    for (from, to) in extra_sections(text).unwrap_or_default() {
        let letters = text[from..].iter().take_while(|b| b.is_ascii_alphabetic());
        names.push(letters.map(|b| char::from(b.to_ascii_uppercase())).collect());
        for at in words(&text[..to], from).filter(|i| text[*i] == b'#') {
            elsewhere.extend(reference(&text[at + 1..to]));
        }
        blank(&mut text.to_mut()[from..to]);
    }
    (names, elsewhere)
}

/// Parses `n = <place>`, the text of a reference after its `#`.
fn reference(text: &[u8]) -> Option<(u64, String)> {
    let (number, rest) = text.split_at(text.iter().position(|b| !b.is_ascii_digit())?);
    let mut ink = rest.iter().enumerate().filter(|(_, b)| !b.is_ascii_whitespace());
    let ((_, b'='), (open, b'<')) = (ink.next()?, ink.next()?) else { return None };
    let place = &rest[open..=open + rest[open..].iter().position(|b| *b == b'>')?];
    Some((std::str::from_utf8(number).ok()?.parse().ok()?, String::from_utf8_lossy(place).into_owned()))
}

/// Replaces resources (`<…>` outside strings and comments) by `$`, for the same reason as [`without_extra`]. Returns
/// their number.
pub(super) fn without_resources(text: &mut Cow<'_, [u8]>) -> usize {
    if !text.contains(&b'<') {
        return 0;
    }
    let mut found = Vec::new();
    let mut behind = 0;
    while let Some(at) = next(text, behind, b'<', false) {
        let end = text[at..].iter().position(|b| matches!(b, b'>' | b'\n')).map_or(text.len(), |i| at + i);
        behind = if text.get(end) == Some(&b'>') { end + 1 } else { at + 1 };
        found.push((at, behind));
    }
    for (from, to) in &found {
        let text = text.to_mut();
        blank(&mut text[*from..*to]);
        text[*from] = b'$';
    }
    found.len()
}

/// Position of the signatures that follow the end of the file proper. Searches the last megabyte only; the parser stops
/// at longer signatures.
pub(super) fn end_of_signed(text: &[u8]) -> Option<usize> {
    let window = text.len().saturating_sub(1 << 20);
    let end = window + rfind(&text[window..], END)?;
    let at = behind(text, end + END.len());
    has_word(text, at, b"SIGNATURE").then_some(at)
}

/// Cuts off the text after the end of the file, if `at` lies there.
pub(super) fn cut_behind_end(text: &mut Vec<u8>, at: usize) -> Option<Done> {
    let end = rfind(text, END)? + END.len();
    let end = behind(text, end).min(text.len());
    if at < end || end == text.len() {
        return None;
    }
    let signed = has_word(text, end, b"SIGNATURE");
    text.truncate(end);
    Some(if signed { (Severity::Note, StepOutcome::Signature) } else { (Severity::Warning, StepOutcome::BehindEnd) })
}

/// Converts edition 3 text to plain text: joins several data sections and unsets named values. Returns what was done,
/// and the range that holds all changes. `None` if the text has neither.
pub(super) fn settle(text: &mut [u8]) -> Option<(Vec<Done>, Range<usize>)> {
    let mut done = Vec::new();
    let data = data_section(text)?;
    let Foreign { joints, mut values } = Foreign::find(text, data);
    for (from, to) in &joints {
        blank(&mut text[*from..*to]);
    }
    if !joints.is_empty() {
        done.push((Severity::Note, StepOutcome::DataSections));
    }
    values.retain(|(from, _)| text[*from] != b' ');
    for (from, to) in &values {
        blank(&mut text[*from..*to]);
        text[*from] = b'$';
    }
    if !values.is_empty() {
        let what = StepOutcome::ForeignValues { count: values.len(), form: "@n, #NAME" };
        done.push((Severity::Warning, what));
    }
    let changed = || joints.iter().chain(&values);
    let range = changed().map(|(from, _)| *from).min()?..changed().map(|(_, to)| *to).max()?;
    Some((done, range))
}

/// What edition 3 adds to a data section. Found in one pass, as texts may be long and errors many.
struct Foreign {
    /// The text between adjacent data sections, and the parameters of the first one.
    joints: Vec<(usize, usize)>,
    /// Ranges of `@n`, `@NAME` and `#NAME` outside strings.
    values: Vec<(usize, usize)>,
}

impl Foreign {
    fn find(text: &[u8], data: usize) -> Self {
        let (mut joints, mut values) = (Vec::new(), Vec::new());
        let opened = |at: usize| -> Option<(usize, usize)> {
            // A data section may state its name and schema in brackets.
            let from = at + b"DATA".len();
            let end = next(text, from, b';', true)?;
            Some((from, end))
        };
        if let Some((from, end)) = opened(data)
            && text[from..end].contains(&b'(')
        {
            joints.push((from, end));
        }
        let named = |i: usize, kind: fn(&u8) -> bool| text.get(i + 1).is_some_and(kind);
        for at in words(text, data) {
            let is_value = match text[at] {
                b'@' => named(at, u8::is_ascii_alphanumeric),
                b'#' => named(at, u8::is_ascii_alphabetic),
                b'E' | b'e' if has_word(text, at, b"ENDSEC") => {
                    let section = behind(text, at + b"ENDSEC".len());
                    if has_word(text, section, b"DATA")
                        && let Some((_, close)) = opened(section)
                    {
                        joints.push((at, close + 1));
                    }
                    false
                }
                _ => false,
            };
            if is_value {
                let rest = &text[at + 1..];
                let length = rest.iter().take_while(|b| b.is_ascii_alphanumeric() || **b == b'_').count();
                values.push((at, at + 1 + length));
            }
        }
        Self { joints, values }
    }
}

/// The first `wanted` byte from `at` on outside strings, comments and, if `resources`, resources (`<…>`). Faster than
/// [`words`], which stops at every byte.
pub(super) fn next(text: &[u8], mut at: usize, wanted: u8, resources: bool) -> Option<usize> {
    let stops = [wanted, b'\'', b'/', if resources { b'<' } else { wanted }];
    loop {
        at += find_any(text.get(at..)?, stops)?;
        let close: &[u8] = match text[at] {
            byte if byte == wanted => return Some(at),
            // A doubled quote ends a string and opens the next one.
            b'\'' => b"'",
            b'<' => b">",
            _ if text.get(at + 1) == Some(&b'*') => b"*/",
            _ => {
                at += 1;
                continue;
            }
        };
        // What opens is as long as what closes.
        let from = at + close.len();
        at = from + find(text.get(from..)?, close)? + close.len();
    }
}

/// Position of the first byte that is one of `wanted`. Looks at eight bytes at a time: all of a file passes here.
fn find_any(text: &[u8], wanted: [u8; 4]) -> Option<usize> {
    const ONES: u64 = u64::from_ne_bytes([1; 8]);
    let (words, rest) = text.as_chunks::<8>();
    for (k, word) in words.iter().enumerate() {
        let word = u64::from_le_bytes(*word);
        // The top bit of each byte that is zero in `differs`. A borrow may set further ones, but only above the first.
        let zeros = wanted.map(|byte| {
            let differs = word ^ (ONES * u64::from(byte));
            differs.wrapping_sub(ONES) & !differs
        });
        let found = (zeros[0] | zeros[1] | zeros[2] | zeros[3]) & (ONES << 7);
        if found != 0 {
            return Some(8 * k + found.trailing_zeros() as usize / 8);
        }
    }
    let from = 8 * words.len();
    rest.iter().position(|byte| wanted.contains(byte)).map(|at| from + at)
}

/// Positions from `at` on outside strings, comments and resources (`<…>`).
fn words(text: &[u8], at: usize) -> impl Iterator<Item = usize> + '_ {
    let mut next = at;
    std::iter::from_fn(move || {
        loop {
            let here = next;
            let close: &[u8] = match *text.get(here)? {
                b'\'' => b"'",
                b'<' => b">",
                b'/' if text.get(here + 1) == Some(&b'*') => b"*/",
                _ => {
                    next = here + 1;
                    return Some(here);
                }
            };
            // A comment opens with two characters, like its end.
            let from = here + close.len();
            let Some(end) = find(text.get(from..)?, close) else {
                next = text.len();
                return None;
            };
            next = from + end + close.len();
        }
    })
}

/// The first position from `at` on that is not white space, a comment, a string, a resource or a semicolon.
fn behind(text: &[u8], at: usize) -> usize {
    words(text, at).find(|i| !(text[*i].is_ascii_whitespace() || text[*i] == b';')).unwrap_or(text.len())
}

/// Whether the whole word `word` starts at `at`, in any case.
pub(super) fn has_word(text: &[u8], at: usize, word: &[u8]) -> bool {
    let end = at + word.len();
    let same = text.get(at..end).is_some_and(|found| found.eq_ignore_ascii_case(word));
    same && !text.get(end).is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_' || *b == b'-')
}

fn blank(text: &mut [u8]) {
    text.iter_mut().filter(|b| **b != b'\n').for_each(|b| *b = b' ');
}

pub(super) fn find(text: &[u8], word: &[u8]) -> Option<usize> {
    if let [byte] = word {
        return text.iter().position(|b| b == byte);
    }
    text.windows(word.len()).position(|w| w == word)
}

fn rfind(text: &[u8], word: &[u8]) -> Option<usize> {
    text.windows(word.len()).rposition(|w| w == word)
}
