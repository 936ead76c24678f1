//! The records of a data section -> instances. Recursive descent over tokens; a record that breaks the syntax is cut
//! out, and parsing goes on at the next one.

use super::token::{Parse, Token, Tokens, decode, has_word, next_ink};
use super::values::{COMPLEX, Row, Stretch, Types, Value, Values};
use crate::model::{SyntaxCut, SyntaxFault, SyntaxRepair};
use std::ops::Range;

/// Number of repairs that get a note each.
pub(super) const LISTED_REPAIRS: usize = 8;
/// Bytes of text per value and per instance, in most files at least.
const BYTES_PER_VALUE: usize = 10;
const BYTES_PER_ROW: usize = 40;
/// Maximum number of types of an instance. Real ones have up to 10, and who looks for one looks at all.
const MAX_PARTS: usize = 256;
/// Maximum nesting of lists in an instance. Real files stay below 6.
const MAX_NESTING: usize = 64;

/// Where a text breaks the syntax, and what was left out for it.
pub(super) struct Fault {
    /// Where the record starts, byte of the text.
    pub(super) start: usize,
    /// Byte of the text.
    pub(super) at: usize,
    pub(super) fault: SyntaxFault,
    pub(super) cut: SyntaxCut,
}

/// Why parsing stopped.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Reach {
    /// The end of the range is reached. Records may follow.
    Next,
    /// Behind the end of the file, or at the end of the text.
    End,
    /// There were too many faults.
    Faults,
}

/// What the records of a range of the text state.
pub(super) struct Parsed {
    /// The range that was asked for, bytes of the text.
    pub(super) range: Range<usize>,
    /// Where parsing stopped, and why.
    pub(super) stop: usize,
    pub(super) reach: Reach,
    pub(super) values: Values,
    /// In the order of the text.
    pub(super) rows: Vec<Row>,
    /// Whether their numbers ascend.
    pub(super) is_in_order: bool,
    pub(super) types: Types,
    pub(super) faults: Vec<Fault>,
    /// The first [`LISTED_REPAIRS`] of all `repaired`, with their places.
    pub(super) repairs: Vec<(usize, SyntaxRepair)>,
    pub(super) repaired: usize,
    /// Number of values defined elsewhere: `<…>`, and `@n` or `#NAME`.
    pub(super) foreign: [usize; 2],
    /// Number of data sections that follow another one.
    pub(super) joints: usize,
}

/// Parses the records that start in `range`, of which the first starts at its start. Stops after more than
/// `most_faults`.
pub(super) fn parse(text: &[u8], range: Range<usize>, most_faults: usize) -> Parsed {
    let length = range.len().min(text.len());
    let values = Values { list: Vec::with_capacity(length / BYTES_PER_VALUE), text: String::new() };
    let mut parser = Parser {
        text,
        tokens: Tokens::new(text, range.start),
        open: Vec::new(),
        done: Parsed {
            stop: range.start,
            reach: Reach::Next,
            values,
            rows: Vec::with_capacity(length / BYTES_PER_ROW),
            is_in_order: true,
            types: Types::default(),
            faults: Vec::new(),
            repairs: Vec::new(),
            repaired: 0,
            foreign: [0; 2],
            joints: 0,
            range,
        },
    };
    while parser.done.reach == Reach::Next && parser.done.stop < parser.done.range.end {
        parser.record();
        if parser.done.faults.len() > most_faults {
            parser.done.reach = Reach::Faults;
        }
    }
    let mut done = parser.done;
    done.values.list.shrink_to_fit();
    done.values.text.shrink_to_fit();
    done.rows.shrink_to_fit();
    done
}

struct Parser<'t> {
    text: &'t [u8],
    tokens: Tokens<'t>,
    /// Values of lists that are not closed yet.
    open: Vec<Value>,
    done: Parsed,
}

