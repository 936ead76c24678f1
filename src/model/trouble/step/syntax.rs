//! Where the text of a STEP file breaks the syntax.

use std::fmt;

/// Where the text of a STEP file breaks the syntax, and how.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SyntaxError {
    /// Line, counted from 1.
    pub line: usize,
    /// Column, counted from 1: a character of UTF-8.
    pub column: usize,
    /// What is wrong there.
    pub what: SyntaxFault,
}

/// How a text breaks the syntax.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SyntaxFault {
    /// No token starts with this character.
    Character {
        /// The character.
        found: char,
    },
    /// A string has no end.
    UnterminatedString,
    /// A comment has no end.
    UnterminatedComment,
    /// A binary value is not hexadecimal.
    Binary,
    /// A number is out of range.
    Number,
    /// Something else is expected.
    Unexpected {
        /// What is expected.
        wanted: &'static str,
        /// The text that stands there, or its beginning.
        found: String,
    },
    /// Lists are nested too deeply.
    Nesting {
        /// The most levels that are read.
        limit: usize,
    },
    /// An instance has too many types, or does not fit into 32 bits of addresses.
    TooLong,
    /// The text ends too early.
    EndOfText,
    /// The header lacks an entity.
    NotInHeader {
        /// Its type.
        name: &'static str,
    },
    /// An instance has the number of an earlier one.
    Repeated {
        /// The number.
        id: u64,
        /// Line of the earlier one, counted from 1.
        first_line: usize,
    },
}

/// What it took to read a text that breaks the rules. Nothing is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SyntaxRepair {
    /// An empty value was read as unset.
    EmptyValue,
    /// An escape sequence was read as it is written.
    Escape,
    /// Hexadecimal digits in small letters were read.
    LowercaseHexadecimal,
    /// A missing semicolon in the header was added.
    Semicolon,
}

impl std::error::Error for SyntaxError {}

impl fmt::Display for SyntaxError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}: {}", self.line, self.column, self.what)
    }
}

impl fmt::Display for SyntaxFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Character { found } => write!(f, "no value or name starts with {found:?}"),
            Self::UnterminatedString => f.write_str("the string has no end"),
            Self::UnterminatedComment => f.write_str("the comment has no end"),
            Self::Binary => f.write_str("the binary value is not hexadecimal"),
            Self::Number => f.write_str("the number is out of range"),
            Self::Unexpected { wanted, found } => write!(f, "{wanted} expected, {found} found"),
            Self::Nesting { limit } => write!(f, "lists are nested more than {limit} deep"),
            Self::TooLong => f.write_str("the instance is too long"),
            Self::EndOfText => f.write_str("the text ends here"),
            Self::NotInHeader { name } => write!(f, "the header has no {name}"),
            Self::Repeated { id, first_line } => write!(f, "#{id} is the instance of line {first_line} already"),
        }
    }
}

impl fmt::Display for SyntaxRepair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::EmptyValue => "an empty value was read as unset ($)",
            Self::Escape => "an escape sequence was read as it is written",
            Self::LowercaseHexadecimal => "hexadecimal digits in small letters were read",
            Self::Semicolon => "a missing semicolon in the header was added",
        })
    }
}
