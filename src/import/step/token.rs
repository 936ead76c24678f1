//! Part 21 text -> tokens, and what stands between the quotes of a string -> its characters. The crate `logos` makes
//! the automaton that finds tokens.

use crate::model::{SyntaxFault, SyntaxRepair};
use logos::{Lexer, Logos};
use std::borrow::Cow;

/// A token, without its text. White space and comments lie between tokens.
#[derive(Clone, Copy, Debug, Logos, PartialEq, Eq)]
#[logos(utf8 = false)]
#[logos(skip r"[ \t\r\n\x0C]+")]
#[logos(skip r"/\*((?-u:[^*])|\*+(?-u:[^*/]))*\*+/")]
pub(super) enum Token {
    /// No token: the text ends, or what follows starts none.
    Nothing,
    #[token("(")]
    Open,
    #[token(")")]
    Close,
    #[token(",")]
    Comma,
    #[token(";")]
    Semicolon,
    #[token("=")]
    Equals,
    #[token("$")]
    Unset,
    #[token("*")]
    Derived,
    #[regex(r"[+-]?[0-9]+")]
    Integer,
    /// Also `.5` and `1e-16`, which the standard does not have: programs print them, and other readers take them.
    #[regex(r"[+-]?[0-9]+\.[0-9]*([Ee][+-]?[0-9]+)?")]
    #[regex(r"[+-]?\.[0-9]+([Ee][+-]?[0-9]+)?")]
    #[regex(r"[+-]?[0-9]+[Ee][+-]?[0-9]+")]
    Real,
    /// With its quotes. A doubled quote is part of it.
    #[regex(r"'((?-u:[^'])|'')*'")]
    Text,
    /// With its dots.
    #[regex(r"\.[A-Za-z_][A-Za-z0-9_]*\.")]
    Enumeration,
    #[regex(r#""[0-3][0-9A-Fa-f]*""#)]
    Binary,
    /// With its `#`.
    #[regex(r"#[0-9]+")]
    Reference,
    /// The name of a type or section. That of a type that is not in a standard starts with `!`.
    #[regex(r"!?[A-Za-z_][A-Za-z0-9_]*")]
    Keyword,
    /// `ISO-10303-21`
    #[regex(r"(?i-u)ISO-10303-21", priority = 10)]
    FileStart,
    /// `END-ISO-10303-21`
    #[regex(r"(?i-u)END-ISO-10303-21", priority = 10)]
    FileEnd,
    /// `@n`, `@NAME` or `#NAME`: a value that the data sections do not define.
    #[regex(r"(@[A-Za-z0-9]|#[A-Za-z])[A-Za-z0-9_]*")]
    Foreign,
    /// `<…>`: a value in another file.
    #[regex(r"<(?-u:[^>\n])*>")]
    Resource,
}

/// What is parsed, or why not. Faults are boxed, so that results stay small.
pub(super) type Parse<T> = Result<T, Box<SyntaxFault>>;

/// The tokens of a text from a place on.
pub(super) struct Tokens<'t> {
    text: &'t [u8],
    /// The place from which `lexer` counts.
    base: usize,
    lexer: Lexer<'t, Token>,
}

impl<'t> Tokens<'t> {
    /// The tokens of `text` from its byte `at` on, even if that is inside a string or a comment.
    pub(super) fn new(text: &'t [u8], at: usize) -> Self {
        let base = at.min(text.len());
        Self { text, base, lexer: Token::lexer(&text[base..]) }
    }

    /// Goes on from byte `at` of the text.
    pub(super) fn seek(&mut self, at: usize) {
        *self = Self::new(self.text, at);
    }

    /// The next token. What follows [`Token::Nothing`] is not specified.
    #[inline]
    pub(super) fn next(&mut self) -> Token {
        match self.lexer.next() {
            Some(Ok(token)) => token,
            _ => Token::Nothing,
        }
    }

    fn no_token(&self) -> SyntaxFault {
        match self.text.get(self.start()) {
            None => SyntaxFault::EndOfText,
            Some(b'\'') => SyntaxFault::UnterminatedString,
            Some(b'"') => SyntaxFault::Binary,
            Some(b'/') if self.text.get(self.start() + 1) == Some(&b'*') => SyntaxFault::UnterminatedComment,
            _ => SyntaxFault::Character { found: first_char(&self.text[self.start()..]) },
        }
    }

    /// Fails unless the next token is `wanted`, which has a `name` in messages.
    pub(super) fn expect(&mut self, wanted: Token, name: &'static str) -> Parse<()> {
        let found = self.next();
        if found == wanted { Ok(()) } else { Err(self.unexpected(found, name)) }
    }

