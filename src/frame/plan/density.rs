//! A density of lines along a parameter -> the fewest lines that meet it, spaced as evenly as it allows.

use crate::math::lanes::{larger, smaller};

/// A piecewise constant density of lines along one parameter.
#[derive(Clone, Copy)]
pub(crate) struct Density<'a> {
    /// Strip borders, increasing; one more than there are strips. The outer strips extend beyond the first and last
    /// border.
    pub(crate) breaks: &'a [f64],
    /// Lines per unit of parameter in each strip, not negative.
    pub(crate) rates: &'a [f64],
}

/// A strip with fewer lines than this inside a gap does not limit the gap: strips and breaks meet at the same knots,
/// except for rounding.
const HAIR: f64 = 1e-6;
/// By how much the last gap may be less full than the others, in gaps.
const SHORT: f64 = 1.0 / 32.0;
/// Number of scales of a density to try until the last gap is that full.
const TRIALS: usize = 6;

impl<'a> Density<'a> {
    /// The same density, of the strips between `a` and `b` alone.
    #[inline]
    fn within(&self, a: f64, b: f64) -> Self {
        let Self { breaks, rates } = *self;
        let n = rates.len();
        // Mostly all of them.
        let first = if a < breaks[1] { 0 } else { breaks.partition_point(|&x| x <= a).saturating_sub(1).min(n - 1) };
        let end = if b > breaks[n - 1] { n } else { breaks[..n].partition_point(|&x| x < b).max(first + 1) };
        Self { breaks: &breaks[first..=end], rates: &rates[first..end] }
    }

    /// The strips between `a` and `b`: the density of each, and its width there.
    fn strips(&self, a: f64, b: f64) -> impl Iterator<Item = (f64, f64)> {
        let Self { breaks, rates } = self.within(a, b);
        let last = rates.len() - 1;
        (0..).zip(rates).map(move |(k, &rate)| {
            let from = if k == 0 { a } else { breaks[k] };
            let to = if k == last { b } else { breaks[k + 1] };
            (rate, to - from)
        })
    }

    /// Integral of the density from `a` to `b`: a number of lines.
    pub(crate) fn mass(&self, a: f64, b: f64) -> f64 {
        self.strips(a, b).fold(0.0, |mass, (rate, width)| mass + rate * width)
    }

    /// The largest density of all strips.
    fn most(&self) -> f64 {
        self.rates.iter().fold(0.0, |most, &rate| larger(rate, most))
    }

    /// Counts the fewest gaps from `a` to `b` that meet the density times `scale`, up to `limit` + 1, and returns where
    /// the last of them begins. Calls `line` for the end of each gap before `b`. All strips must be between these.
    #[inline(always)]
    fn count(&self, a: f64, b: f64, scale: f64, limit: usize, mut line: impl FnMut(f64)) -> (usize, f64) {
        let mut strides = Strides::new(*self, a, scale);
        let mut x = a;
        for n in 0..limit {
            let from = x;
            x = strides.next(b);
            if x >= b {
                return (n + 1, from);
            }
            line(x);
        }
        (limit + 1, x)
    }

    /// As [`count`](Self::count), with how full the gaps are together: 1 for each but the last, which counts by its
    /// fullness. Beyond `limit`, the rest counts by its integral.
    #[inline(always)]
    fn filled(&self, a: f64, b: f64, scale: f64, limit: usize, line: impl FnMut(f64)) -> (usize, f64) {
        let (n, from) = self.count(a, b, scale, limit, line);
        let last = if n <= limit {
            (scale * self.within(from, b).most() * (b - from)).min(1.0)
        } else {
            scale * self.mass(from, b)
        };
        (n, (n - 1) as f64 + last)
    }

    /// The fewest gaps from `a` to `b` that meet the density, counted up to `limit`: as many as
    /// [`spread`](Self::spread) makes.
    pub(crate) fn fewest(&self, a: f64, b: f64, limit: usize) -> usize {
        let density = self.within(a, b);
        let most = density.most();
        let even = even_gaps(most, a, b).min(limit as f64) as usize;
        // Strides accumulate rounding and may be one more.
        if density.is_even(most, a, b) { even } else { density.count(a, b, 1.0, limit, |_| ()).0.min(even) }
    }

