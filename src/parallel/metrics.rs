//! What each worker spent on a frame: counts and nanoseconds, taken without shared state.

#[cfg(feature = "cpu-time")]
use cpu_time::ThreadTime;
use std::time::{Duration, Instant};

/// One worker's share of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct WorkerMetrics {
    /// The worker's number, from 0.
    pub worker: u32,
    /// Tiles that it made.
    pub tiles: u32,
    /// Triangles in them.
    pub triangles: u64,
    /// Bytes that it keeps of its tiles, to patch them up with.
    pub kept: u64,
    /// Time spent on tiles.
    pub tiles_time: Duration,
    /// Time spent on edge polylines.
    pub lines_time: Duration,
    /// Processor time of its thread, from the order to the delivery: what [`busy`](Self::busy) would be on a machine that does
    /// nothing else. Zero without the feature `cpu-time`, and where the system does not tell.
    pub cpu: Duration,
}

impl WorkerMetrics {
    /// Time spent working; the rest of the frame the worker waited.
    #[must_use]
    pub fn busy(&self) -> Duration {
        self.tiles_time + self.lines_time
    }
}

/// Mean over largest processor time: 1 when every worker had as much to do as any other, 1/W when one did everything.
/// 1 when nobody did anything. Other processes on the machine do not show in it.
#[must_use]
pub fn balance(workers: &[WorkerMetrics]) -> f64 {
    let busy = workers.iter().map(|w| w.cpu.as_secs_f64());
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

/// Processor time of the thread that asks, since it was started.
#[cfg(feature = "cpu-time")]
pub(super) struct Processor(Option<ThreadTime>);

#[cfg(feature = "cpu-time")]
impl Processor {
    /// From now on.
    pub(super) fn start() -> Self {
        Self(ThreadTime::try_now().ok())
    }

    /// What this thread has used; zero where the system does not tell.
    pub(super) fn used(&self) -> Duration {
        let used = self.0.and_then(|start| Some(ThreadTime::try_now().ok()?.duration_since(start)));
        used.unwrap_or_default()
    }
}

/// Nobody tells.
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
