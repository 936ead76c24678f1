//! The tokens of Part 21 text. The crate `logos` makes the automaton that finds them.

use crate::model::SyntaxFault;
use logos::{Lexer, Logos};

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

#[cfg(test)]
mod tests {
    use super::{Token, Tokens, next_ink};

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
}