    /// The fewest gaps from `a` to `b` that meet the density, counted up to `limit`, and how full they are together: 1
    /// for each gap but the last, which counts by its fullness.
    pub(crate) fn fewest_and_full(&self, a: f64, b: f64, limit: usize) -> (usize, f64) {
        let density = self.within(a, b);
        let most = density.most();
        let even = even_gaps(most, a, b).min(limit as f64);
        let (n, full) = if density.is_even(most, a, b) {
            (even as usize, most * (b - a))
        } else {
            density.filled(a, b, 1.0, limit, |_| ())
        };
        // Strides accumulate rounding and may be one more.
        (n.min(even as usize), smaller(full, even))
    }

    /// Whether even gaps are the fewest, given the largest density `most`.
    fn is_even(&self, most: f64, a: f64, b: f64) -> bool {
        even_gaps(most, a, b) <= 2.0 || self.rates.iter().all(|&rate| rate >= 0.999 * most)
    }

    /// Appends parameters after `a` and up to `b > a`, strictly increasing and ending with `b`. They are the fewest
    /// such that no gap is longer than 1/ρ anywhere in it, spaced as evenly as that allows.
    ///
    /// If that takes more than `limit` gaps, the whole density is scaled down until it does not. Returns whether the
    /// density is met. Cost: a handful of passes over the gaps; at most one if they are even.
    pub(crate) fn spread(&self, a: f64, b: f64, limit: usize, out: &mut Vec<f64>) -> bool {
        let density = self.within(a, b);
        let most = density.most();
        let even = even_gaps(most, a, b);
        if density.is_even(most, a, b) {
            evenly(a, b, even.min(limit as f64) as usize, out);
            return even <= limit as f64;
        }
        let first = out.len();
        let lines_at =
            |scale: f64, limit: usize, out: &mut Vec<f64>| density.filled(a, b, scale, limit, |x| out.push(x));
        let (asked, mut filled) = lines_at(1.0, limit, out);
        let (n, kept) = (asked.min(limit), asked <= limit);
        let mass = density.mass(a, b);
        // Even gaps are as few, or the density is infinite.
        if kept && n as f64 >= even || !mass.is_finite() {
            out.truncate(first);
            // Strides accumulate rounding and may be one more.
            evenly(a, b, n.min(even as usize), out);
            return kept && n as f64 >= even;
        }
        // The largest scale that takes no more gaps makes the last gap as full as the others. A gap holds at most one
        // line of the density, and at most one gap per strip is not full: this bounds the scale from both sides.
        let (full, strips) = (n as f64, density.rates.len() as f64);
        let mut low = if kept { 1.0 } else { ((full - strips - 1.0) / mass).max(0.5 / (most * (b - a))) };
        let mut high = if kept { (full / mass).clamp(1.0, 2.0) } else { (full / mass).max(low) };
        let mut scale = 1.0;
        // Where the lines at `low` end, once they are known.
        let mut end = if kept { out.len() } else { first };
        for _ in 0..TRIALS {
            if scale == low && filled >= full - SHORT {
                break;
            }
            // Spreads the missing fullness over all gaps; exact if no strip border lies between.
            let next = scale + (full - 0.5 * SHORT - filled) / mass;
            scale = if low < next && next < high { next } else { 0.5 * (low + high) };
            out.truncate(end);
            let gaps;
            (gaps, filled) = lines_at(scale, n, out);
            if gaps <= n {
                out.drain(first..end);
                (low, end) = (scale, out.len());
            } else {
                high = scale;
            }
        }
        out.truncate(end);
        if end == first {
            lines_at(low, n - 1, out);
        }
        // A line a hair before the end is only rounding: the rest holds at most a millionth of a line.
        while let [.., x] = out[first..] {
            let before = if out.len() > first + 1 { out[out.len() - 2] } else { a };
            if b - x > 1e-6 * (x - before) || self.mass(x, b) > HAIR {
                break;
            }
            out.pop();
        }
        out.push(b);
        kept
    }
}

/// Number of even gaps that meet the largest density `most`.
fn even_gaps(most: f64, a: f64, b: f64) -> f64 {
    (most * (b - a) * (1.0 - 1e-12)).ceil().max(1.0)
}

/// Steps along a density, each as long as the largest density on the way, times `scale`, allows.
struct Strides<'a> {
    density: Density<'a>,
    scale: f64,
    x: f64,
    /// The strip of `x`, or one before it.
    at: usize,
    /// Where that strip ends, and the longest step that it allows.
    border: f64,
    step: f64,
}

impl<'a> Strides<'a> {
    /// From a place in the first strip.
    fn new(density: Density<'a>, from: f64, scale: f64) -> Self {
        let mut new = Self { density, scale, x: from, at: 0, border: 0.0, step: 0.0 };
        new.enter(0, new.step_in(0));
        new
    }

