//! The bytes of a file -> the bytes of a mutant.

use crate::points::Points;
use crate::random::SplitMix;
use std::ops::Range;

/// A way to mutate a file.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Mutation {
    /// The file ends early.
    Truncated,
    /// Some bytes are replaced.
    Flipped,
    /// Some lines are missing.
    LinesGone,
    /// Some references point to other instances.
    References,
    /// Some numbers are replaced.
    Numbers,
    /// A list names its references many times.
    Repeated,
    /// An instance is replaced by copies of its holder that name each other, ten times each.
    FannedOut,
    /// All points are far from the origin.
    Far,
    /// Lengths have another unit, up to 1e18 times as large or small.
    Units,
    /// Points move by a share of their part.
    Noisy,
}

/// Replacement numbers that are likely to cause trouble.
const NUMBERS: [&str; 12] =
    ["0.", "-1.", "1.E9", "1.E300", "1.E-9", "3.7", "-1000.", "1.E-300", "1.E400", "-0.", "1.E-5", "360."];

impl Mutation {
    pub(crate) const ALL: [Self; 10] = [
        Self::Truncated,
        Self::Flipped,
        Self::LinesGone,
        Self::References,
        Self::Numbers,
        Self::Repeated,
        Self::FannedOut,
        Self::Far,
        Self::Units,
        Self::Noisy,
    ];

    pub(crate) fn of(self, bytes: &[u8], random: &mut SplitMix) -> Vec<u8> {
        let length = bytes.len() as u64;
        match self {
            Self::Truncated => bytes[..random.below(length) as usize].to_vec(),
            Self::Flipped => {
                let mut bytes = bytes.to_vec();
                for _ in 0..1 + random.below(4) {
                    bytes[random.below(length) as usize] = random.below(256) as u8;
                }
                bytes
            }
            Self::LinesGone => {
                let mut lines: Vec<&[u8]> = bytes.split(|&byte| byte == b'\n').collect();
                for _ in 0..1 + random.below(5) {
                    if lines.len() > 1 {
                        lines.remove(random.below(lines.len() as u64) as usize);
                    }
                }
                lines.join(&b'\n')
            }
            Self::References => {
                let all = references(bytes);
                let edits = (0..1 + random.below(5)).filter_map(|_| {
                    let (at, from) = (random.choose(&all)?.clone(), random.choose(&all)?.clone());
                    Some((at, bytes[from].to_vec()))
                });
                edited(bytes, edits.collect())
            }
            Self::Numbers => numbers(bytes, random),
            Self::Repeated => repeated(bytes, random),
            Self::FannedOut => fanned_out(bytes, random),
            Self::Far => {
                let far = 10_f64.powi(3 + random.below(13) as i32);
                Points::of(bytes).shifted([0, 1, 2].map(|_| far * random.range(-1.0, 1.0)))
            }
            Self::Units => {
                let (from, to) = (b".MILLI.,.METRE.", format!("{},.METRE.", PREFIXES[random.below(8) as usize]));
                let places = bytes.windows(from.len()).enumerate().filter(|(_, window)| window == from);
                let edits = places.map(|(at, _)| (at..at + from.len(), to.clone().into_bytes()));
                edited(bytes, edits.collect())
            }
            Self::Noisy => {
                let share = 10_f64.powi(-1 - random.below(6) as i32);
                Points::of(bytes).moved(share, random)
            }
        }
    }
}

/// Prefixes of units.
const PREFIXES: [&str; 8] = [".EXA.", ".PETA.", ".KILO.", ".DECI.", ".MICRO.", ".NANO.", ".PICO.", ".ATTO."];

fn numbers(bytes: &[u8], random: &mut SplitMix) -> Vec<u8> {
    let is_number = |byte: u8| byte.is_ascii_digit() || b".E+-".contains(&byte);
    let all = tokens(bytes, |byte| byte.is_ascii_digit() || byte == b'-', is_number);
    let reals: Vec<_> = all.into_iter().filter(|range| bytes[range.clone()].contains(&b'.')).collect();
    let edits = (0..1 + random.below(5)).filter_map(|_| {
        let at = random.choose(&reals)?.clone();
        let other = random.choose(&reals)?.clone();
        let value = match random.below(2) {
            0 => bytes[other].to_vec(),
            _ => random.choose(&NUMBERS)?.as_bytes().to_vec(),
        };
        Some((at, value))
    });
    edited(bytes, edits.collect())
}

