//! Counts and times of each worker in a frame, measured without shared state.

#[cfg(feature = "cpu-time")]
use cpu_time::ThreadTime;
use std::time::Duration;
#[cfg(not(target_arch = "wasm32"))]
use std::time::Instant;
#[cfg(target_arch = "wasm32")]
use web_time::Instant;

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
    /// Time spent on tiles.
    pub tiles_time: Duration,
    /// Time spent on edge polylines.
    pub lines_time: Duration,
    /// Processor time of the worker's thread for this frame: [`busy`](Self::busy) without interference by other
    /// processes. Zero without the feature `cpu-time`, and where the system has no such clock.
    pub cpu: Duration,
}

impl WorkerMetrics {
    /// Time spent working.
    #[must_use]
    pub fn busy(&self) -> Duration {
        self.tiles_time + self.lines_time
    }
}

/// Load balance of `count` workers: mean over largest processor time. 1 if all did the same, 1/W if one did everything.
/// With several workers per thread, threads are more evenly loaded than workers.
///
/// Workers that are missing from `workers`, as idle ones in frames of views, count as idle. Other processes on the
/// machine do not affect the result. `None` if no processor time was measured, as without the feature `cpu-time`.
#[must_use]
pub fn balance(workers: &[WorkerMetrics], count: usize) -> Option<f64> {
    let busy = workers.iter().map(|w| w.cpu.as_secs_f64());
    let (sum, largest) = busy.fold((0.0, 0.0_f64), |(sum, largest), t| (sum + t, largest.max(t)));
    #[allow(clippy::cast_precision_loss, reason = "a worker count")]
    let count = count.max(workers.len()) as f64;
    (largest > 0.0).then(|| sum / (count * largest))
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

/// Memory of a [`Session`](super::Session) by kind, bytes, estimated from counts; besides its prepared model, which
/// others may share ([`Prepared::memory`](crate::prepare::Prepared::memory)), and what its sink has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct SessionMemory {
    /// Levels and plans of frames of views; 0 before the first.
    pub plans: u64,
    /// Instances, which tiles the sink has, and what [`plan_for_view`](super::Session::plan_for_view) reads of the
    /// model, from its first call on.
    pub scene: u64,
}

impl SessionMemory {
    /// The sum.
    #[must_use]
    pub const fn total(&self) -> u64 {
        let Self { plans, scene } = *self;
        plans + scene
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balance_is_mean_over_largest() {
        let busy = |ms| WorkerMetrics { cpu: Duration::from_millis(ms), ..WorkerMetrics::default() };
        assert_eq!(balance(&[busy(10), busy(10)], 2), Some(1.0));
        assert_eq!(balance(&[busy(40), busy(0), busy(0), busy(0)], 4), Some(0.25));
    }

    #[test]
    fn workers_without_metrics_count_as_idle() {
        let busy = WorkerMetrics { cpu: Duration::from_millis(40), ..WorkerMetrics::default() };
        assert_eq!(balance(&[busy], 4), Some(0.25));
    }

    #[test]
    fn there_is_no_balance_without_processor_time() {
        assert_eq!(balance(&[WorkerMetrics::default()], 1), None);
    }
}
