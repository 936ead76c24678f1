//! The text of a file -> the instances of its data section, parsed in pieces on all threads.
//!
//! The parser reads a text record by record, up to each `;` outside strings and comments, and an instance that it
//! accepts is one record. So the text can be cut after any record of the data section: each piece is parsed between a
//! header and an end of its own, and gives what the parser would make of that stretch of the whole text. Positions in
//! errors and warnings are moved to where the piece lies. An error is final only in a piece of one record: all
//! instances before it are known then, and a repeated number among them comes first. Pieces that a repair does not
//! change are not parsed again.

use super::options::{StepError, proceed};
use super::sections::{find, has_word, next};
use super::table::{Row, Rows};
use crate::control::Call;
use std::io::Read;
use std::ops::Range;
use std::sync::Mutex;
use step_io::parser::{self, Span};
use step_io::{Error, ParseWarning};

/// Length of a piece, bytes. Cancelling takes effect between pieces, which take about 5 ms.
pub(super) const PIECE: usize = 128 << 10;
/// Number of repaired syntax errors that get a note each.
pub(super) const LISTED_WARNINGS: usize = 8;
/// Pieces longer than this are parsed one at a time: the parser holds their longest list three times, and the bound
/// on memory counts that once.
const LONG: usize = 8 * PIECE;

const HEAD: &[u8] = b"ISO-10303-21;HEADER;FILE_DESCRIPTION();FILE_NAME();FILE_SCHEMA(());ENDSEC;DATA;\n";
const TAIL: &[u8] = b"ENDSEC;END-ISO-10303-21;";

/// A stretch of the text, and what the parser makes of it.
struct Piece {
    range: Range<usize>,
    /// `None`: not parsed yet.
    parsed: Option<Result<Parsed, Error>>,
}

/// Texts read one after the other. Each read fills all the room there is, which the parser zeroes before.
struct Framed<'a>([&'a [u8]; 3]);

impl Read for Framed<'_> {
    fn read(&mut self, room: &mut [u8]) -> std::io::Result<usize> {
        let mut done = 0;
        for text in &mut self.0 {
            done += text.read(&mut room[done..])?;
        }
        Ok(done)
    }
}

struct Parsed {
    rows: Rows,
    /// The first [`LISTED_WARNINGS`] of all `warned`.
    warnings: Vec<ParseWarning>,
    warned: usize,
}

impl Piece {
    fn new(range: Range<usize>) -> Self {
        Self { range, parsed: None }
    }

    /// What is put before and after the piece.
    fn frame(&self, text: &[u8]) -> (&'static [u8], &'static [u8]) {
        (if self.range.start > 0 { HEAD } else { b"" }, if self.range.end < text.len() { TAIL } else { b"" })
    }

    fn parse(&mut self, text: &[u8]) {
        let (head, tail) = self.frame(text);
        self.parsed = Some(parser::parse(Framed([head, &text[self.range.clone()], tail])).map(|graph| {
            let mut warnings = graph.warnings;
            let warned = warnings.len();
            warnings.truncate(LISTED_WARNINGS);
            warnings.shrink_to_fit();
            Parsed { rows: Rows::new(graph.entities), warnings, warned }
        }));
    }

    fn is_sound(&self) -> bool {
        matches!(self.parsed, Some(Ok(_)))
    }

    fn rows(&self) -> &[Row] {
        self.parsed.as_ref().and_then(|parsed| parsed.as_ref().ok()).map_or(&[], |parsed| &parsed.rows.list)
    }

    /// Position in the text of a byte that the parser counts from the start of the frame.
    fn place(&self, at: u64) -> usize {
        let head = if self.range.start > 0 { HEAD.len() } else { 0 };
        usize::try_from(at).map_or(usize::MAX, |at| (self.range.start + at).saturating_sub(head))
    }
}

/// What the parser makes of a whole text.
pub(super) struct Joined {
    pub(super) rows: Rows,
    /// Messages of the first [`LISTED_WARNINGS`] repairs by the parser, of all `warned`.
    pub(super) warnings: Vec<String>,
    pub(super) warned: usize,
}

/// All pieces of a text, in its order.
pub(super) struct Pieces<'a> {
    list: Vec<Piece>,
    /// Where the data section starts: after `DATA;`.
    data: usize,
    /// Length of a piece, bytes.
    size: usize,
    call: Call<'a>,
}

/// A read that is cancelled leaves up to a whole file's instances.
impl Drop for Pieces<'_> {
    fn drop(&mut self) {
        self.call.each(1, &mut self.list, |piece| piece.parsed = None);
    }
}

impl<'a> Pieces<'a> {
    /// No pieces yet.
    pub(super) fn new(size: usize, call: Call<'a>) -> Self {
        Self { list: Vec::new(), data: 0, size, call }
    }

