//! Running time -> seconds of consecutive stages that sum to the whole.

use std::time::Instant;

/// Running time in consecutive laps, so that the stages sum to the whole.
pub(crate) struct Laps {
    start: Instant,
    last: Instant,
}

impl Laps {
    pub(crate) fn start() -> Self {
        let now = Instant::now();
        Self { start: now, last: now }
    }

    /// Seconds since the last lap, or the start.
    pub(crate) fn lap(&mut self) -> f64 {
        let now = Instant::now();
        let lap = now - self.last;
        self.last = now;
        lap.as_secs_f64()
    }

    /// Seconds from the start to the last lap: the sum of all laps.
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