    /// The fault that the last token, `found`, is not what is `wanted`.
    pub(super) fn unexpected(&self, found: Token, wanted: &'static str) -> Box<SyntaxFault> {
        const MOST: usize = 40;
        if found == Token::Nothing {
            return Box::new(self.no_token());
        }
        let slice = self.slice();
        let mut found: String =
            String::from_utf8_lossy(&slice[..slice.len().min(4 * MOST)]).chars().take(MOST).collect();
        if found.len() < slice.len() {
            found.push('…');
        }
        Box::new(SyntaxFault::Unexpected { wanted, found })
    }

    /// Where the last token starts; the end of the text where there was none.
    pub(super) fn start(&self) -> usize {
        self.base + self.lexer.span().start
    }

    /// Where the last token ends.
    pub(super) fn end(&self) -> usize {
        self.base + self.lexer.span().end
    }

    /// The text of the last token.
    pub(super) fn slice(&self) -> &'t [u8] {
        self.lexer.slice()
    }
}

/// The first character of a text in UTF-8, or else in ISO 8859-1.
fn first_char(text: &[u8]) -> char {
    let most = &text[..text.len().min(4)];
    let sound = most.utf8_chunks().next().and_then(|chunk| chunk.valid().chars().next());
    sound.unwrap_or_else(|| most.first().map_or(' ', |byte| char::from(*byte)))
}

/// Whether the whole word `word` starts at byte `at`, in any case.
pub(super) fn has_word(text: &[u8], at: usize, word: &[u8]) -> bool {
    let end = at + word.len();
    let same = text.get(at..end).is_some_and(|found| found.eq_ignore_ascii_case(word));
    same && !text.get(end).is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_' || *b == b'-')
}

/// The first place from byte `at` on that is not white space or in a short comment.
pub(super) fn next_ink(text: &[u8], mut at: usize) -> Option<usize> {
    /// Longer comments are not passed over: each of many places would look for the same end.
    const SHORT: usize = 256;
    loop {
        at += text.get(at..)?.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let Some(comment) = text[at..].strip_prefix(b"/*") else { return Some(at) };
        let near = &comment[..comment.len().min(SHORT)];
        let Some(end) = near.windows(2).position(|end| end == b"*/") else { return Some(at) };
        at += end + 4;
    }
}

/// Appends the value of a string to `out`, and returns what it took to read it.
///
/// `raw` is what stands between the quotes, in UTF-8 or else ISO 8859-1. Line breaks are dropped: programs break long
/// lines. A directive that breaks the rules of ISO 10303-21, or selects an alphabet other than ISO 8859-1, stays as it
/// is written.
pub(super) fn decode(raw: &[u8], out: &mut String) -> Option<SyntaxRepair> {
    // Most names are empty.
    if raw.is_empty() {
        return None;
    }
    let text: Cow<'_, str> = match std::str::from_utf8(raw) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(raw.iter().map(|byte| char::from(*byte)).collect()),
    };
    if !text.bytes().any(|byte| matches!(byte, b'\'' | b'\\' | b'\r' | b'\n')) {
        out.push_str(&text);
        return None;
    }
    let text = text.replace("''", "'").replace(['\r', '\n'], "");
    let mut rest = text.as_str();
    let (mut latin, mut repair) = (true, None);
    while let Some(at) = rest.find('\\') {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        let length = if let Some(page) = page(rest) {
            latin = page == b'A';
            if latin { Some(4) } else { None }
        } else {
            directive(rest, latin, out, &mut repair)
        };
        let length = length.unwrap_or_else(|| {
            let length = as_written(rest);
            out.push_str(&rest[..length]);
            repair = Some(SyntaxRepair::Escape);
            length
        });
        rest = &rest[length..];
    }
    out.push_str(rest);
    repair
}

/// The letter of `\PA\` to `\PI\`, which select the part of ISO 8859 of `\S\`.
fn page(text: &str) -> Option<u8> {
    match text.as_bytes() {
        [b'\\', b'P', letter @ b'A'..=b'I', b'\\', ..] => Some(*letter),
        _ => None,
    }
}

/// Appends the character or characters of the directive that `text` starts with, and returns its length. `None` if it
/// breaks the rules.
fn directive(text: &str, latin: bool, out: &mut String, repair: &mut Option<SyntaxRepair>) -> Option<usize> {
    let bytes = text.as_bytes();
    if bytes.starts_with(b"\\\\") {
        out.push('\\');
        return Some(2);
    }
    let (digits, length) = match bytes.get(1..3)? {
        b"S\\" => {
            let character = *bytes.get(3).filter(|byte| latin && matches!(byte, 0x20..=0x7E))?;
            out.push(char::from(character | 0x80));
            return Some(4);
        }
        b"X\\" => {
            let digits = text.get(3..5)?;
            out.push(char::from(u8::try_from(hexadecimal(digits)?).ok()?));
            (digits, 5)
        }
        b"X2" | b"X4" => {
            let digits = run(text)?;
            out.push_str(&characters(digits, if bytes[2] == b'2' { 4 } else { 8 })?);
            (digits, digits.len() + 8)
        }
        _ => return None,
    };
    if digits.bytes().any(|digit| digit.is_ascii_lowercase()) {
        repair.get_or_insert(SyntaxRepair::LowercaseHexadecimal);
    }
    Some(length)
}