    /// Cuts the text into pieces. Those outside `changed` that are as before are kept.
    pub(super) fn cut(&mut self, text: &[u8], changed: &Range<usize>) -> Result<(), StepError> {
        let starts = self.starts(text)?;
        let ends = starts.iter().skip(1).copied().chain([text.len()]);
        let fresh = starts.iter().zip(ends).map(|(start, end)| Piece::new(*start..end)).collect();
        let mut old = std::mem::replace(&mut self.list, fresh);
        let mut kept =
            old.iter_mut().filter(|p| p.range.end <= changed.start || p.range.start >= changed.end).peekable();
        for piece in &mut self.list {
            while kept.next_if(|old| old.range.start < piece.range.start).is_some() {}
            // The last piece ends with the file's own end.
            if let Some(old) = kept.next_if(|old| old.range == piece.range)
                && piece.range.end < text.len()
            {
                piece.parsed = old.parsed.take();
            }
        }
        Ok(())
    }

    /// Where pieces start: at the first record on or after each multiple of their length. So most stay where they are
    /// when a record is blanked.
    fn starts(&mut self, text: &[u8]) -> Result<Vec<usize>, StepError> {
        let mut starts = vec![0];
        let (mut at, mut due) = (0, self.size);
        self.data = text.len();
        while let Some(end) = record_end(text, at) {
            if self.data == text.len() {
                if has_word(text, first_word(text, at), b"DATA") {
                    self.data = end;
                }
            } else if has_word(text, first_word(text, at), b"ENDSEC") {
                break;
            }
            at = end;
            if at >= due && at >= self.data && at < text.len() {
                starts.push(at);
                due = (at / self.size).saturating_add(1).saturating_mul(self.size);
                proceed(self.call.control)?;
            }
        }
        Ok(starts)
    }

    /// Parses what is not parsed yet. Returns the first error of the text, as the parser finds it in the whole.
    pub(super) fn parse(&mut self, text: &[u8]) -> Result<Option<Error>, StepError> {
        loop {
            self.parse_each(text)?;
            let bad = self.list.iter_mut().enumerate().find(|(_, piece)| !piece.is_sound());
            let Some((bad, piece)) = bad else { return Ok(self.repeated(text, self.list.len())) };
            let Some(Err(mut error)) = piece.parsed.take() else { continue };
            let (range, last) = (piece.range.clone(), bad + 1 == self.list.len());
            if self.list.len() == 1 {
                return Ok(Some(error));
            }
            let at = span_of(&mut error)
                .map(|span| if span.line > 0 { self.list[bad].place(span.start) } else { range.start });
            let inside = match (&error, at) {
                (Error::DuplicateEntityId { .. }, _) => true,
                (_, Some(at)) => last || at < range.end,
                _ => last,
            };
            if !inside {
                // The parser is not where the cut took it to be: the header is not what it seems.
                self.list = vec![Piece::new(0..text.len())];
                continue;
            }
            let in_header = range.start == 0 && at.is_some_and(|at| at < self.data);
            let records = self.records(text, range);
            if !in_header && records.len() > 1 {
                self.list.splice(bad..=bad, records);
                continue;
            }
            if let Some(span) = span_of(&mut error) {
                self.move_span(text, bad, span);
            }
            return Ok(self.repeated(text, bad).or(Some(error)));
        }
    }

    fn parse_each(&mut self, text: &[u8]) -> Result<(), StepError> {
        let one_at_a_time = Mutex::new(());
        let call = self.call;
        let waiting = self.list.iter_mut().filter(|piece| piece.parsed.is_none());
        let parsed = call.each(1, waiting, |piece| {
            let _turn = (piece.range.len() > LONG).then(|| one_at_a_time.lock());
            proceed(call.control)?;
            piece.parse(text);
            Ok(())
        });
        parsed.into_iter().collect()
    }

    /// The records of a piece, each a piece of its own. The header is one, and so is what follows the data section.
    fn records(&self, text: &[u8], range: Range<usize>) -> Vec<Piece> {
        let mut starts = vec![range.start];
        let mut at = range.start;
        if at == 0 {
            at = self.data;
            starts.push(at);
        }
        while let Some(end) = record_end(text, at).filter(|end| *end < range.end) {
            if has_word(text, first_word(text, at), b"ENDSEC") {
                break;
            }
            at = end;
            starts.push(at);
        }
        let ends = starts.iter().skip(1).copied().chain([range.end]);
        starts.iter().zip(ends).map(|(start, end)| Piece::new(*start..end)).collect()
    }

