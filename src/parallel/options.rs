//! What a session may be told.

use crate::frame::PlannerOptions;
use std::num::NonZeroU32;

/// Options of a [`Session`](super::Session).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SessionOptions {
    /// Number of threads that [`Session::start`](super::Session::start) starts; 0 = one per core, see
    /// [`Threads::start`](crate::control::Threads::start).
    /// [`Session::start_on`](super::Session::start_on) starts none.
    pub threads: usize,
    /// Number of workers of a session, which own the tiles; more than [`MOST_WORKERS`](Self::MOST_WORKERS) count as that
    /// many. Workers in excess of the tiles stay idle.
    ///
    /// 0 = one on a pool of one thread, else four per thread: a thread whose tiles cost less than expected then takes
    /// another worker.
    pub workers: usize,
    /// Whether sinks get the polylines of B-rep edges too. Frames of views have those of parts that a view has shown.
    /// On by default; off in sessions of C and Python.
    pub edge_lines: bool,
    /// Options of the planner, for frames of views.
    pub planner: PlannerOptions,
    /// Maximum number of LODs per instanced part in frames of views. 0 is treated as 1.
    pub levels: usize,
    /// Bytes of tiles that a sink of frames of views may hold, as they were sent; `None` = no limit.
    ///
    /// Beyond it, each frame evicts tiles that no view draws, in the order of parts: first those that were drawn neither
    /// in the current 64 frames nor in the 64 before, then those drawn in the 64 before, then the others. Tiles that are
    /// drawn stay. A frame does not count the tiles that it sends itself.
    pub resident_bytes: Option<u64>,
    /// Rebalance tiles between workers every N frames of views, using measured tile times. `None` disables rebalancing.
    pub rebalance_every: Option<NonZeroU32>,
}

impl SessionOptions {
    /// The most workers of a session.
    pub const MOST_WORKERS: usize = 1 << 12;

    /// One thread per core, four workers per thread, edge lines, up to 4 LODs per part, no rebalancing.
    pub const DEFAULT: Self = Self {
        threads: 0,
        workers: 0,
        edge_lines: true,
        planner: PlannerOptions::DEFAULT,
        levels: 4,
        resident_bytes: None,
        rebalance_every: None,
    };

    /// Sets [`rebalance_every`](Self::rebalance_every); 0 `frames` disable it.
    #[must_use]
    pub const fn with_rebalance_every(self, frames: u32) -> Self {
        Self { rebalance_every: NonZeroU32::new(frames), ..self }
    }
}

options! {
    SessionOptions:
    with_threads(threads: usize);
    with_workers(workers: usize);
    with_edge_lines(edge_lines: bool);
    with_levels(levels: usize);
    with_resident_bytes(resident_bytes: Option<u64>);
    with_planner(planner: PlannerOptions);
}
