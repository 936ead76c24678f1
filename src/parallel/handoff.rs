//! What crosses threads, and nothing else does: orders to the workers, deliveries to the render thread.

use super::metrics::WorkerMetrics;
use crate::frame::{Degradation, Rung};
use crate::mesh::{Batch, EdgeLine, TileMesh};
use crate::model::{EdgeId, FaceId, PartId, TileId};
use crossbeam_channel::{Receiver, Sender, bounded};
use std::sync::Arc;
use std::time::Duration;

/// Orders a worker may have waiting: the frame that it makes next.
const ORDERS_AHEAD: usize = 1;

/// Deliveries a worker may have waiting: the frame that the render thread commits next, and a late one.
const DELIVERIES_AHEAD: usize = 2;

/// What one worker owns, ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Hand {
    /// Tiles, and the faces that they belong to.
    pub(super) tiles: Vec<(PartId, TileId, FaceId)>,
    /// Edges whose polylines it makes.
    pub(super) edges: Vec<(PartId, EdgeId)>,
    /// Tiles of which it need keep nothing, before anything is made.
    pub(super) gone: Gone,
}

/// Tiles that are not to be patched up from what they were.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Gone {
    /// All that there are.
    pub(super) all: bool,
    /// These.
    pub(super) tiles: Vec<(PartId, TileId)>,
}

impl Hand {
    /// Whether there is nothing to make.
    pub(super) fn is_empty(&self) -> bool {
        self.tiles.is_empty() && self.edges.is_empty()
    }
}

/// What an order asks for.
pub(super) enum Task {
    /// All that the worker owns of the first so many parts.
    All(usize),
    /// Some of what it owns.
    Some(Hand),
}

/// Master to worker: make your tiles by this plan.
pub(super) struct Order<P> {
    /// Number of the frame, ascending.
    pub(super) frame: u64,
    /// The plan, the same for all workers.
    pub(super) plan: Arc<P>,
    /// What of the worker's own to make.
    pub(super) task: Task,
    /// Whether to take the time of each tile.
    pub(super) timed: bool,
    /// Buffers to make it in.
    pub(super) spare: Vec<TileMesh>,
}

/// Worker to render thread: everything that one worker made for one frame.
#[derive(Default)]
pub(super) struct Delivery {
    /// Number of the frame.
    pub(super) frame: u64,
    /// Batches, ascending by (part, tile); when a worker makes all that it owns, only those with triangles.
    pub(super) batches: Vec<Batch>,
    /// What each tile took, if that was asked.
    pub(super) times: Vec<(PartId, TileId, Duration)>,
    /// Edge polylines, ascending by (part, edge).
    pub(super) lines: Vec<EdgeLine>,
    /// Tiles that came out less than as stated, ascending by (part, tile).
    pub(super) degraded: Vec<DegradedTile>,
    /// Rungs of tiles off the normal path, ascending by (part, tile).
    pub(super) rungs: Vec<FaceRung>,
    /// Tiles that hold more than what their loops wind around once, ascending by (part, tile).
    pub(super) fills: Vec<(TileId, FaceFill)>,
    /// Edges without polyline, ascending by (part, edge).
    pub(super) lost_lines: Vec<LostLine>,
    /// What it took.
    pub(super) metrics: WorkerMetrics,
}

/// A tile that came out less than as stated.
#[derive(Clone, Debug, PartialEq)]
pub struct DegradedTile {
    /// The part.
    pub part: PartId,
    /// The face within the part.
    pub face: FaceId,
    /// The tile within the part.
    pub tile: TileId,
    /// What happened to it.
    pub degradation: Degradation,
}

/// How far down the ladder of fallbacks a face went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaceRung {
    /// The part.
    pub part: PartId,
    /// The face within the part.
    pub face: FaceId,
    /// The worst rung of its tiles; [`Rung::Lost`] or [`Rung::NoArea`] if it has no triangles at all.
    pub rung: Rung,
}

/// What a face holds besides the triangles that its boundary winds around once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceFill {
    /// The part.
    pub part: PartId,
    /// The face within the part.
    pub face: FaceId,
    /// Triangles that only close the boundary; where it is not simple, also those that have no area.
    pub slivers: u32,
    /// Area that the boundary winds around otherwise than once, mm².
    pub rewound: f64,
}

impl FaceFill {
    /// Adds what another tile of the face holds.
    pub(super) fn add(&mut self, other: &Self) {
        self.slivers += other.slivers;
        self.rewound += other.rewound;
    }
}

/// A B-rep edge that has no polyline. Triangles are not touched by that.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LostLine {
    /// The part.
    pub part: PartId,
    /// The edge within the part.
    pub edge: EdgeId,
    /// What happened to it.
    pub why: String,
}

/// One worker's ends of its own two queues.
pub(super) struct WorkerEnd<P> {
    pub(super) orders: Receiver<Order<P>>,
    pub(super) deliveries: Sender<Delivery>,
}

/// The other ends: the master's and the render thread's.
pub(super) fn queues<P>() -> (Sender<Order<P>>, WorkerEnd<P>, Receiver<Delivery>) {
    let (give_order, orders) = bounded(ORDERS_AHEAD);
    let (deliveries, take_delivery) = bounded(DELIVERIES_AHEAD);
    (give_order, WorkerEnd { orders, deliveries }, take_delivery)
}
