//! Earlier lines and a changed density -> lines that meet the new density, most of them the earlier ones.
//!
//! The incremental evaluation of Kumar and Manocha (*Efficient rendering of trimmed NURBS surfaces*, Computer-Aided
//! Design 27(7), 1995). To go from n intervals to n̄, take the smallest K with K·n > n̄ and put K − 2 lines into
//! each interval. Then put one more into intervals that fail the criteria: into all of them, or into the first n̄ −
//! (K − 1)·n. The paper leaves open how to test an interval. Here an interval passes if it meets the density of
//! every strip that it touches.

use crate::frame::plan::density::{Criteria, FollowLines};
use crate::frame::plan::output::{EdgePolyline, TileLattice};
use std::num::NonZeroU32;

/// How lattice lines and tessellants follow densities that change from frame to frame.
///
/// With either choice, lines are placed from scratch for new tiles and edges, and whenever settings common to all views
/// change (angle, size, limits).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum LinePlacement {
    /// Place all lines of a tile and all tessellants of an edge from scratch: the fewest that meet the tolerance,
    /// spaced as evenly as possible.
    #[default]
    Spread,
    /// Keep lines and insert new ones between them. Remove a line once the interval without it meets the tolerance.
    /// Place lines from scratch where there would be too many.
    Split {
        /// Which intervals get new lines.
        intensive: SplitRule,
        /// Upper bound on the number of lines, as a multiple of what `Spread` would place. Range 1 to 2. Splitting
        /// never exceeds 2, so at 2 lines always stay. At 1.25 hardly any interval is split, but lines that still meet
        /// the tolerance stay for longer.
        most: f64,
        /// Place the lines of each visible tile from scratch every N frames, if any of them is an earlier one. Tiles
        /// take turns, even while nothing moves; an edge goes with the first of its tiles that is visible. `None`
        /// disables this.
        resync: Option<NonZeroU32>,
    },
}

/// Which intervals are split when a density rises.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SplitRule {
    /// All intervals that fail the criteria: every frame meets the tolerance.
    Criterion,
    /// As many intervals as it takes to reach the number of lines of `Spread`, the longest first. The others are up to
    /// twice too long: until the next resynchronisation, triangles may deviate by up to four times the tolerance, and
    /// turn by up to twice.
    LongestFirst,
}

/// The last lines of a tile or an edge, and which intervals between them to split.
pub(crate) struct LastLines<'a, T: ?Sized> {
    pub(crate) last: &'a T,
    pub(crate) intensive: SplitRule,
    /// Upper bound on the number of gaps, as a multiple of the fewest that meet the density.
    pub(crate) most: f64,
}

impl<T: ?Sized> Clone for LastLines<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: ?Sized> Copy for LastLines<'_, T> {}

impl<'a, T: ?Sized> LastLines<'a, T> {
    /// The same for a part of `last`.
    fn part<U: ?Sized>(self, part: impl FnOnce(&'a T) -> &'a U) -> LastLines<'a, U> {
        LastLines { last: part(self.last), intensive: self.intensive, most: self.most }
    }
}

impl FollowLines for LastLines<'_, TileLattice> {
    fn follow(&self, axis: usize, criteria: Criteria<'_>, ends: (f64, f64), limit: usize, out: &mut Vec<f64>) -> bool {
        criteria.follow(self.part(|last| if axis == 0 { &last.us[..] } else { &last.vs }), ends, limit, out)
    }
}

impl FollowLines for LastLines<'_, EdgePolyline> {
    fn follow(&self, _: usize, criteria: Criteria<'_>, ends: (f64, f64), limit: usize, out: &mut Vec<f64>) -> bool {
        criteria.follow(self.part(|last| &last.ts[..]), ends, limit, out)
    }
}

