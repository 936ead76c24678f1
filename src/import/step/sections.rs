//! The parts of Part 21 text around its instances: the header, the sections of edition 3 before the data, and what
//! follows the end.
//!
//! `ANCHOR` names instances for other files and is not needed. `REFERENCE` names instances of other files, which are
//! not read; diagnostics name the instances that use them. `SIGNATURE` sections are not verified.

use super::records::{Fault, data};
use super::token::{Parse, Token, Tokens, has_word};
use crate::model::{Severity, StepOutcome, SyntaxCut, SyntaxFault, SyntaxRepair};
use std::collections::BTreeMap;

/// Sections that may lie between header and data.
const BEFORE_DATA: [&[u8]; 3] = [b"ANCHOR", b"REFERENCE", b"SIGNATURE"];
/// Maximum number of these. Real files have up to three, and the end of each may be looked for in all of the text.
const MAX_SECTIONS: usize = 16;
/// Entities that every header has.
const HEADER: [&str; 3] = ["FILE_DESCRIPTION", "FILE_NAME", "FILE_SCHEMA"];

/// What lies before the instances.
pub(super) struct Prologue {
    /// Where the data section starts, behind its `DATA;`: a byte of the text.
    pub(super) data: usize,
    /// What breaks the syntax before.
    pub(super) fault: Option<Fault>,
    pub(super) repairs: Vec<(usize, SyntaxRepair)>,
    /// Names of the sections between header and data.
    pub(super) sections: Vec<String>,
    /// Places of the instances defined in other files.
    pub(super) elsewhere: BTreeMap<u64, String>,
}

impl Prologue {
    /// Reads what lies before the instances of a text.
    ///
    /// # Errors
    /// If no data section is found.
    pub(super) fn read(text: &[u8]) -> Result<Self, Fault> {
        let mut tokens = Tokens::new(text, 0);
        let mut repairs = Vec::new();
        let found = header(&mut tokens, &mut repairs);
        let mut fault = found.err().map(|fault| in_header(&tokens, *fault));
        // A quote may be missing in the header: the word counts wherever it stands.
        let end = if fault.is_none() { tokens.end() } else { find(text, 0, b"ENDSEC").unwrap_or(0) + b"ENDSEC".len() };
        let mut at = behind(text, end);
        let (mut sections, mut elsewhere) = (Vec::new(), BTreeMap::new());
        while sections.len() < MAX_SECTIONS
            && let Some(name) = BEFORE_DATA.into_iter().find(|name| has_word(text, at, name))
        {
            let from = at + name.len();
            let Some(end) = section_end(text, from) else { break };
            sections.push(String::from_utf8_lossy(name).into_owned());
            let numbers = outside(&text[..end], from).filter(|i| text[*i] == b'#');
            elsewhere.extend(numbers.filter_map(|i| reference(&text[i + 1..end])));
            at = end;
        }
        tokens.seek(at);
        let opened = match tokens.next() {
            Token::Keyword if tokens.slice().eq_ignore_ascii_case(b"DATA") => data(&mut tokens),
            other => Err(tokens.unexpected(other, "DATA")),
        };
        let data = match opened {
            Ok(()) => tokens.end(),
            Err(found) => {
                let found = in_header(&tokens, *found);
                let Some(word) = find(text, at, b"DATA") else { return Err(fault.unwrap_or(found)) };
                fault.get_or_insert(found);
                find(text, word, b";").map_or(text.len(), |at| at + 1)
            }
        };
        Ok(Self { data, fault, repairs, sections, elsewhere })
    }
}

fn in_header(tokens: &Tokens<'_>, fault: SyntaxFault) -> Fault {
    Fault { start: tokens.start(), at: tokens.start(), fault, cut: SyntaxCut::Header }
}

/// Reads the header, which says nothing that is needed.
fn header(tokens: &mut Tokens<'_>, repairs: &mut Vec<(usize, SyntaxRepair)>) -> Parse<()> {
    tokens.expect(Token::FileStart, "ISO-10303-21")?;
    tokens.expect(Token::Semicolon, "';'")?;
    tokens.expect(Token::Keyword, "HEADER")?;
    tokens.expect(Token::Semicolon, "';'")?;
    let mut wanted = HEADER.to_vec();
    let mut token = tokens.next();
    while token == Token::Keyword && !tokens.slice().eq_ignore_ascii_case(b"ENDSEC") {
        wanted.retain(|name| !tokens.slice().eq_ignore_ascii_case(name.as_bytes()));
        tokens.expect(Token::Open, "'('")?;
        let mut depth = 1;
        while depth > 0 {
            match tokens.next() {
                Token::Open => depth += 1,
                Token::Close => depth -= 1,
                end @ (Token::Semicolon | Token::Nothing) => return Err(tokens.unexpected(end, "')'")),
                _ => {}
            }
        }
        token = tokens.next();
        match token {
            Token::Semicolon => token = tokens.next(),
            Token::Nothing => {}
            _ => repairs.push((tokens.start(), SyntaxRepair::Semicolon)),
        }
    }
    if token != Token::Keyword {
        return Err(tokens.unexpected(token, "ENDSEC"));
    }
    if let Some(name) = wanted.first() {
        return Err(Box::new(SyntaxFault::NotInHeader { name }));
    }
    tokens.expect(Token::Semicolon, "';'")
}

/// Behind the `ENDSEC` of a section. If quotes do not match, the next one counts, even in a string.
fn section_end(text: &[u8], from: usize) -> Option<usize> {
    let end = outside(text, from).find(|i| has_word(text, *i, b"ENDSEC")).or_else(|| find(text, from, b"ENDSEC"))?;
    Some(behind(text, end + b"ENDSEC".len()))
}

/// Parses `n = <place>`, the text of a reference after its `#`.
fn reference(text: &[u8]) -> Option<(u64, String)> {
    let (number, rest) = text.split_at(text.iter().position(|b| !b.is_ascii_digit())?);
    let mut ink = rest.iter().enumerate().filter(|(_, b)| !b.is_ascii_whitespace());
    let ((_, b'='), (open, b'<')) = (ink.next()?, ink.next()?) else { return None };
    let place = &rest[open..=open + rest[open..].iter().position(|b| *b == b'>')?];
    Some((std::str::from_utf8(number).ok()?.parse().ok()?, String::from_utf8_lossy(place).into_owned()))
}

/// What to say of the text behind the end of the file, at byte `at`.
pub(super) fn epilogue(text: &[u8], at: usize) -> Option<(Severity, StepOutcome)> {
    let at = at + text.get(at..)?.iter().position(|b| !b.is_ascii_whitespace())?;
    let signed = has_word(text, behind(text, at), b"SIGNATURE");
    Some(if signed { (Severity::Note, StepOutcome::Signature) } else { (Severity::Warning, StepOutcome::BehindEnd) })
}

/// Positions from `at` on outside strings, comments and resources (`<…>`).
fn outside(text: &[u8], at: usize) -> impl Iterator<Item = usize> + '_ {
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
            next = find(text, here + close.len(), close).map_or(text.len(), |end| end + close.len());
        }
    })
}

/// The first position from `at` on that is not white space, a comment, a string, a resource or a semicolon.
fn behind(text: &[u8], at: usize) -> usize {
    outside(text, at).find(|i| !(text[*i].is_ascii_whitespace() || text[*i] == b';')).unwrap_or(text.len())
}

/// The first place from byte `at` on where `word` stands.
pub(super) fn find(text: &[u8], at: usize, word: &[u8]) -> Option<usize> {
    text.get(at..)?.windows(word.len()).position(|w| w == word).map(|found| at + found)
}