impl<'t> Parser<'t> {
    /// Parses a record, or cuts it out.
    fn record(&mut self) {
        let (values, text) = (self.done.values.list.len(), self.done.values.text.len());
        let (repairs, repaired, foreign) = (self.done.repairs.len(), self.done.repaired, self.done.foreign);
        let first = self.tokens.next();
        let start = self.tokens.start();
        let in_end = first == Token::Keyword && has_word(self.text, start, b"ENDSEC");
        let parsed = if in_end { self.section_end() } else { self.instance(first, start) };
        match parsed {
            Ok(goes_on) => {
                self.done.stop = self.tokens.end();
                if !goes_on {
                    self.done.reach = Reach::End;
                }
            }
            Err(fault) => {
                self.done.values.list.truncate(values);
                self.done.values.text.truncate(text);
                self.done.repairs.truncate(repairs);
                (self.done.repaired, self.done.foreign) = (repaired, foreign);
                self.open.clear();
                self.cut(*fault, start, in_end, first == Token::FileEnd);
            }
        }
    }

    /// Goes on behind a record that starts at `start`. `in_end`: it is the end of a section. `is_end`: it is the end of
    /// the file, before that of the section.
    fn cut(&mut self, fault: SyntaxFault, start: usize, in_end: bool, is_end: bool) {
        let at = self.tokens.start();
        let (cut, next) = if is_end {
            self.behind_end()
        } else {
            match next_record(self.text, start) {
                _ if in_end && at < self.text.len() => (SyntaxCut::SectionEnd, Some(at)),
                Some(next) if !in_end => {
                    (number(&self.text[start..]).map_or(SyntaxCut::Text, SyntaxCut::Instance), Some(next))
                }
                _ => (SyntaxCut::End, None),
            }
        };
        self.done.faults.push(Fault { start, at, fault, cut });
        self.done.stop = next.unwrap_or(if is_end { self.tokens.end() } else { self.text.len() });
        self.tokens.seek(self.done.stop);
        if next.is_none() {
            self.done.reach = Reach::End;
        }
    }

    /// Where to go on behind the end of the file: where an instance follows. Another file may follow, too.
    fn behind_end(&mut self) -> (SyntaxCut, Option<usize>) {
        let is_whole = self.tokens.expect(Token::Semicolon, "';'").is_ok();
        let end = self.tokens.end();
        let goes_on = is_whole && next_ink(self.text, end).is_some_and(|next| starts_instance(&self.text[next..]));
        if goes_on { (SyntaxCut::Text, Some(end)) } else { (SyntaxCut::End, None) }
    }

    /// What follows `ENDSEC`: the end of the file, or another data section. Returns whether more records may follow.
    fn section_end(&mut self) -> Parse<bool> {
        self.tokens.expect(Token::Semicolon, "';'")?;
        match self.tokens.next() {
            Token::FileEnd => {
                self.tokens.expect(Token::Semicolon, "';'")?;
                Ok(false)
            }
            Token::Keyword if self.tokens.slice().eq_ignore_ascii_case(b"DATA") => {
                data(&mut self.tokens)?;
                self.done.joints += 1;
                Ok(true)
            }
            other => Err(self.tokens.unexpected(other, "END-ISO-10303-21 or DATA")),
        }
    }

    /// An instance, after its first token. Always `true`: more records may follow.
    fn instance(&mut self, first: Token, start: usize) -> Parse<bool> {
        if first != Token::Reference {
            return Err(self.tokens.unexpected(first, "an instance or ENDSEC"));
        }
        let id = self.reference()?;
        self.tokens.expect(Token::Equals, "'='")?;
        let (kind, attributes) = match self.tokens.next() {
            Token::Keyword => (self.kind(), self.parameters()?),
            Token::Open => (COMPLEX, self.parts()?),
            other => return Err(self.tokens.unexpected(other, "the name of a type or '('")),
        };
        self.tokens.expect(Token::Semicolon, "';'")?;
        let at = u32::try_from(start - self.done.range.start).map_err(|_| SyntaxFault::TooLong)?;
        self.done.is_in_order &= self.done.rows.last().is_none_or(|last| last.id < id);
        self.done.rows.push(Row { id, at, kind, attributes });
        Ok(true)
    }