/// Largest fullness of an interval that passes. Above 1 because placed lines are rounded.
const FULL: f64 = 1.0 + 2e-6;
/// Largest fullness of an interval that waits to be split.
const WAITS: f64 = 2.0 * FULL;
/// Distance, in lines of the density, at which an old line is too close to a new end and is removed.
const CLOSE: f64 = 1.0 / 16.0;

impl Criteria<'_> {
    /// Appends parameters after `a` and up to `b > a`, strictly increasing and ending with `b`: the last lines that are
    /// still needed, and new ones.
    ///
    /// With [`SplitRule::Criterion`] they meet the density; with [`SplitRule::LongestFirst`], half of it and `least`.
    /// Falls back to `Density::spread` if there would be more than [`LastLines::most`] times the lines that it places,
    /// or more than `limit`. Returns whether `limit` allows the density. Cost: about three times the number of gaps.
    fn follow(&self, before: LastLines<'_, [f64]>, (a, b): (f64, f64), limit: usize, out: &mut Vec<f64>) -> bool {
        let needed = self.density.fewest(a, b, limit + 1);
        if needed <= limit {
            let split = self.split(&self.lines_inside(before.last, a, b), before.intensive, limit);
            let mut lines = self.joined(&split);
            if before.intensive == SplitRule::LongestFirst {
                self.fill(&mut lines, needed);
            }
            if (lines.len() - 1) as f64 <= (before.most * needed as f64).min(limit as f64) {
                out.extend_from_slice(&lines[1..]);
                return true;
            }
        }
        self.density.spread(a, b, limit, out)
    }

    /// The last lines from `a` to `b`, without those too close to an end that is new.
    fn lines_inside(&self, last: &[f64], a: f64, b: f64) -> Vec<f64> {
        let (from, to) = (last.partition_point(|&x| x <= a), last.partition_point(|&x| x < b));
        let mut inside = &last[from..to];
        let close = |end: f64, x: f64, beyond: f64| {
            let (low, high) = (end.min(beyond), end.max(beyond));
            self.density.fullness(low, high) * (x - end).abs() <= CLOSE * (high - low)
        };
        let is_new = |k: Option<usize>, end: f64| k.and_then(|k| last.get(k)) != Some(&end);
        while is_new(from.checked_sub(1), a)
            && let [x, rest @ ..] = inside
            && close(a, *x, *rest.first().unwrap_or(&b))
        {
            inside = rest;
        }
        while is_new(Some(to), b)
            && let [rest @ .., x] = inside
            && close(b, *x, *rest.last().unwrap_or(&a))
        {
            inside = rest;
        }
        [&[a], inside, &[b]].concat()
    }

    /// Cuts each interval that fails into the fewest that pass, or into one fewer (K − 1 instead of K) if those may
    /// wait.
    fn split(&self, lines: &[f64], intensive: SplitRule, limit: usize) -> Vec<f64> {
        let mut out = vec![lines[0]];
        for ends in lines.windows(2) {
            let (from, to, start) = (ends[0], ends[1], out.len());
            let fullness = self.density.fullness(from, to);
            if fullness <= FULL {
                out.push(to);
                continue;
            }
            if intensive == SplitRule::LongestFirst {
                let needed = self.density.fewest(from, to, limit);
                // An interval that holds exactly K − 1 lines is cut into K − 1.
                let exactly = fullness / needed as f64;
                let fewer = if (1.0 / FULL..=FULL).contains(&exactly) { needed } else { needed - 1 };
                self.density.spread(from, to, fewer.max(1), &mut out);
                if out[start - 1..].windows(2).all(|w| self.may_wait(w[0], w[1])) {
                    continue;
                }
                out.truncate(start);
            }
            self.density.spread(from, to, limit, &mut out);
        }
        out
    }

    /// Removes lines where the interval without them passes.
    fn joined(&self, lines: &[f64]) -> Vec<f64> {
        let mut out = vec![lines[0]];
        for w in lines[1..].windows(2) {
            if self.density.fullness(out[out.len() - 1], w[1]) > FULL {
                out.push(w[0]);
            }
        }
        out.push(lines[lines.len() - 1]);
        out
    }

    fn may_wait(&self, from: f64, to: f64) -> bool {
        self.density.fullness(from, to) <= WAITS && self.least.fullness(from, to) <= FULL
    }

    /// Halves intervals that fail, the fullest first and each at most once, until there are `needed` intervals.
    fn fill(&self, lines: &mut Vec<f64>, needed: usize) {
        let missing = (needed + 1).saturating_sub(lines.len());
        if missing == 0 {
            return;
        }
        let fullness = lines.windows(2).map(|w| self.density.fullness(w[0], w[1])).enumerate();
        let mut failing: Vec<(usize, f64)> = fullness.filter(|(_, fullness)| *fullness > FULL).collect();
        failing.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        failing.truncate(missing);
        let mut halved = vec![false; lines.len()];
        failing.iter().for_each(|&(k, _)| halved[k] = true);
        let mut out = vec![lines[0]];
        for (ends, halved) in lines.windows(2).zip(halved) {
            self.density.spread(ends[0], ends[1], if halved { 2 } else { 1 }, &mut out);
        }
        *lines = out;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::plan::density::Density;
    use crate::sequence::judge;
    use arbitrary::Unstructured;

    const LIMIT: usize = 4096;
    const BOTH: [SplitRule; 2] = [SplitRule::Criterion, SplitRule::LongestFirst];

    /// A density whose tables are leaked.
    fn dense(breaks: &[f64], rates: &[f64]) -> Density<'static> {
        Density { breaks: breaks.to_vec().leak(), rates: rates.to_vec().leak() }
    }

    fn even(rate: f64) -> Density<'static> {
        dense(&[0.0, 1.0], &[rate])
    }

    fn follow(last: &[f64], density: Density<'_>, least: Density<'_>, intensive: SplitRule) -> Vec<f64> {
        let (a, b) = (last[0], last[last.len() - 1]);
        let mut lines = vec![a];
        let kept =
            Criteria { density, least }.follow(LastLines { last, intensive, most: 2.0 }, (a, b), LIMIT, &mut lines);
        assert!(kept && lines.is_sorted_by(|x, y| x < y) && lines[lines.len() - 1] == b, "{lines:?}");
        lines
    }

    fn spread(density: Density<'_>, a: f64, b: f64) -> Vec<f64> {
        let mut lines = vec![a];
        density.spread(a, b, LIMIT, &mut lines);
        lines
    }

    fn fullest(density: Density<'_>, lines: &[f64]) -> f64 {
        lines.windows(2).map(|w| density.fullness(w[0], w[1])).fold(0.0, f64::max)
    }

    fn has_all(lines: &[f64], old: &[f64]) -> bool {
        old.iter().all(|x| lines.contains(x))
    }

    #[test]
    fn ten_intervals_become_fourteen_as_in_the_paper() {
        let ten = spread(even(10.0), 0.0, 1.0);
        let lines = follow(&ten, even(14.0), even(0.0), SplitRule::LongestFirst);
        // K = 2: no line into every interval, and four of the ten are split.
        assert!(lines.len() == 15 && has_all(&lines, &ten), "{lines:?}");
        let whole = lines.windows(2).filter(|w| (w[1] - w[0] - 0.1).abs() < 1e-12).count();
        assert_eq!(whole, 6);
        assert!((fullest(even(14.0), &lines).powi(2) - 1.96).abs() < 1e-9);
        // The other six are split before any interval is split again.
        let lines = follow(&lines, even(20.0), even(0.0), SplitRule::LongestFirst);
        assert!(lines.len() == 21 && has_all(&lines, &ten) && fullest(even(20.0), &lines) < 1.000_001, "{lines:?}");
        // K = 4: two lines into each, and three more.
        let lines = follow(&ten, even(33.0), even(0.0), SplitRule::LongestFirst);
        assert!(lines.len() == 34 && has_all(&lines, &ten), "{lines:?}");
        assert!((fullest(even(33.0), &lines) - 1.1).abs() < 1e-9, "{lines:?}");
        // All intervals fail, so all are split.
        assert_eq!(follow(&ten, even(14.0), even(0.0), SplitRule::Criterion).len(), 21);
    }

    #[test]
    fn intervals_over_the_least_density_do_not_wait() {
        let ten = spread(even(10.0), 0.0, 1.0);
        for (least, count) in [(10.0, 14), (10.1, 20)] {
            let lines = follow(&ten, even(14.0), even(least), SplitRule::LongestFirst);
            assert_eq!((lines.len() - 1, has_all(&lines, &ten)), (count, true), "{least}: {lines:?}");
        }
    }

    #[test]
    fn lines_are_removed_when_the_interval_without_them_passes() {
        let twenty = spread(even(20.0), 0.0, 1.0);
        for intensive in BOTH {
            assert_eq!(follow(&twenty, even(10.1), even(0.0), intensive), twenty);
            let ten = follow(&twenty, even(10.0), even(0.0), intensive);
            assert_eq!(ten, twenty.iter().copied().step_by(2).collect::<Vec<_>>());
            assert_eq!(follow(&twenty, even(0.0), even(0.0), intensive), [0.0, 1.0]);
        }
    }

    #[test]
    fn crowded_lines_and_lines_close_to_an_end_are_removed() {
        // Thirty gaps, each just under half as long as allowed, are joined in pairs. Splitting alone never makes so
        // many.
        let thirty: Vec<f64> = (0..=30).map(|k| f64::from(k) / 30.0).collect();
        let density = dense(&[0.0, 1.0, 1.0 + 1e-3], &[14.9, 1.0]);
        assert_eq!(follow(&thirty, density, even(0.0), SplitRule::Criterion).len() - 1, 15);
        let close = [-0.1, 1e-9, 0.5, 1.0 - 1e-9, 1.5];
        let before = LastLines { last: &close[..], intensive: SplitRule::Criterion, most: 2.0 };
        let mut lines = vec![0.0];
        assert!(Criteria { density: even(2.0), least: even(0.0) }.follow(before, (0.0, 1.0), LIMIT, &mut lines));
        assert_eq!(lines, [0.0, 0.5, 1.0]);
        // A line at the border of a dense strip is not too close to the end.
        let border = dense(&[0.0, 0.1, 1.0], &[0.1, 10.0]);
        let lines = spread(border, 0.0, 1.0);
        assert!(lines.contains(&0.1));
        assert_eq!(follow(&lines, border, even(0.0), SplitRule::Criterion), lines);
    }

    #[test]
    fn too_many_lines_are_placed_from_scratch() {
        let thirteen = spread(even(13.0), 0.0, 1.0);
        let follow = |rate: f64, most: f64| {
            let (density, mut lines) = (even(rate), vec![0.0]);
            let before = LastLines { last: &thirteen[..], intensive: SplitRule::Criterion, most };
            Criteria { density, least: density }.follow(before, (0.0, 1.0), LIMIT, &mut lines);
            lines
        };
        for (rate, most, count) in
            [(10.4, 1.1, 11), (10.4, 1.3, 13), (10.0, 1.3, 13), (9.9, 1.25, 10), (14.0, 1.25, 14), (14.0, 2.0, 26)]
        {
            assert_eq!(follow(rate, most).len() - 1, count, "{rate} {most}");
        }
    }

    #[test]
    fn lines_over_the_limit_are_spread() {
        let ten = spread(even(10.0), 0.0, 1.0);
        let (density, least) = (even(33.0), even(0.0));
        for (limit, allowed) in [(20, false), (33, true), (40, true)] {
            for intensive in BOTH {
                let (mut lines, mut fresh) = (vec![0.0], vec![0.0]);
                let before = LastLines { last: &ten[..], intensive, most: 2.0 };
                let kept = Criteria { density, least }.follow(before, (0.0, 1.0), limit, &mut lines);
                assert_eq!(kept, density.spread(0.0, 1.0, limit, &mut fresh));
                assert!(kept == allowed && lines.len() - 1 <= limit, "{limit}: {lines:?}");
                assert!(allowed || lines == fresh);
            }
        }
    }

    #[test]
    fn any_sequence_of_densities_is_followed() {
        let property = |u: &mut Unstructured<'_>| -> arbitrary::Result<()> {
            let strips = u.int_in_range(1..=5_usize)?;
            let mut breaks = vec![f64::from(u.int_in_range(-100..=100_i32)?)];
            for k in 0..strips {
                breaks.push(breaks[k] + 10.0_f64.powi(u.int_in_range(-3..=1)?) * f64::from(u.int_in_range(1..=9_u8)?));
            }
            let (a, b) = (breaks[0], breaks[strips]);
            let intensive = BOTH[usize::from(u.arbitrary::<bool>()?)];
            let mut lines: Option<Vec<f64>> = None;
            let mut rates: Vec<f64> = Vec::new();
            for _ in 0..12 {
                // New densities, or a step of all of them.
                if rates.is_empty() || u.ratio(1, 6)? {
                    let rate = |u: &mut Unstructured<'_>| Ok(f64::from(u.int_in_range(0..=999_u16)?) * 0.1 / (b - a));
                    rates = (0..strips).map(|_| rate(u)).collect::<arbitrary::Result<_>>()?;
                } else {
                    let by = 2.0_f64.powf(f64::from(u.int_in_range(-6..=6_i8)?) / 4.0);
                    rates.iter_mut().for_each(|rate| *rate = (*rate * by).min(300.0 / (b - a)));
                }
                let share = f64::from(u.int_in_range(0..=8_u8)?) / 8.0;
                let density = dense(&breaks, &rates);
                let least = dense(&breaks, &rates.iter().map(|r| share * r).collect::<Vec<_>>());
                let needed = density.fewest(a, b, LIMIT);
                let Some(old) = lines else {
                    lines = Some(spread(density, a, b));
                    continue;
                };
                let new = follow(&old, density, least, intensive);
                let case = format!("{intensive:?} {breaks:?} {rates:?} {share}: {} {}", old.len(), new.len());
                assert!(new.len() - 1 < 2 * needed, "{needed} {case}");
                let (full, strict) = (fullest(density, &new), fullest(least, &new));
                let most = if intensive == SplitRule::LongestFirst { WAITS } else { FULL };
                assert!(full <= most * FULL && strict <= FULL * FULL, "{full} {strict} {case}");
                if new != spread(density, a, b) {
                    // A line that goes leaves an interval that passes or may wait, and no interval that passes is cut.
                    let around = |x: f64| (new.partition_point(|y| *y < x), new.partition_point(|y| *y <= x));
                    let gone = old.iter().map(|&x| around(x)).filter(|(k, next)| k == next);
                    assert!(
                        gone.into_iter().all(|(k, _)| density.fullness(new[k - 1], new[k]) <= most * FULL),
                        "{case}"
                    );
                    let cut = |w: &[f64]| new.iter().any(|&x| x > w[0] && x < w[1]);
                    let passes = |w: &&[f64]| density.fullness(w[0], w[1]) <= FULL && has_all(&new, w);
                    let needless = old.windows(2).filter(passes).find(|w| cut(w));
                    assert!(needless.is_none(), "{needless:?} {case}");
                }
                if full <= FULL {
                    assert_eq!(follow(&new, density, least, intensive), new, "{case}");
                }
                lines = Some(new);
            }
            Ok(())
        };
        judge!(3_000, 400, |bytes: &[u8]| property(&mut Unstructured::new(bytes)).is_ok());
    }
}
