//! Running time -> seconds of consecutive stages.

use std::time::Instant;

/// A stopwatch whose laps sum to the total.
pub(crate) struct Laps {
    start: Instant,
    last: Instant,
}

impl Laps {
    pub(crate) fn start() -> Self {
        let now = Instant::now();
        Self { start: now, last: now }
    }

    /// Ends a lap and returns its seconds.
    pub(crate) fn lap(&mut self) -> f64 {
        let now = Instant::now();
        let lap = now - self.last;
        self.last = now;
        lap.as_secs_f64()
    }

    /// Seconds from the start to the end of the last lap: the sum of all laps.
    pub(crate) fn total(&self) -> f64 {
        (self.last - self.start).as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laps_sum_to_the_total() {
        let mut laps = Laps::start();
        let sum: f64 = (0..50).map(|_| laps.lap()).sum();
        assert!((sum - laps.total()).abs() < 1e-9);
    }
}
