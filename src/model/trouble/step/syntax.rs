//! Where the text of a STEP file breaks the syntax.

/// Where the text of a STEP file breaks the syntax, and how.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, column {column}: {what}")]
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
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SyntaxFault {
    /// No token starts with this character.
    #[error("no value or name starts with {found:?}")]
    Character {
        /// The character.
        found: char,
    },
    /// A string has no end.
    #[error("the string has no end")]
    UnterminatedString,
    /// A comment has no end.
    #[error("the comment has no end")]
    UnterminatedComment,
    /// A binary value is not hexadecimal.
    #[error("the binary value is not hexadecimal")]
    Binary,
    /// A number is out of range.
    #[error("the number is out of range")]
    Number,
    /// Something else is expected.
    #[error("{wanted} expected, {found} found")]
    Unexpected {
        /// What is expected.
        wanted: &'static str,
        /// The text that stands there, or its beginning.
        found: String,
    },
    /// Lists are nested too deeply.
    #[error("lists are nested more than {limit} deep")]
    Nesting {
        /// The most levels that are read.
        limit: usize,
    },
    /// An instance has too many types, or does not fit into 32 bits of addresses.
    #[error("the instance is too long")]
    TooLong,
    /// The text ends too early.
    #[error("the text ends here")]
    EndOfText,
    /// The header lacks an entity.
    #[error("the header has no {name}")]
    NotInHeader {
        /// Its type.
        name: &'static str,
    },
    /// An instance has the number of an earlier one.
    #[error("#{id} is the instance of line {first_line} already")]
    Repeated {
        /// The number.
        id: u64,
        /// Line of the earlier one, counted from 1.
        first_line: usize,
    },
}

/// What it took to read a text that breaks the rules. Nothing is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SyntaxRepair {
    /// An empty value was read as unset.
    #[error("an empty value was read as unset ($)")]
    EmptyValue,
    /// An escape sequence was read as it is written.
    #[error("an escape sequence was read as it is written")]
    Escape,
    /// Hexadecimal digits in small letters were read.
    #[error("hexadecimal digits in small letters were read")]
    LowercaseHexadecimal,
    /// A missing semicolon in the header was added.
    #[error("a missing semicolon in the header was added")]
    Semicolon,
}