    /// Goes to a strip that allows this step.
    #[inline(always)]
    fn enter(&mut self, strip: usize, step: f64) {
        let Density { breaks, rates } = self.density;
        let border = if strip + 1 == rates.len() { f64::INFINITY } else { breaks[strip + 1] };
        (self.at, self.border, self.step) = (strip, border, step);
    }

    #[inline(always)]
    fn step_in(&self, strip: usize) -> f64 {
        (self.density.rates[strip] * self.scale).recip()
    }

    /// Moves to the furthest `x ≤ end` with `(x − before)·ρ ≤ 1` for the largest ρ on the way, but always past
    /// the last `x`.
    #[inline]
    fn next(&mut self, end: f64) -> f64 {
        let to = self.x + self.step;
        self.x = if to <= self.border && to > self.x { smaller(to, end) } else { self.over_borders(end) };
        self.x
    }

    fn over_borders(&mut self, end: f64) -> f64 {
        let (x, mut strip) = (self.x, self.at);
        let Density { breaks, rates } = self.density;
        // All strips but the last have a border where they end.
        let last = rates.len() - 1;
        while strip < last && breaks[strip + 1] <= x {
            strip += 1;
        }
        let mut step = self.step_in(strip);
        let mut to = smaller(if x + step > x { x + step } else { beyond(x, step) }, end);
        while strip < last && breaks[strip + 1] < to {
            strip += 1;
            step = self.step_in(strip);
            // A strip that is too dense to enter from here ends the gap at its border. Without a branch: processors
            // cannot guess which strips are denser than those before.
            to = smaller(larger(breaks[strip], x + step), to);
        }
        // Most of the next gaps end in the strip where this one ends.
        self.enter(strip, step);
        to
    }
}

/// The end of a step that is shorter than the spacing of floats at `x`: the next float, so every stride advances.
/// Infinity for NaN.
#[cold]
#[inline(never)]
fn beyond(x: f64, step: f64) -> f64 {
    if x + step == x { x.next_up() } else { f64::INFINITY }
}