/// The digits between `\X2\` or `\X4\` and `\X0\`.
fn run(text: &str) -> Option<&str> {
    let rest = text.strip_prefix("\\X2\\").or_else(|| text.strip_prefix("\\X4\\"))?;
    let (digits, end) = rest.split_at(rest.bytes().take_while(u8::is_ascii_hexdigit).count());
    end.starts_with("\\X0\\").then_some(digits)
}

/// Characters of `width` hexadecimal digits each: units of UTF-16, or code points.
fn characters(digits: &str, width: usize) -> Option<String> {
    if digits.is_empty() || !digits.len().is_multiple_of(width) {
        return None;
    }
    let codes = (0..digits.len()).step_by(width).map(|at| hexadecimal(&digits[at..at + width]));
    if width == 4 {
        let units: Option<Vec<u16>> = codes.map(|code| u16::try_from(code?).ok()).collect();
        String::from_utf16(&units?).ok()
    } else {
        codes.map(|code| char::from_u32(code?)).collect()
    }
}

fn hexadecimal(digits: &str) -> Option<u32> {
    // The parser of the standard library takes a sign.
    digits.bytes().all(|digit| digit.is_ascii_hexdigit()).then(|| u32::from_str_radix(digits, 16).ok())?
}

/// Length of a directive that stays as it is written.
fn as_written(text: &str) -> usize {
    let bytes = text.as_bytes();
    match (bytes.get(1..3), run(text), page(text), bytes.get(3)) {
        (_, Some(digits), ..) => digits.len() + 8,
        (_, _, Some(_), _) | (Some(b"S\\"), _, _, Some(0x20..=0x7E)) => 4,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::{Token, Tokens, decode, next_ink};
    use crate::model::SyntaxRepair;

    #[test]
    fn long_runs_of_one_token_take_no_stack() {
        for (text, token) in [
            (b"/**/ ".repeat(200_000), Token::Close),
            ([b"/*".to_vec(), b"* x ".repeat(200_000), b"*/".to_vec()].concat(), Token::Close),
            ([b"'".to_vec(), b"''".repeat(200_000), b"'".to_vec()].concat(), Token::Text),
        ] {
            let text = [text, b")".to_vec()].concat();
            assert_eq!(Tokens::new(&text, 0).next(), token);
        }
    }

    #[test]
    fn short_comments_are_passed_over() {
        let long = format!("/*{}*/ 1", " ".repeat(300));
        for (text, at) in [(" /* a */\n/**/1", Some(13)), ("/*1", Some(0)), ("  ", None), (&long, Some(0))] {
            assert_eq!(next_ink(text.as_bytes(), 0), at, "{text}");
        }
    }

    #[test]
    fn strings_have_the_values_that_the_standard_gives_them() {
        let escape = Some(SyntaxRepair::Escape);
        for (raw, value, repair) in [
            (&b""[..], "", None),
            (b"it''s", "it's", None),
            (b"a\r\nb", "ab", None),
            (br"a\\b", r"a\b", None),
            (br"\X2\03B103B2\X0\!", "αβ!", None),
            (br"\X2\D83DDE00\X0\", "😀", None),
            (br"\X4\0001F600\X0\", "😀", None),
            (br"\X\E9t\X\E9", "été", None),
            (br"\X\e9", "é", Some(SyntaxRepair::LowercaseHexadecimal)),
            (br"\S\v\PA\\S\v", "öö", None),
            (b"\xE9", "é", None),
            ("é".as_bytes(), "é", None),
            (br"\PB\\S\v", r"\PB\\S\v", escape),
            (br"\PB\\PA\\S\v", r"\PB\ö", escape),
            (br"\X2\zz\X0\", r"\X2\zz\X0\", escape),
            (br"\X2\D83D\X0\", r"\X2\D83D\X0\", escape),
            (br"\X2\00E9", r"\X2\00E9", escape),
            (br"\X\+1", r"\X\+1", escape),
            (br"\n\", r"\n\", escape),
            (br"\X2\123\X0\", r"\X2\123\X0\", escape),
        ] {
            let mut out = "before ".to_owned();
            let found = decode(raw, &mut out);
            assert_eq!((out.as_str(), found), (format!("before {value}").as_str(), repair), "{raw:?}");
        }
    }

    #[test]
    fn many_directives_without_an_end_take_one_pass() {
        let raw = br"\X2\ ".repeat(1 << 20);
        let mut out = String::new();
        assert_eq!((decode(&raw, &mut out), out.as_bytes()), (Some(SyntaxRepair::Escape), raw.as_slice()));
    }
}
