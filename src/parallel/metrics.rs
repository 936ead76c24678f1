//! Counts and times of each worker in a frame, measured without shared state.

#[cfg(feature = "cpu-time")]
use cpu_time::ThreadTime;
use std::time::{Duration, Instant};

/// One worker's counts and times of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct WorkerMetrics {
    /// The worker's index.
    pub worker: u32,
    /// Tiles made.
    pub tiles: u32,
    /// Triangles in these tiles.
    pub triangles: u64,
    /// Size of the worker's tile caches, bytes.
    pub kept: u64,
    /// Time spent on tiles.
    pub tiles_time: Duration,
    /// Time spent on edge polylines.
    pub lines_time: Duration,
    /// Processor time of the worker's thread for this frame: [`busy`](Self::busy) without interference by other
    /// processes. Zero without the feature `cpu-time`, and where the system has no such clock.
    pub cpu: Duration,
}

impl WorkerMetrics {
    /// Time spent working. For the rest of the frame the worker waited.
    #[must_use]
    pub fn busy(&self) -> Duration {
        self.tiles_time + self.lines_time
    }
}

/// Load balance: mean over largest processor time. 1 if all workers did the same, 1/W if one did everything.
///
/// Other processes on the machine do not affect it. 1 if no processor time was measured, as without the feature
/// `cpu-time`. Workers that are missing from the list, as idle ones in frames of views, do not count.
#[must_use]
pub fn balance(workers: &[WorkerMetrics]) -> f64 {
    let busy = workers.iter().map(|w| w.cpu.as_secs_f64());
    let (sum, largest) = busy.fold((0.0, 0.0_f64), |(sum, largest), t| (sum + t, largest.max(t)));
    #[allow(clippy::cast_precision_loss, reason = "a worker count")]
    let count = workers.len() as f64;
    if largest > 0.0 { sum / (count * largest) } else { 1.0 }
}

/// A stopwatch whose consecutive laps sum to the whole time.
pub(super) struct Laps(Instant);

impl Laps {
    /// Starts the first lap.
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

/// A clock of the calling thread's processor time.
#[cfg(feature = "cpu-time")]
pub(super) struct Processor(Option<ThreadTime>);

#[cfg(feature = "cpu-time")]
impl Processor {
    pub(super) fn start() -> Self {
        Self(ThreadTime::try_now().ok())
    }

    /// Processor time since `start`; zero where the system has no such clock.
    pub(super) fn used(&self) -> Duration {
        let used = self.0.and_then(|start| Some(ThreadTime::try_now().ok()?.duration_since(start)));
        used.unwrap_or_default()
    }
}

/// Always zero.
#[cfg(not(feature = "cpu-time"))]
pub(super) struct Processor;

#[cfg(not(feature = "cpu-time"))]
impl Processor {
    pub(super) fn start() -> Self {
        Self
    }

    #[allow(clippy::unused_self, reason = "as with the feature")]
    pub(super) fn used(&self) -> Duration {
        Duration::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balance_is_mean_over_largest() {
        let busy = |ms| WorkerMetrics { cpu: Duration::from_millis(ms), ..WorkerMetrics::default() };
        assert!((balance(&[busy(10), busy(10)]) - 1.0).abs() < 1e-12);
        assert!((balance(&[busy(40), busy(0), busy(0), busy(0)]) - 0.25).abs() < 1e-12);
        assert!((balance(&[busy(0)]) - 1.0).abs() < 1e-12);
    }
}