/// Repeats the references of a list, up to ten thousand times in all.
fn repeated(bytes: &[u8], random: &mut SplitMix) -> Vec<u8> {
    let Some(list) = random.choose(&lists(bytes)).cloned() else { return bytes.to_vec() };
    let text = &bytes[list.clone()];
    let length = text.split(|&byte| byte == b',').count();
    let times = 1 + random.below((10_000 / length).max(1) as u64) as usize;
    let many = std::iter::repeat_n(text, times).collect::<Vec<_>>().join(&b',');
    edited(bytes, vec![(list, many)])
}

/// Adds copies of an instance whose list names the previous copy ten times, and lets a reference to the instance name
/// the last copy.
fn fanned_out(bytes: &[u8], random: &mut SplitMix) -> Vec<u8> {
    /// References of each copy.
    const FAN: usize = 10;
    let whole = || bytes.to_vec();
    let Some(list) = random.choose(&lists(bytes)).cloned() else { return whole() };
    let Some(start) = bytes[..list.start].iter().rposition(|&byte| byte == b';') else { return whole() };
    let Some(length) = bytes[list.end..].iter().position(|&byte| byte == b';') else { return whole() };
    let (before, after) = (&bytes[start + 1..list.start], &bytes[list.end..list.end + length + 1]);
    let all = references(bytes);
    let number = |token: &Range<usize>| std::str::from_utf8(&bytes[token.start + 1..token.end]).ok()?.parse().ok();
    let Some(equals) = before.iter().position(|&byte| byte == b'=') else { return whole() };
    let Some(own) = all.iter().find(|token| token.start > start) else { return whole() };
    let named: Vec<_> = all.iter().filter(|token| bytes[(*token).clone()] == bytes[own.clone()]).skip(1).collect();
    let Some(user) = random.choose(&named) else { return whole() };
    let mut last: u64 = all.iter().filter_map(number).max().unwrap_or(0);
    let mut previous = bytes[own.clone()].to_vec();
    let mut copies = Vec::new();
    for _ in 0..2 + random.below(19) {
        last = last.saturating_add(1);
        let fan = [&previous[..]; FAN].join(&b',');
        let name = format!("#{last}").into_bytes();
        copies.extend([&b"\n"[..], &name, &before[equals..], &fan, after].concat());
        previous = name;
    }
    let end = list.end + length + 1;
    edited(bytes, vec![((*user).clone(), previous), (end..end, copies)])
}

/// Lists of references, without their parentheses.
fn lists(bytes: &[u8]) -> Vec<Range<usize>> {
    let is_reference = |byte: u8| byte == b'#' || byte == b',' || byte.is_ascii_digit() || byte.is_ascii_whitespace();
    let all = tokens(bytes, |byte| byte == b'(', is_reference).into_iter();
    let closed = all.filter(|list| bytes.get(list.end) == Some(&b')') && bytes.get(list.start + 1) == Some(&b'#'));
    closed.map(|list| list.start + 1..list.end).collect()
}

fn references(bytes: &[u8]) -> Vec<Range<usize>> {
    tokens(bytes, |byte| byte == b'#', |byte| byte.is_ascii_digit())
}

/// Runs of bytes that start with `starts` and continue with `goes_on`.
fn tokens(bytes: &[u8], starts: impl Fn(u8) -> bool, goes_on: impl Fn(u8) -> bool) -> Vec<Range<usize>> {
    let mut all = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        if !starts(bytes[at]) {
            at += 1;
            continue;
        }
        let length = bytes[at + 1..].iter().take_while(|&&byte| goes_on(byte)).count();
        all.push(at..at + 1 + length);
        at += 1 + length;
    }
    all
}

/// Replaces some ranges of `bytes`. Of several edits with the same start, the first counts.
fn edited(bytes: &[u8], mut edits: Vec<(Range<usize>, Vec<u8>)>) -> Vec<u8> {
    edits.sort_by_key(|(range, _)| range.start);
    edits.dedup_by_key(|(range, _)| range.start);
    let mut out = Vec::with_capacity(bytes.len());
    let mut done = 0;
    for (range, value) in edits {
        out.extend_from_slice(&bytes[done..range.start]);
        out.extend(value);
        done = range.end;
    }
    out.extend_from_slice(&bytes[done..]);
    out
}
