//! What each worker spent on a frame: counts and nanoseconds, taken without shared state.

use std::time::{Duration, Instant};

/// One worker's share of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WorkerMetrics {
    /// The worker's number, from 0.
    pub worker: u32,
    /// Tiles that it made.
    pub tiles: u32,
    /// Triangles in them.
    pub triangles: u64,
    /// Time spent on tiles.
    pub tiles_time: Duration,
    /// Time spent on edge polylines.
    pub lines_time: Duration,
}

impl WorkerMetrics {
    /// Time spent working; the rest of the frame the worker waited.
    #[must_use]
    pub fn busy(&self) -> Duration {
        self.tiles_time + self.lines_time
    }
}

/// Mean over largest busy time: 1 when every worker was busy all the time, 1/W when one did everything.
/// 1 when nobody did anything.
#[must_use]
pub fn balance(workers: &[WorkerMetrics]) -> f64 {
    let busy = workers.iter().map(|w| w.busy().as_secs_f64());
    let (sum, largest) = busy.fold((0.0, 0.0_f64), |(sum, largest), t| (sum + t, largest.max(t)));
    #[allow(clippy::cast_precision_loss, reason = "a worker count")]
    let count = workers.len() as f64;
    if largest > 0.0 { sum / (count * largest) } else { 1.0 }
}

/// Cuts running time into consecutive laps, so that the laps sum to the whole.
pub(super) struct Laps(Instant);

impl Laps {
    /// The first lap starts.
    pub(super) fn start() -> Self {
        Self(Instant::now())
    }

    /// Ends a lap and starts the next.
    pub(super) fn lap(&mut self) -> Duration {
        let now = Instant::now();
        let lap = now - self.0;
        self.0 = now;
        lap
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balance_is_mean_over_largest() {
        let busy = |ms| WorkerMetrics { tiles_time: Duration::from_millis(ms), ..WorkerMetrics::default() };
        assert!((balance(&[busy(10), busy(10)]) - 1.0).abs() < 1e-12);
        assert!((balance(&[busy(40), busy(0), busy(0), busy(0)]) - 0.25).abs() < 1e-12);
        assert!((balance(&[busy(0)]) - 1.0).abs() < 1e-12);
    }
}
