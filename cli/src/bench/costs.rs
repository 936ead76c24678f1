//! Views of a path -> the cost of each tile on one thread, and the cost of handing frames to workers.

use super::flight::ms;
use super::uploads::Uploads;
use crate::{Common, Failure};
use cpu_time::ThreadTime;
use std::sync::Arc;
use std::time::Instant;
use trimtess::frame::internals::{Scratch, tessellate_tile};
use trimtess::frame::{Plan, plan_for_view_within};
use trimtess::mesh::{MemorySink, MeshLists};
use trimtess::model::{PartId, TileId};
use trimtess::parallel::internals::{Load, loads};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::Prepared;
use trimtess::view::View;

/// Maximum number of frames in which tiles are timed, spread over the path.
const SAMPLED: usize = 30;
/// How often each tile is made. Its cost is the minimum, to exclude interference by other processes.
const TIMES: usize = 3;

/// Measured costs of tiles.
pub(super) struct Costs {
    /// Expected costs and positions of the tiles.
    pub(super) tiles: Vec<Load>,
    /// Frames of the path per row of `frames`.
    pub(super) stride: usize,
    /// Milliseconds per timed frame and tile; 0 for tiles that were not made.
    pub(super) frames: Vec<Vec<f64>>,
}

/// Times all tiles, made from scratch, in some frames of a path. Runs outside of sessions.
pub(super) fn record(prepared: &Prepared, views: &[View], common: &Common) -> Result<Costs, Failure> {
    let stride = views.len().div_ceil(SAMPLED).max(1);
    let mut scratch = Scratch::default();
    let mut frames = Vec::with_capacity(SAMPLED);
    let all: Vec<(PartId, TileId)> = prepared.tiles().map(|(part, tile, _)| (part, tile)).collect();
    for view in views.iter().step_by(stride) {
        let plan = plan_for_view_within(prepared, view, &common.limits.plan());
        common.limits.check(plan.shortfall.as_ref())?;
        frames.push(tiles(prepared, &plan, &all, &mut scratch));
    }
    Ok(Costs { tiles: loads(prepared), stride, frames })
}

/// Times the tiles that a coherent session makes in each frame of a path except the first.
pub(super) fn record_changes(prepared: &Arc<Prepared>, views: &[View], common: &Common) -> Result<Costs, Failure> {
    let options = common.limits.session().with_threads(1).with_edge_lines(false);
    let mut session = Session::start(Arc::clone(prepared), &options).map_err(Failure::cannot)?;
    let rows = Arc::clone(session.prepared());
    let mut sink = Uploads::of(&rows);
    let mut scratch = Scratch::default();
    let mut frames = Vec::with_capacity(views.len());
    for view in views {
        sink.next_frame();
        session.view(&[*view], &mut sink).map_err(Failure::cannot)?;
        let mut costs = vec![0.0; sink.tiles()];
        if let Some(plan) = session.plan() {
            let times = tiles(&rows, &plan, &sink.sent, &mut scratch);
            for (&(part, tile), time) in sink.sent.iter().zip(times) {
                costs[sink.tile(part, tile)] = time;
            }
        }
        frames.push(costs);
    }
    frames.remove(0);
    Ok(Costs { tiles: loads(&rows), stride: 1, frames })
}

/// Times the tiles in `which`, milliseconds: the least of [`TIMES`] times each.
pub(super) fn tiles(prepared: &Prepared, plan: &Plan, which: &[(PartId, TileId)], scratch: &mut Scratch) -> Vec<f64> {
    let mut costs = vec![f64::INFINITY; which.len()];
    for _ in 0..TIMES {
        for (&(part, tile), cost) in which.iter().zip(&mut costs) {
            let (outcome, time) = timed(|| tessellate_tile(prepared, plan, (part, tile), MeshLists::NONE, scratch));
            *cost = cost.min(time);
            scratch.reuse(std::hint::black_box(outcome).mesh);
        }
    }
    costs
}

/// Runs `work`; returns its result and milliseconds.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let (begun, used) = (Instant::now(), ThreadTime::try_now());
    let done = work();
    // The minimum of both clocks: reading processor time takes time itself, and wall time includes other processes.
    let elapsed = begun.elapsed();
    let used = used.ok().and_then(|used| Some(ThreadTime::try_now().ok()?.duration_since(used)));
    (done, ms(used.map_or(elapsed, |used| used.min(elapsed))))
}

/// Milliseconds from an order to the last delivery of an empty frame: the median of 101 frames.
pub(super) fn hand_off(threads: usize) -> Result<f64, Failure> {
    const FRAMES: usize = 101;
    let options = SessionOptions::DEFAULT.with_threads(threads).with_edge_lines(false);
    let mut session = Session::start(Arc::new(Prepared::default()), &options).map_err(Failure::cannot)?;
    let (plan, mut sink) = (Arc::new(Plan::default()), MemorySink::default());
    let mut times = Vec::with_capacity(FRAMES);
    for _ in 0..FRAMES {
        let report = session.frame(Arc::clone(&plan), &mut sink).map_err(Failure::cannot)?;
        times.push(ms(report.made_in));
    }
    times.sort_by(f64::total_cmp);
    Ok(times[FRAMES / 2])
}