    /// The types of a complex instance, after its bracket.
    fn parts(&mut self) -> Parse<Stretch> {
        let base = self.open.len();
        loop {
            match self.tokens.next() {
                Token::Keyword if self.open.len() - base == MAX_PARTS => return Err(Box::new(SyntaxFault::TooLong)),
                Token::Keyword => {
                    let part = Value::Part(self.kind(), self.parameters()?);
                    self.open.push(part);
                }
                Token::Close if self.open.len() > base => return self.closed(base),
                other => return Err(self.tokens.unexpected(other, "the name of a type or ')'")),
            }
        }
    }

    fn parameters(&mut self) -> Parse<Stretch> {
        self.tokens.expect(Token::Open, "'('")?;
        self.items(0)
    }

    /// A list, after its bracket.
    fn items(&mut self, depth: usize) -> Parse<Stretch> {
        let base = self.open.len();
        let mut token = self.tokens.next();
        if token == Token::Close {
            return self.closed(base);
        }
        loop {
            let value = if matches!(token, Token::Comma | Token::Close) {
                self.repair(SyntaxRepair::EmptyValue);
                Value::Unset
            } else {
                let value = self.value(token, depth)?;
                token = self.tokens.next();
                value
            };
            self.open.push(value);
            match token {
                Token::Comma => token = self.tokens.next(),
                Token::Close => return self.closed(base),
                _ => return Err(self.tokens.unexpected(token, "',' or ')'")),
            }
        }
    }

    /// Moves the open values from `base` on to where closed lists are.
    fn closed(&mut self, base: usize) -> Parse<Stretch> {
        let list = &mut self.done.values.list;
        let stretch = Stretch::new(list.len(), self.open.len() - base).ok_or(SyntaxFault::TooLong)?;
        list.extend_from_slice(&self.open[base..]);
        self.open.truncate(base);
        Ok(stretch)
    }

    /// A value, after its first token.
    fn value(&mut self, first: Token, depth: usize) -> Parse<Value> {
        if depth >= MAX_NESTING && first != Token::Nothing {
            return Err(Box::new(SyntaxFault::Nesting { limit: MAX_NESTING }));
        }
        let slice = self.tokens.slice();
        let inside = || slice.get(1..slice.len() - 1).unwrap_or_default();
        Ok(match first {
            Token::Unset => Value::Unset,
            Token::Derived => Value::Derived,
            Token::Integer => Value::Integer(ascii(slice).parse().map_err(|_| SyntaxFault::Number)?),
            Token::Real => {
                let value = fast_float2::parse(slice).ok().filter(|value: &f64| value.is_finite());
                Value::Real(value.ok_or(SyntaxFault::Number)?)
            }
            Token::Reference => Value::Reference(self.reference()?),
            Token::Text => Value::Text(self.string(inside())?),
            Token::Enumeration => Value::Enumeration(self.append(|text| {
                let start = text.len();
                text.push_str(ascii(inside()));
                text[start..].make_ascii_uppercase();
            })?),
            Token::Binary => Value::Binary,
            Token::Open => Value::List(self.items(depth + 1)?),
            Token::Keyword => {
                self.tokens.expect(Token::Open, "'('")?;
                let token = self.tokens.next();
                let inner = self.value(token, depth + 1)?;
                self.tokens.expect(Token::Close, "')'")?;
                self.open.push(inner);
                Value::Typed(self.closed(self.open.len() - 1)?)
            }
            Token::Resource | Token::Foreign => {
                self.done.foreign[usize::from(first == Token::Foreign)] += 1;
                Value::Unset
            }
            _ => return Err(self.tokens.unexpected(first, "a value")),
        })
    }

    fn string(&mut self, raw: &[u8]) -> Parse<Stretch> {
        let mut repair = None;
        let stretch = self.append(|text| repair = decode(raw, text))?;
        if let Some(repair) = repair {
            self.repair(repair);
        }
        Ok(stretch)
    }

