//! Options and reports of sessions.

use crate::border::{Caller, versioned};
use crate::limits::{plan_limits, positive};
use crate::status::Failure;
use crate::threads::at_most;
use std::time::Duration;
use trimtess::frame::{PlannerOptions, Shortfall};
use trimtess::parallel::{FrameReport, SessionOptions};

/// Options of a session. Zeros are the defaults.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_session_options {
    /// `sizeof(tt_session_options)`.
    pub size: u32,
    /// Number of workers, which own the tiles, at most 4096; 0 = four per thread, or one if there is one thread.
    pub workers: u32,
    /// 1 starts no thread: all work is done by the calls of the session.
    pub no_threads: u32,
    /// 1 sends the polylines of edges, too.
    pub edge_lines: u32,
    /// Levels of detail that a part with several instances may have at most; 0 = 4.
    pub levels: u32,
    /// Deals tiles to workers again every so many frames of views, by measured times; 0 = never.
    pub rebalance_every: u32,
    /// 1 leaves out tiles of closed parts that face away from all cameras. Right as long as no camera is within a part,
    /// and the near plane clips none.
    pub cull_back_faces: u32,
    /// Number of threads that make a frame, at most 1024; 0 = one per core, see "Threads" at the head of this file. The
    /// caller is one of them while it waits for the frame, so the session starts one less, but at least one. A caller
    /// who only polls (`tt_session_finish_within`) does no work, and asks for one more. Must be 0 with jobs, and with
    /// `no_threads`.
    pub threads: u32,
    /// Time that the tiles of a frame of views may take, seconds of one worker, as predicted. Changes beyond it wait
    /// for the next frame. 0 = any.
    pub budget: f64,
    /// Triangles of a frame at most, as counted before they are made: two per lattice cell and two per point of an
    /// edge, each part once; frames have about half as many. 0 = 64 million. Frames of views are coarser beyond this
    /// and the next two limits, see `tt_report.coarsened`.
    pub max_triangles: u64,
    /// Triangles of one tile at most; 0 = 8 million.
    pub max_tile_triangles: u64,
    /// Memory of a frame at most, bytes, estimated; 0 = 16 GiB.
    pub max_memory: u64,
    /// Bytes of tiles that the sink may hold; 0 = any. Beyond it, tiles that no view draws are evicted, the oldest
    /// first, in steps of 64 frames. Tiles of a frame count from the next one on.
    pub resident_bytes: u64,
}
versioned!(tt_session_options);

/// What a session has.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_session_info {
    /// `sizeof(tt_session_info)`.
    pub size: u32,
    /// Number of workers.
    pub workers: u32,
    /// Number of parts and further levels of detail.
    pub parts: u32,
    /// Number of instances.
    pub instances: u32,
    /// 1 if `tt_session_finish` would return without waiting: the frame is made, or none was begun.
    pub is_made: u32,
    /// Tiles that are not as they should be, of those that the sink of frames of views has.
    pub degraded: u32,
}
versioned!(tt_session_info);

/// What a frame took.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_report {
    /// `sizeof(tt_report)`.
    pub size: u32,
    /// 1 if the sink got a whole frame rather than changes.
    pub whole: u32,
    /// Number of the frame within its session, from 0. A frame in which nothing changed has the number of the next one
    /// in which something does.
    pub frame: u64,
    /// Tiles made.
    pub tiles: u64,
    /// Tiles with triangles that were sent.
    pub sent: u64,
    /// Triangles of these.
    pub triangles: u64,
    /// Tiles evicted from the sink that no view draws.
    pub evicted: u64,
    /// Tiles whose change waits for the next frame, because the budget was spent.
    pub deferred: u64,
    /// Tiles that are not as they should be.
    pub degraded: u64,
    /// Seconds to make the plan; 0 for frames by a tolerance.
    pub planned_in: f64,
    /// Seconds from the order to the last tile.
    pub made_in: f64,
    /// Seconds from the last tile to the end of the sink's calls.
    pub committed_in: f64,
    /// 1 if limits made the frame coarser than its views or its tolerance ask, also where nothing changed; else 0.
    pub coarsened: u32,
    /// 0.
    pub reserved: u32,
    /// Triangles that it needs at most to be as fine, if limits on all of its triangles or on memory made it coarser;
    /// else 0.
    pub needed: u64,
}
versioned!(tt_report);

/// The options, and whether to start no thread.
pub(crate) fn options(c: &Caller, from: *const tt_session_options) -> Result<(SessionOptions, bool), Failure> {
    let from = c.read_or_zeros("options", from)?;
    let planner = PlannerOptions::DEFAULT
        .with_cull_back_faces(from.cull_back_faces != 0)
        .with_limits(plan_limits(from.max_triangles, from.max_tile_triangles, from.max_memory))
        .with_budget(positive("options.budget", from.budget)?.map(duration));
    let options = SessionOptions::DEFAULT
        .with_threads(at_most(from.threads)?)
        .with_workers(workers(from.workers)?)
        .with_edge_lines(from.edge_lines != 0)
        .with_levels(if from.levels == 0 { SessionOptions::DEFAULT.levels } else { from.levels as usize })
        .with_rebalance_every(from.rebalance_every)
        .with_resident_bytes((from.resident_bytes > 0).then_some(from.resident_bytes))
        .with_planner(planner);
    Ok((options, from.no_threads != 0))
}

/// A number of workers that is not absurd.
fn workers(count: u32) -> Result<usize, Failure> {
    const MOST: usize = SessionOptions::MOST_WORKERS;
    match count as usize {
        count if count > MOST => Err(Failure::argument(format!("options.workers is {count}; there may be {MOST}"))),
        count => Ok(count),
    }
}

/// Seconds, 0 or more, as a duration of at most 30 years.
pub(crate) fn duration(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds.min(1e9))
}

/// The report of a frame, and what limits made coarser in it.
pub(crate) fn report(made: &FrameReport, short: Option<&Shortfall>) -> tt_report {
    let short = short.filter(|short| short.by_limits());
    tt_report {
        size: 0,
        whole: made.whole.into(),
        frame: made.frame,
        tiles: made.tiles as u64,
        sent: made.batches as u64,
        triangles: made.triangles,
        evicted: made.evicted as u64,
        deferred: made.deferred.into(),
        degraded: made.degraded.len() as u64,
        planned_in: made.planned_in.as_secs_f64(),
        made_in: made.made_in.as_secs_f64(),
        committed_in: made.committed_in.as_secs_f64(),
        coarsened: short.is_some().into(),
        reserved: 0,
        needed: short.map_or(0, |short| short.needed),
    }
}
