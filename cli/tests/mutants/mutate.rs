//! The bytes of a file -> the bytes of a mutant.

use crate::random::Random;
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
}

/// Replacement numbers that are likely to cause trouble.
const NUMBERS: [&str; 12] =
    ["0.", "-1.", "1.E9", "1.E300", "1.E-9", "3.7", "-1000.", "1.E-300", "1.E400", "-0.", "1.E-5", "360."];

impl Mutation {
    pub(crate) const ALL: [Self; 5] =
        [Self::Truncated, Self::Flipped, Self::LinesGone, Self::References, Self::Numbers];

    pub(crate) fn of(self, bytes: &[u8], random: &mut Random) -> Vec<u8> {
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
                let all = tokens(bytes, |byte| byte == b'#', |byte| byte.is_ascii_digit());
                let edits = (0..1 + random.below(5)).filter_map(|_| {
                    let (at, from) = (random.choose(&all)?.clone(), random.choose(&all)?.clone());
                    Some((at, bytes[from].to_vec()))
                });
                edited(bytes, edits.collect())
            }
            Self::Numbers => {
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
        }
    }
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