    /// Appends to the text of all values.
    fn append(&mut self, write: impl FnOnce(&mut String)) -> Parse<Stretch> {
        let text = &mut self.done.values.text;
        let start = text.len();
        write(text);
        Ok(Stretch::new(start, text.len() - start).ok_or(SyntaxFault::TooLong)?)
    }

    /// The number of the reference that was the last token.
    fn reference(&self) -> Parse<u64> {
        let mut digits = self.tokens.slice().iter().skip(1).map(|digit| u64::from(digit - b'0'));
        let number = digits.try_fold(0_u64, |number, digit| number.checked_mul(10)?.checked_add(digit));
        Ok(number.ok_or(SyntaxFault::Number)?)
    }

    /// Index of the type whose name was the last token.
    fn kind(&mut self) -> u32 {
        self.done.types.index(self.tokens.slice())
    }

    fn repair(&mut self, what: SyntaxRepair) {
        self.done.repaired += 1;
        if self.done.repairs.len() < LISTED_REPAIRS {
            self.done.repairs.push((self.tokens.start(), what));
        }
    }
}

/// What follows `DATA`: the name and schema of the section, if it has them, and a semicolon.
pub(super) fn data(tokens: &mut Tokens<'_>) -> Parse<()> {
    let mut depth = 0_usize;
    loop {
        match tokens.next() {
            Token::Semicolon if depth == 0 => return Ok(()),
            Token::Open => depth += 1,
            Token::Close if depth > 0 => depth -= 1,
            Token::Text | Token::Comma if depth > 0 => {}
            other => return Err(tokens.unexpected(other, "';'")),
        }
    }
}

/// Numbers, names and words are ASCII.
fn ascii(text: &[u8]) -> &str {
    std::str::from_utf8(text).unwrap_or_default()
}

/// The number of the instance at the start of the text, with its `#`.
fn number(instance: &[u8]) -> Option<String> {
    let digits = instance.strip_prefix(b"#")?.iter().take_while(|b| b.is_ascii_digit()).take(20);
    let number: String = std::iter::once('#').chain(digits.map(|b| char::from(*b))).collect();
    (number.len() > 1).then_some(number)
}

/// Where to go on after a record that starts at `at` and breaks the syntax: behind the first semicolon that an
/// instance, the end of the section or of the file, or nothing follows. Quotes do not count: one may be missing. `None`
/// without such a semicolon.
fn next_record(text: &[u8], at: usize) -> Option<usize> {
    let mut ends = text.iter().enumerate().skip(at).filter(|(_, b)| **b == b';').map(|(i, _)| i + 1);
    ends.find(|end| {
        next_ink(text, *end).is_none_or(|next| {
            starts_instance(&text[next..])
                || has_word(text, next, b"ENDSEC")
                || has_word(text, next, b"END-ISO-10303-21")
        })
    })
}

/// Whether the text starts with a number and `=`.
pub(super) fn starts_instance(text: &[u8]) -> bool {
    let Some(rest) = text.strip_prefix(b"#") else { return false };
    let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    digits > 0 && rest[digits..].iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'=')
}

#[cfg(test)]
mod tests {
    use super::{Value, parse};

    #[test]
    fn reals_are_rounded_as_by_the_standard_library() {
        let digits =
            ["0.", "-0.", "+1.5", "1.E+05", "1.e-5", "007.25", "0.1000000000000000055511151231257827021181583"];
        let limits = [
            "4.9E-324",
            "2.4E-324",
            "1.E-400",
            "1.7976931348623157E308",
            "9007199254740993.",
            "123456789012345678901.5",
        ];
        for text in digits.into_iter().chain(limits) {
            let record = format!("#1=P({text});");
            let parsed = parse(record.as_bytes(), 0..record.len(), 1);
            let [Value::Real(value)] = parsed.values.list[..] else { panic!("{text}: {:?}", parsed.values.list) };
            assert_eq!(value.to_bits(), text.parse::<f64>().map_or(0, f64::to_bits), "{text}");
        }
        let parsed = parse(b"#1=P(1.E400);", 0..13, 1);
        assert_eq!((parsed.rows.len(), parsed.faults.len()), (0, 1));
    }
}