/// Appends `n` even gaps, fewer where floats are not that fine.
fn evenly(a: f64, b: f64, n: usize, out: &mut Vec<f64>) {
    let (mut last, n) = (a, n as u32);
    for k in 1..n {
        let x = a + (b - a) * (f64::from(k) / f64::from(n));
        if x > last && x < b {
            out.push(x);
            last = x;
        }
    }
    out.push(b);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::judge;
    use arbitrary::Unstructured;

    const LIMIT: usize = 4096;

    fn spread(breaks: &[f64], rates: &[f64], a: f64, b: f64, limit: usize) -> (Vec<f64>, bool) {
        let mut lines = vec![a];
        let density = Density { breaks, rates };
        let kept = density.spread(a, b, limit, &mut lines);
        assert!(lines.is_sorted_by(|x, y| x < y), "{breaks:?} {rates:?} {a} {b}: {lines:?}");
        assert!(lines[lines.len() - 1] == b && lines.len() - 1 <= limit, "{breaks:?} {rates:?}: {}", lines.len());
        (lines, kept)
    }

    /// Length of a gap as a multiple of the longest that its largest density allows, at most 1 if it meets the density:
    /// the largest of any gap.
    fn fullest(breaks: &[f64], rates: &[f64], lines: &[f64]) -> f64 {
        let density = Density { breaks, rates };
        let fullness = |gap: &[f64]| {
            let touched = density.strips(gap[0], gap[1]).filter(|(rate, width)| rate * width > HAIR);
            touched.fold(0.0, |most, (rate, _)| larger(rate, most)) * (gap[1] - gap[0])
        };
        lines.windows(2).map(fullness).fold(0.0, f64::max)
    }

    #[test]
    fn a_density_over_the_limit_is_scaled_down_as_a_whole() {
        let (breaks, rates) = ([0.0, 0.5, 1.0], [1e7, 1e6]);
        let (lines, kept) = spread(&breaks, &rates, 0.0, 1.0, LIMIT);
        assert!(!kept && lines.len() > LIMIT - 4);
        // The halves keep their ratio of ten to one.
        let left = lines.partition_point(|&x| x < 0.5) as f64;
        assert!((left / (lines.len() as f64 - left) - 10.0).abs() < 0.2, "{left} of {}", lines.len());
        let fair = 5.5e6 / LIMIT as f64;
        assert!(fullest(&breaks, &rates, &lines) < 1.01 * fair);
        // Even, infinite and huge densities.
        assert_eq!(spread(&[0.0, 1.0], &[1e9], 0.0, 1.0, LIMIT).0.len(), LIMIT + 1);
        assert!(!spread(&[0.0, 0.5, 1.0], &[f64::INFINITY, 1.0], 0.0, 1.0, LIMIT).1);
        assert!(!spread(&[0.0, 0.5, 1.0], &[1e300, 1.0], 0.0, 1.0, LIMIT).1);
    }

    #[test]
    fn no_lines_are_spent_where_the_density_is_zero() {
        let breaks = [0.0, 1.0, 2.0, 3.0];
        assert_eq!(spread(&breaks, &[0.0; 3], 0.0, 3.0, LIMIT), (vec![0.0, 3.0], true));
        let (lines, kept) = spread(&breaks, &[0.0, 10.0, 0.0], 0.0, 3.0, LIMIT);
        assert!(kept && lines.len() <= 13 && fullest(&breaks, &[0.0, 10.0, 0.0], &lines) <= 1.0 + 1e-9, "{lines:?}");
    }

    #[test]
    fn a_denser_strip_is_entered_at_its_border_only() {
        // The sparse strip allows a step of 2 from 0, the dense one, which begins at 1, only 0.1.
        let (lines, _) = spread(&[0.0, 1.0, 2.0], &[0.5, 10.0], 0.0, 2.0, LIMIT);
        assert!(lines[1] <= 1.0 && lines.len() == 12, "{lines:?}");
    }

    #[test]
    fn rounding_does_not_add_an_even_gap() {
        // Ten tenths add up to less than 1.
        assert_eq!(spread(&[0.0, 0.1, 1.0], &[0.1, 10.0], 0.0, 1.0, LIMIT).0.len(), 11);
    }

    #[test]
    fn steps_below_the_spacing_of_floats_terminate() {
        let next = 1.0_f64.next_up();
        let (lines, kept) = spread(&[1.0, next, 2.0], &[1e300, 3.0], 1.0, 2.0, LIMIT);
        assert!(kept && (5..=6).contains(&lines.len()), "{lines:?}");
        assert_eq!(spread(&[1.0, 2.0], &[1e300], 1.0, next, LIMIT).0, [1.0, next]);
    }

    #[test]
    fn any_density_is_met_or_reported() {
        let property = |u: &mut Unstructured<'_>| -> arbitrary::Result<()> {
            let strips = u.int_in_range(1..=6_usize)?;
            let mut breaks = vec![f64::from(u.int_in_range(-1000..=1000_i32)?)];
            let mut rates = Vec::new();
            for k in 0..strips {
                breaks.push(breaks[k] + 10.0_f64.powi(u.int_in_range(-9..=3)?) * f64::from(u.int_in_range(1..=9_u8)?));
                let size = 10.0_f64.powi(u.int_in_range(-3..=8)?);
                rates.push(size * f64::from(u.int_in_range(0..=9_u8)?));
            }
            let (first, last) = (breaks[0], breaks[strips]);
            let share = |u: &mut Unstructured<'_>| Ok(f64::from(u.int_in_range(0..=100_u8)?) / 100.0);
            let (s, t) = (share(u)?, share(u)?);
            let (a, b) = (first + (last - first) * f64::min(s, t), first + (last - first) * f64::max(s, t));
            if a >= b {
                return Ok(());
            }
            let limit = u.int_in_range(8..=200_usize)?;
            let (lines, kept) = spread(&breaks, &rates, a, b, limit);
            let full = fullest(&breaks, &rates, &lines);
            let mass = Density { breaks: &breaks, rates: &rates }.mass(a, b);
            // Gaps are no shorter than the spacing of floats, and their ends are rounded: this bounds the excess, in
            // lines.
            let ulp = f64::EPSILON * f64::max(first.abs(), last.abs());
            let rounding = 2.0 * HAIR + 4.0 * ulp * rates.iter().copied().fold(0.0, f64::max);
            assert!(!kept || full <= 1.0 + rounding, "{breaks:?} {rates:?} {a} {b} {limit}: {full}");
            assert!(!kept || (lines.len() - 1) as f64 <= mass + 2.0 * strips as f64, "{breaks:?} {rates:?}: {lines:?}");
            assert!(kept || mass + strips as f64 >= limit as f64 * (1.0 - 1e-9), "{breaks:?} {rates:?}: {mass}");
            Ok(())
        };
        judge!(10_000, 256, |bytes: &[u8]| property(&mut Unstructured::new(bytes)).is_ok());
    }
}
