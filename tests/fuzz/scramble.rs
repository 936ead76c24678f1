//! A few bytes -> edits of a Part 21 text that keep most of its grammar: arguments, references, numbers, whole
//! instances.

use crate::draw::{List, below, repeat};
use arbitrary::{Result, Unstructured};

/// Edits, applied in order.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Scrambled(List<Edit>);

/// One edit. Positions count tokens of their kind, modulo their number.
#[derive(Clone, PartialEq, Debug)]
enum Edit {
    /// Replaces a reference by another of the file.
    Reference { at: usize, from: usize },
    /// Replaces a number by another of the file.
    Number { at: usize, from: usize },
    /// Replaces a number by an extreme one.
    Extreme { at: usize, value: &'static str },
    /// Changes a number by a little.
    Nudge { at: usize, by: f64 },
    /// Replaces a keyword by another of the file.
    Keyword { at: usize, from: usize },
    /// Replaces any token.
    Token { at: usize, value: &'static str },
    /// Replaces an enumeration such as .T.
    Sense { at: usize, value: &'static str },
    /// Repeats a token and the comma before it.
    Repeat { at: usize, times: usize },
    /// Deletes a token.
    Delete { at: usize },
    /// Deletes an instance.
    Drop { at: usize },
    /// Replaces the text of an instance by that of another, keeping its number.
    Copy { at: usize, from: usize },
    /// Lets a reference to an instance name the last of some copies of it, which list the copy before ten times.
    FanOut { at: usize, levels: usize },
    /// Moves all points, each by up to `noise` more.
    Move { by: f64, noise: f64 },
}

const EXTREMES: [&str; 14] = [
    "0.",
    "-1.",
    "1.E9",
    "1.E300",
    "1.E-9",
    "1.E-300",
    "-1000.",
    "1.E400",
    "-0.",
    "1.",
    "3.7",
    "1.E-5",
    "6.283185307179586",
    "1000000",
];
const TOKENS: [&str; 14] =
    ["$", "*", "()", "(())", "''", ".T.", ".U.", "#1", "-1", "0", "#99999", "(#1,#2)", "1.5", "PLANE('',#20)"];
const SENSES: [&str; 8] = [".T.", ".F.", ".U.", ".PARAMETER.", ".UNSPECIFIED.", ".EXA.", ".KILO.", ".ATTO."];

impl Scrambled {
    pub(crate) fn draw(u: &mut Unstructured<'_>) -> Result<Self> {
        let count = 1 + below(u, 6)?;
        Ok(Self(repeat(count, || Edit::draw(u))?))
    }

    /// Applies the edits to `text`.
    pub(crate) fn of(&self, text: &str) -> String {
        let Some(data) = text.find("DATA;") else { return text.to_owned() };
        let (head, body) = text.split_at(data + 5);
        let mut tokens = tokens(body);
        self.0.iter().for_each(|edit| edit.apply(&mut tokens));
        tokens.iter().fold(head.to_owned(), |text, token| text + token)
    }
}

/// A position below 65536.
fn place(u: &mut Unstructured<'_>) -> Result<usize> {
    Ok(usize::from(u.arbitrary::<u16>()?))
}

impl Edit {
    fn draw(u: &mut Unstructured<'_>) -> Result<Self> {
        let at = place(u)?;
        Ok(match below(u, 18)? {
            0..=2 => Self::Reference { at, from: place(u)? },
            3 | 4 => Self::Number { at, from: place(u)? },
            5 | 6 => Self::Extreme { at, value: u.choose(&EXTREMES)? },
            7 | 8 => Self::Nudge { at, by: *u.choose(&[1.0 + 1e-4, -1.0, 1.0 + 1e-9, 2.0, 1e-3, 0.9])? },
            9 => Self::Keyword { at, from: place(u)? },
            10 => Self::Token { at, value: u.choose(&TOKENS)? },
            11 => Self::Sense { at, value: u.choose(&SENSES)? },
            12 => Self::Repeat { at, times: *u.choose(&[1, 2, 40, 2000])? },
            13 => Self::Delete { at },
            14 => Self::Drop { at },
            15 => Self::Copy { at, from: place(u)? },
            16 => Self::FanOut { at, levels: 1 + below(u, 20)? },
            _ => Self::Move {
                by: *u.choose(&[0.0, 1e4, 1e8, 1e12, 1e16])?,
                noise: *u.choose(&[0.0, 1e-9, 1e-6, 1e-3, 1.0])?,
            },
        })
    }

    fn apply(&self, tokens: &mut Vec<String>) {
        let find = |is: fn(&str) -> bool, n: usize| nth(tokens, is, n);
        let copied =
            |is: fn(&str) -> bool, at: usize, from: usize| Some((find(is, at)?, tokens[find(is, from)?].clone()));
        let one = |is: fn(&str) -> bool, at: usize, value: &str| Some((find(is, at)?, value.to_owned()));
        let change = match *self {
            Self::Reference { at, from } => copied(is_reference, at, from),
            Self::Number { at, from } => copied(is_number, at, from),
            Self::Extreme { at, value } => one(is_number, at, value),
            Self::Nudge { at, by } => find(is_number, at).map(|k| {
                let x: f64 = tokens[k].parse().unwrap_or(1.0);
                (k, real(x * by))
            }),
            Self::Keyword { at, from } => copied(is_keyword, at, from),
            Self::Token { at, value } => one(is_value, at, value),
            Self::Sense { at, value } => one(is_enumeration, at, value),
            Self::Repeat { at, times } => find(is_value, at).map(|k| {
                let token = &tokens[k];
                (k, format!("{token}{}", format!(",{token}").repeat(times)))
            }),
            Self::Delete { at } => one(is_value, at, ""),
            Self::Drop { at } => return drop(instance(tokens, at).map(|range| tokens.drain(range))),
            Self::Copy { at, from } => {
                let (Some(to), Some(from)) = (instance(tokens, at), instance(tokens, from)) else { return };
                // Without the number.
                let text: Vec<String> = tokens[from.start + 1..from.end].to_vec();
                return drop(tokens.splice(to.start + 1..to.end, text));
            }
            Self::FanOut { at, levels } => return fan_out(tokens, at, levels),
            Self::Move { by, noise } => return move_points(tokens, by, noise),
        };
        if let Some((k, value)) = change {
            tokens[k] = value;
        }
    }
}

/// References of each copy of a [`Edit::FanOut`].
const FAN: usize = 10;

fn fan_out(tokens: &mut Vec<String>, at: usize, levels: usize) {
    let Some(range) = instance(tokens, at) else { return };
    let of: Vec<String> = tokens[range.clone()].to_vec();
    let number = |token: &String| token.strip_prefix('#')?.parse().ok();
    let mut last: u64 = tokens.iter().filter_map(number).max().unwrap_or(0);
    let Some(listed) = (1..of.len()).find(|&k| is_reference(&of[k])) else { return };
    let users = |k: &usize| tokens[*k] == of[0] && tokens.get(k + 1).is_some_and(|next| next != "=");
    let Some(user) = (0..tokens.len()).find(users) else { return };
    let mut previous = of[0].clone();
    for _ in 0..levels {
        last = last.saturating_add(1);
        let mut copy = of.clone();
        copy[0] = format!("#{last}");
        copy[listed] = [&previous[..]; FAN].join(",");
        previous.clone_from(&copy[0]);
        let behind = range.end;
        tokens.splice(behind..behind, copy);
    }
    let user = if user < range.end { user } else { user + levels * of.len() };
    tokens[user] = previous;
}

fn move_points(tokens: &mut [String], by: f64, noise: f64) {
    let mut in_point = false;
    for (k, token) in tokens.iter_mut().enumerate() {
        if is_keyword(token) {
            in_point = token == "CARTESIAN_POINT";
        } else if in_point && is_number(token) {
            // The golden ratio spreads the numbers of the tokens over the unit interval.
            let share = (k as f64 * 0.618_033_988_749_895).fract();
            let x: f64 = token.parse().unwrap_or(0.0);
            *token = real(x + by + noise * (share - 0.5));
        }
    }
}

/// A number as Part 21 writes it, with a point.
fn real(x: f64) -> String {
    let text = format!("{x:?}");
    if text.contains('.') { text.replace('e', "E") } else { text.replace('e', ".E") }
}

fn nth(tokens: &[String], is: fn(&str) -> bool, n: usize) -> Option<usize> {
    let count = tokens.iter().filter(|token| is(token)).count();
    tokens.iter().enumerate().filter(|(_, token)| is(token)).nth(n.checked_rem(count)?).map(|(k, _)| k)
}

/// The tokens of an instance, from its number to its semicolon.
fn instance(tokens: &[String], n: usize) -> Option<std::ops::Range<usize>> {
    let starts: Vec<usize> = (1..tokens.len()).filter(|&k| tokens[k] == "=").map(|k| k - 1).collect();
    let start = starts[n.checked_rem(starts.len())?];
    let end = start + tokens[start..].iter().position(|token| token == ";")? + 1;
    Some(start..end)
}

fn is_reference(token: &str) -> bool {
    token.starts_with('#')
}

fn is_number(token: &str) -> bool {
    token.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+')
}

fn is_keyword(token: &str) -> bool {
    token.starts_with(|c: char| c.is_ascii_uppercase())
}

fn is_enumeration(token: &str) -> bool {
    token.starts_with('.')
}

fn is_value(token: &str) -> bool {
    is_reference(token) || is_number(token) || is_enumeration(token) || token.starts_with(['\'', '$', '*'])
}

/// Splits text into tokens, without white space.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let word = |end: fn(char) -> bool| rest[1..].find(end).map_or(rest.len(), |k| k + 1);
        let length = match first {
            '\'' => rest[1..].find('\'').map_or(rest.len(), |k| k + 2),
            '.' => rest[1..].find('.').map_or(rest.len(), |k| k + 2),
            '#' => word(|c| !c.is_ascii_digit()),
            '0'..='9' | '-' | '+' => word(|c| !(c.is_ascii_digit() || "+-.E".contains(c))),
            'A'..='Z' => word(|c| !(c.is_ascii_alphanumeric() || c == '_' || c == '-')),
            _ => first.len_utf8(),
        };
        let (token, after) = rest.split_at(length);
        tokens.push(token.to_owned());
        rest = after.trim_start();
    }
    tokens
}
