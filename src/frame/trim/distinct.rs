//! Loops with repeated points -> loops without, triangulated by some rung, and closed where points were dropped.

use super::close;
use super::input::{TrimInput, TrimInputError};
use super::output::{TrimOutcome, TrimOutput};
use glam::{DVec2, DVec3};

/// Loops without segments of length zero, and the origin of their points.
#[derive(Default)]
pub(crate) struct Distinct {
    pub(crate) points: Vec<DVec2>,
    /// Their positions in space; empty if the input has none.
    pub(crate) places: Vec<DVec3>,
    pub(crate) loop_starts: Vec<u32>,
    /// By point, its index in the input.
    pub(crate) original: Vec<u32>,
    /// Whether the last input had repeated points.
    pub(crate) repeats: bool,
    /// Whether a dropped point is elsewhere in space than the point that it repeats.
    pub(crate) moves: bool,
}

impl Distinct {
    /// Copies the loops without repeated points. Returns false, and copies nothing, if no point is repeated.
    pub(crate) fn collect(&mut self, input: &TrimInput<'_>) -> bool {
        let points = input.points;
        let repeats = |l: std::ops::Range<u32>| {
            let l = &points[l.start as usize..l.end as usize];
            l.windows(2).any(|w| w[0] == w[1]) || (!l.is_empty() && l[0] == l[l.len() - 1])
        };
        self.repeats = input.loops().any(repeats);
        self.moves = false;
        if !self.repeats {
            return false;
        }
        let place = |v: u32| input.places.get(v as usize);
        let differ = |v: u32, w: u32| place(v).is_none() || place(v) != place(w);
        self.points.clear();
        self.places.clear();
        self.original.clear();
        self.loop_starts.clear();
        self.loop_starts.push(0);
        for l in input.loops() {
            let start = self.points.len();
            for v in l {
                let p = points[v as usize];
                if self.points[start..].last() == Some(&p) {
                    self.moves |= self.original.last().is_some_and(|&w| differ(v, w));
                } else {
                    self.points.push(p);
                    self.places.extend(place(v));
                    self.original.push(v);
                }
            }
            while self.points.len() > start && self.points[start] == self.points[self.points.len() - 1] {
                self.points.pop();
                self.places.pop();
                let (left_out, first) = (self.original.pop(), self.original.get(start));
                self.moves |= left_out.zip(first).is_some_and(|(v, &w)| differ(v, w));
            }
            self.loop_starts.push(self.points.len() as u32);
        }
        true
    }

    pub(crate) fn tile<'a>(&'a self, input: &TrimInput<'_>) -> TrimInput<'a> {
        TrimInput { cells: input.cells, points: &self.points, loop_starts: &self.loop_starts, places: &self.places }
    }
}

/// Triangulates the loops without repeated points by `rung`, and closes what remains open.
pub(crate) fn by_distinct(
    input: &TrimInput<'_>,
    distinct: &mut Distinct,
    out: &mut TrimOutput,
    rung: impl FnOnce(&TrimInput<'_>, &mut TrimOutput) -> TrimOutcome,
) -> Result<TrimOutcome, TrimInputError> {
    out.clear();
    input.validate()?;
    let mut outcome = if distinct.collect(input) {
        let outcome = rung(&distinct.tile(input), out);
        let (ours, theirs) = (distinct.original.len() as u32, input.points.len() as u32);
        out.rename(0, |v| if v < ours { distinct.original[v as usize] } else { v - ours + theirs });
        outcome
    } else {
        rung(input, out)
    };
    // The other rungs have proven that nothing is open. Dropped points can still leave gaps in space.
    if out.stats.whole_tile || distinct.moves {
        close::close(input, out);
        let is_simple = out.closing.is_empty() && out.layers.is_empty();
        outcome = outcome.max(if is_simple { TrimOutcome::Certified } else { TrimOutcome::Repaired { split: 0 } });
    }
    out.stats.outcome = outcome;
    Ok(outcome)
}