    /// The first instance in the file whose number an earlier one has, among the first `count` pieces.
    fn repeated(&self, text: &[u8], count: usize) -> Option<Error> {
        let pieces = &self.list[..count];
        let bounds = pieces.iter().filter_map(|p| Some((p.rows().first()?.id, p.rows().last()?.id)));
        if bounds.clone().zip(bounds.skip(1)).all(|((_, last), (first, _))| last < first) {
            return None;
        }
        let numbers = pieces.iter().enumerate().flat_map(|(k, piece)| piece.rows().iter().map(move |row| (row.id, k)));
        let mut numbers: Vec<(u64, usize)> = numbers.collect();
        // Numbers ascend within each piece, which this sort makes use of.
        numbers.sort();
        let place = |(id, k): (u64, usize)| {
            let row = pieces[k].rows().binary_search_by_key(&id, |row| row.id).ok()?;
            Some(pieces[k].place(u64::from(pieces[k].rows()[row].at)))
        };
        let repeats = numbers.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        let (at, pair) = repeats.filter_map(|pair| Some((place(pair[1])?, pair))).min_by_key(|(at, _)| *at)?;
        let line = |at| u32::try_from(lines(&text[..at])).map_or(u32::MAX, |lines| lines.saturating_add(1));
        Some(Error::DuplicateEntityId { id: pair[0].0, line: line(at), first_line: line(place(pair[0])?) })
    }

    /// Moves a span that the parser counts in the frame of piece `k` to where it is in the text.
    fn move_span(&self, text: &[u8], k: usize, span: &mut Span) {
        let piece = &self.list[k];
        // The parser states line 0 where it does not know the place.
        if piece.range.start == 0 || span.line == 0 {
            return;
        }
        for at in [&mut span.start, &mut span.end] {
            *at = piece.place(*at) as u64;
        }
        let start = piece.range.start;
        // The head of the frame is a line.
        if span.line == 2 {
            span.column = span.column.saturating_add(self.column(text, start));
        }
        span.line = (span.line - 1).saturating_add(u32::try_from(lines(&text[..start])).unwrap_or(u32::MAX));
    }

    /// Number of characters before `start`, where a piece starts, in its line.
    fn column(&self, text: &[u8], start: usize) -> u32 {
        let line = text[..start].iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
        let mut at = self.list.iter().rfind(|piece| piece.range.start <= line).map_or(0, |piece| piece.range.start);
        let mut column = 0;
        while at < start {
            let end = record_end(text, at).unwrap_or(start).min(start);
            let within = &text[line.max(at).min(end)..end];
            // The parser takes a record that is not UTF-8 for ISO 8859-1.
            let utf8 = std::str::from_utf8(&text[at..end]).is_ok();
            column += within.iter().filter(|b| !(utf8 && **b & 0xC0 == 0x80)).count();
            at = end;
        }
        u32::try_from(column).unwrap_or(u32::MAX)
    }

    /// All instances, and what the parser repaired.
    pub(super) fn join(mut self, text: &[u8]) -> Joined {
        let mut warnings = Vec::new();
        let mut warned = 0;
        for k in 0..self.list.len() {
            let Some(Ok(parsed)) = &mut self.list[k].parsed else { continue };
            warned += parsed.warned;
            for mut warning in std::mem::take(&mut parsed.warnings).into_iter().take(LISTED_WARNINGS - warnings.len()) {
                if let Some(span) = span_of_warning(&mut warning) {
                    self.move_span(text, k, span);
                }
                warnings.push(warning.to_string());
            }
        }
        let count = self.list.iter().map(|piece| piece.rows().len()).sum();
        let parsed = self.list.iter_mut().filter_map(|piece| piece.parsed.take()?.ok());
        let rows = Rows::joined(parsed.map(|parsed| parsed.rows), count);
        Joined { rows, warnings, warned }
    }
}

/// After the record that starts at `at`: after its `;`. `None` if the text ends before.
///
/// What may hold a `;` is skipped as the parser does it. Resources (`<…>`) are among that where repairs leave them.
fn record_end(text: &[u8], at: usize) -> Option<usize> {
    Some(next(text, at, b';', true)? + 1)
}

/// The first position from `at` on that is not white space or a comment.
fn first_word(text: &[u8], mut at: usize) -> usize {
    loop {
        at += text[at..].iter().take_while(|b| b.is_ascii_whitespace()).count();
        if !text[at..].starts_with(b"/*") {
            return at;
        }
        let Some(end) = find(&text[at + 2..], b"*/") else { return text.len() };
        at += end + 4;
    }
}

fn lines(text: &[u8]) -> usize {
    text.iter().filter(|b| **b == b'\n').count()
}

fn span_of(error: &mut Error) -> Option<&mut Span> {
    match error {
        Error::Lex(lex) => Some(&mut lex.span),
        Error::UnexpectedToken { span, .. }
        | Error::InvalidAttributePosition { span, .. }
        | Error::MalformedFileSchema { span }
        | Error::NestingTooDeep { span } => Some(span),
        _ => None,
    }
}

fn span_of_warning(warning: &mut ParseWarning) -> Option<&mut Span> {
    match warning {
        ParseWarning::MissingHeaderSemicolon { span, .. }
        | ParseWarning::EmptyAttribute { span }
        | ParseWarning::Ed3SectionDiscarded { span, .. }
        | ParseWarning::MalformedStringEscape { span }
        | ParseWarning::LowercaseHexEscape { span } => Some(span),
        _ => None,
    }
}
