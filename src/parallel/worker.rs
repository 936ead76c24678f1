//! Own tiles + plan -> one delivery per frame. A worker keeps its tiles and its scratch for the whole session and shares
//! nothing that changes: no locks, no messages to other workers.

use super::handoff::{DegradedTile, Delivery, FaceRung, LostLine, Order, Task, WorkerEnd};
use super::metrics::{Laps, Processor};
use crate::frame::{Degradation, Rung, TileOutcome};
use crate::mesh::{Batch, EdgeLine, PatchMesh, TileId};
use crate::model::{EdgeId, FaceId, PartId};
use crate::prepare::panic_message;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The stages that a worker runs. [`Prepared`](crate::prepare::Prepared) is the real one; tests put others in its place.
pub(super) trait Stages: Send + Sync + 'static {
    /// What the master broadcasts.
    type Plan: Send + Sync + 'static;
    /// What a worker keeps between tiles; its content never shows in a result.
    type Scratch: Default + Send;

    /// Gives a buffer that coming tiles may be made in.
    fn reuse(scratch: &mut Self::Scratch, mesh: PatchMesh);

    /// Makes one tile.
    fn tile(&self, plan: &Self::Plan, part: PartId, tile: TileId, scratch: &mut Self::Scratch) -> TileOutcome;

    /// Makes one edge's polyline.
    fn edge_line(&self, plan: &Self::Plan, part: PartId, edge: EdgeId) -> EdgeLine;
}

/// What one worker owns, ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Hand {
    /// Tiles, and the faces that they belong to.
    pub(super) tiles: Vec<(PartId, TileId, FaceId)>,
    /// Edges whose polylines it makes.
    pub(super) edges: Vec<(PartId, EdgeId)>,
}

impl Hand {
    pub(super) fn is_empty(&self) -> bool {
        self.tiles.is_empty() && self.edges.is_empty()
    }
}

/// A worker: a hand and the scratch it is worked with.
pub(super) struct Worker<S: Stages> {
    number: u32,
    stages: Arc<S>,
    hand: Hand,
    scratch: S::Scratch,
    wanted_from: Arc<AtomicU64>,
}

impl<S: Stages> Worker<S> {
    /// The worker `number` with its hand. Frames before `wanted_from` are left half done.
    pub(super) fn new(number: u32, stages: Arc<S>, hand: Hand, wanted_from: Arc<AtomicU64>) -> Self {
        Self { number, stages, hand, scratch: S::Scratch::default(), wanted_from }
    }

    /// Makes every tile and edge of the hand that is of the first `parts` parts by `plan`, in ascending order.
    ///
    /// A panic in a tile is a defect of this crate; it costs that tile only, which is delivered as
    /// [`Degradation::Failed`] with what the panic said. One in an edge costs its polyline: a [`LostLine`].
    pub(super) fn make_all(&mut self, frame: u64, plan: &S::Plan, parts: usize) -> Delivery {
        let hand = std::mem::take(&mut self.hand);
        let tiles = hand.tiles.partition_point(|(part, _, _)| part.index() < parts);
        let edges = hand.edges.partition_point(|(part, _)| part.index() < parts);
        let mut delivery = self.make(frame, plan, &hand.tiles[..tiles], &hand.edges[..edges], false);
        delivery.batches.retain(|batch| !batch.mesh.triangles.is_empty());
        self.hand = hand;
        delivery
    }

    /// The same for some tiles and edges; `timed`: with what each tile takes. Tiles without triangles are delivered too.
    fn make(
        &mut self,
        frame: u64,
        plan: &S::Plan,
        tiles: &[(PartId, TileId, FaceId)],
        edges: &[(PartId, EdgeId)],
        timed: bool,
    ) -> Delivery {
        let _span = tracing::debug_span!("worker", number = self.number, frame).entered();
        let mut delivery = Delivery { frame, ..Delivery::default() };
        delivery.metrics.worker = self.number;
        let (mut laps, processor) = (Laps::start(), Processor::start());
        for &(part, tile, face) in tiles {
            if frame < self.wanted_from.load(Ordering::Relaxed) {
                return delivery;
            }
            let _span = tracing::trace_span!("tile", part = part.0, tile = tile.0, face = face.0).entered();
            let clock = timed.then(Laps::start);
            let (stages, scratch) = (&*self.stages, &mut self.scratch);
            let outcome = catch_unwind(AssertUnwindSafe(|| stages.tile(plan, part, tile, scratch)));
            let outcome = outcome.unwrap_or_else(|payload| {
                // The scratch may be half written: the next tile gets a new one.
                self.scratch = S::Scratch::default();
                let degradation = Degradation::Failed(format!("internal error: {}", panic_message(&*payload)));
                TileOutcome { face, mesh: PatchMesh::default(), rung: Rung::Lost, degradation: Some(degradation) }
            });
            take(&mut delivery, part, tile, outcome);
            if let Some(mut clock) = clock {
                delivery.times.push((part, tile, clock.lap()));
            }
        }
        delivery.metrics.tiles_time = laps.lap();
        for &(part, edge) in edges {
            match catch_unwind(AssertUnwindSafe(|| self.stages.edge_line(plan, part, edge))) {
                Ok(line) => delivery.lines.push(line),
                Err(payload) => {
                    let why = format!("internal error: {}", panic_message(&*payload));
                    delivery.lost_lines.push(LostLine { part, edge, why });
                }
            }
        }
        delivery.metrics.lines_time = laps.lap();
        delivery.metrics.cpu = processor.used();
        delivery
    }

    /// Serves orders until the master or the render thread hangs up.
    pub(super) fn serve(mut self, end: &WorkerEnd<S::Plan>) {
        while let Ok(Order { frame, plan, task, timed, spare }) = end.orders.recv() {
            spare.into_iter().for_each(|mesh| S::reuse(&mut self.scratch, mesh));
            let delivery = match task {
                Task::All(parts) => self.make_all(frame, &plan, parts),
                Task::Some(hand) => self.make(frame, &plan, &hand.tiles, &hand.edges, timed),
            };
            // Whoever gets the delivery may be the last to know the plan, and make the next one in its place.
            drop(plan);
            if end.deliveries.send(delivery).is_err() {
                return;
            }
        }
    }
}

/// Books one tile.
fn take(delivery: &mut Delivery, part: PartId, tile: TileId, outcome: TileOutcome) {
    let TileOutcome { mesh, face, rung, degradation } = outcome;
    delivery.metrics.tiles += 1;
    delivery.metrics.triangles += mesh.triangles.len() as u64;
    if rung > Rung::Normal {
        delivery.rungs.push(FaceRung { part, face, rung });
    }
    if let Some(degradation) = degradation {
        delivery.degraded.push(DegradedTile { part, face, tile, degradation });
    }
    delivery.batches.push(Batch { part, face, tile, worker: delivery.metrics.worker, mesh });
}
