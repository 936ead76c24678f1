//! Many ratios -> maximum and percentiles in constant memory, by a logarithmic histogram.

use std::fmt;

/// Ratios up to this one share the first bin.
const LEAST: f64 = 1e-6;
/// Bins per factor e. Percentiles are at most 1 % too high.
const BINS_PER_E: f64 = 100.0;
/// Bins up to a ratio of about 1e6. Larger ones share the last.
const BINS: usize = 2764;

/// Distribution of ratios of deviation to tolerance. All zero without samples. Percentiles are up to 1 % too high, and at
/// most about 1e6.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Number of samples.
    pub samples: u64,
    /// Number of samples above 1.
    pub over: u64,
    /// Median.
    pub median: f64,
    /// 99th percentile.
    pub p99: f64,
    /// 99.9th percentile.
    pub p999: f64,
    /// Maximum. Infinite if a position is not finite.
    pub worst: f64,
}

impl fmt::Display for Spread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { samples, over, median, p99, p999, worst } = self;
        write!(f, "{samples:>10} {over:>8} {median:>8.4} {p99:>8.4} {p999:>8.4} {worst:>8.4}")
    }
}

/// A histogram of ratios.
#[derive(Clone, Debug)]
pub(super) struct Tally {
    bins: Vec<u64>,
    over: u64,
    worst: f64,
}

impl Default for Tally {
    fn default() -> Self {
        Self { bins: vec![0; BINS], over: 0, worst: 0.0 }
    }
}

impl Tally {
    /// Adds a ratio. NaN counts as infinite.
    pub(super) fn add(&mut self, ratio: f64) {
        let ratio = if ratio.is_nan() { f64::INFINITY } else { ratio };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the bins")]
        let bin = ((ratio / LEAST).ln() * BINS_PER_E).ceil().clamp(0.0, (BINS - 1) as f64) as usize;
        self.bins[bin] += 1;
        self.over += u64::from(ratio > 1.0);
        self.worst = self.worst.max(ratio);
    }

    /// Adds another tally.
    pub(super) fn join(&mut self, other: &Self) {
        self.bins.iter_mut().zip(&other.bins).for_each(|(mine, theirs)| *mine += theirs);
        self.over += other.over;
        self.worst = self.worst.max(other.worst);
    }

    /// The distribution so far.
    pub(super) fn spread(&self) -> Spread {
        let samples: u64 = self.bins.iter().sum();
        let percentile = |share: f64| {
            let mut left = samples as f64 * share;
            let bin = self.bins.iter().position(|&count| {
                left -= count as f64;
                left <= 0.0
            });
            bin.map_or(self.worst, |bin| (LEAST * (bin as f64 / BINS_PER_E).exp()).min(self.worst))
        };
        let (median, p99, p999) = (percentile(0.5), percentile(0.99), percentile(0.999));
        Spread { samples, over: self.over, median, p99, p999, worst: self.worst }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_at_most_one_percent_too_high() {
        let mut tally = Tally::default();
        (1..=10_000).for_each(|k| tally.add(f64::from(k) * 2e-4));
        let spread = tally.spread();
        assert_eq!((spread.samples, spread.over), (10_000, 5_000));
        for (got, exact) in [(spread.median, 1.0), (spread.p99, 1.98), (spread.p999, 1.998), (spread.worst, 2.0)] {
            assert!(got >= exact * (1.0 - 1e-12) && got <= 1.01 * exact + 1e-12, "{got} for {exact}");
        }
    }

    #[test]
    fn empty_tallies_are_zero_and_nan_is_infinite() {
        assert_eq!(Tally::default().spread(), Spread::default());
        let mut tally = Tally::default();
        tally.add(f64::NAN);
        tally.add(0.0);
        assert_eq!((tally.spread().worst, tally.spread().over, tally.spread().median), (f64::INFINITY, 1, LEAST));
    }
}
