//! A path's views -> what each tile costs in some of its frames, one thread, tile by tile; and what handing frames over costs.

use super::flight::ms;
use crate::{Common, Failure};
use std::sync::Arc;
use std::time::Instant;
use trimtess::frame::{Plan, Scratch, View, plan_for_view_within, tessellate_tile};
use trimtess::mesh::MemorySink;
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::Prepared;

/// Frames in which tiles are timed: they are spread over the path.
const SAMPLED: usize = 30;
/// How often each tile is made; its cost is the least, so that what else the machine does is left out.
const TIMES: usize = 3;

/// What tiles cost.
pub(super) struct Costs {
    /// How many frames of the path are from one row to the next.
    pub(super) stride: usize,
    /// Milliseconds: a row for each frame that was timed, and in it each tile, in the order of [`Prepared::tiles`].
    pub(super) frames: Vec<Vec<f64>>,
}

/// Times tiles along a path. The frame path of sessions is not touched by this.
pub(super) fn record(prepared: &Prepared, views: &[View], common: &Common) -> Result<Costs, Failure> {
    let stride = views.len().div_ceil(SAMPLED).max(1);
    let mut scratch = Scratch::default();
    let mut frames = Vec::with_capacity(SAMPLED);
    for view in views.iter().step_by(stride) {
        let plan = common.limits.accept(plan_for_view_within(prepared, view, &common.limits.plan()))?;
        frames.push(tiles(prepared, &plan, &mut scratch));
    }
    Ok(Costs { stride, frames })
}

/// Milliseconds of each tile.
fn tiles(prepared: &Prepared, plan: &Plan, scratch: &mut Scratch) -> Vec<f64> {
    let mut costs = vec![f64::INFINITY; prepared.tiles().count()];
    for _ in 0..TIMES {
        for ((part, tile, _), cost) in prepared.tiles().zip(&mut costs) {
            let begun = Instant::now();
            let outcome = tessellate_tile(prepared, plan, part, tile, scratch);
            *cost = cost.min(ms(begun.elapsed()));
            drop(std::hint::black_box(outcome));
        }
    }
    costs
}

/// Milliseconds from an order to the last delivery when there is nothing to do: the median of some frames.
pub(super) fn hand_off(workers: usize) -> Result<f64, Failure> {
    const FRAMES: usize = 101;
    let cannot = |e: &dyn std::error::Error| Failure::Cannot(e.to_string());
    let options = SessionOptions::DEFAULT.with_workers(workers).with_edge_lines(false);
    let mut session = Session::start(Arc::new(Prepared::default()), &options).map_err(|e| cannot(&e))?;
    let (plan, mut sink) = (Arc::new(Plan::default()), MemorySink::default());
    let mut times = Vec::with_capacity(FRAMES);
    for _ in 0..FRAMES {
        let report = session.frame(&plan, &mut sink).map_err(|e| cannot(&e))?;
        times.push(ms(report.made_in));
    }
    times.sort_by(f64::total_cmp);
    Ok(times[FRAMES / 2])
}
