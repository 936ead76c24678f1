//! Own tiles + plan -> one delivery per frame. A worker keeps its tiles and its scratch for the whole session and shares
//! nothing that changes: no locks, no messages to other workers.

use super::handoff::{DegradedTile, Delivery, FaceFill, FaceRung, Hand, LostLine, Order, Task, WorkerEnd};
use super::metrics::{Laps, Processor};
use crate::frame::{Reuse, Rung};
use crate::frame::internals::TileOutcome;
use crate::math::BitMix;
use crate::mesh::{Batch, EdgeLine, TileMesh};
use crate::model::{EdgeId, FaceId, PartId, TileId};
use crate::prepare::internals::panic_message;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The stages that a worker runs. [`Prepared`](crate::prepare::Prepared) is the real one; tests put others in its place.
pub(super) trait Stages: Send + Sync + 'static {
    /// What the master broadcasts.
    type Plan: Send + Sync + 'static;
    /// What a worker keeps between tiles; its content never shows in a result.
    type Scratch: Default + Send;
    /// What a worker keeps of a tile to patch it up with.
    type Cache: Default + Send;

    /// Gives a buffer that coming tiles may be made in.
    fn reuse(scratch: &mut Self::Scratch, mesh: TileMesh);

    /// Makes one tile.
    fn tile(&self, plan: &Self::Plan, part: PartId, tile: TileId, scratch: &mut Self::Scratch) -> TileOutcome;

    /// Makes one tile, starting from what it was the last time; and how many bytes are kept of it for the next.
    fn update(
        &self,
        plan: &Self::Plan,
        tile: (PartId, TileId),
        reuse: Reuse,
        memory: &mut Self::Cache,
        scratch: &mut Self::Scratch,
    ) -> (TileOutcome, usize);

    /// Fills one tile's boundary, because making it failed for the reason `why`.
    fn fill(&self, plan: &Self::Plan, part: PartId, tile: TileId, why: String) -> TileOutcome;

    /// Makes one edge's polyline.
    fn edge_line(&self, plan: &Self::Plan, part: PartId, edge: EdgeId) -> EdgeLine;
}

/// Something for each of some tiles.
type ByTile<T> = HashMap<(PartId, TileId), T, BuildHasherDefault<BitMix>>;

/// A worker: a hand, the scratch it is worked with, and what is kept of tiles.
pub(super) struct Worker<S: Stages> {
    number: u32,
    stages: Arc<S>,
    hand: Hand,
    scratch: S::Scratch,
    reuse: Reuse,
    /// What is kept of tiles, and the bytes of that.
    memories: ByTile<(S::Cache, usize)>,
    kept: usize,
    wanted_from: Arc<AtomicU64>,
}

impl<S: Stages> Worker<S> {
    /// The worker `number` with its hand. Frames before `wanted_from` are left half done.
    pub(super) fn new(number: u32, stages: Arc<S>, hand: Hand, reuse: Reuse, wanted_from: Arc<AtomicU64>) -> Self {
        let (scratch, memories) = (S::Scratch::default(), HashMap::default());
        Self { number, stages, hand, scratch, reuse, memories, kept: 0, wanted_from }
    }

    /// Makes every tile and edge of the hand that is of the first `parts` parts by `plan`, in ascending order.
    ///
    /// A panic in a tile is a defect of this crate. It costs the inside of that tile: its boundary is filled, and it is
    /// delivered as [`Degradation::Filled`](crate::frame::Degradation::Filled) with what the panic said. One in an edge costs its polyline: a [`LostLine`].
    pub(super) fn make_all(&mut self, frame: u64, plan: &S::Plan, parts: usize) -> Delivery {
        let hand = std::mem::take(&mut self.hand);
        let tiles = hand.tiles.partition_point(|(part, _, _)| part.index() < parts);
        let edges = hand.edges.partition_point(|(part, _)| part.index() < parts);
        let mut delivery = self.make(frame, plan, &hand.tiles[..tiles], &hand.edges[..edges], None);
        delivery.batches.retain(|batch| !batch.mesh.triangles.is_empty());
        self.hand = hand;
        delivery
    }

    /// The same for some tiles and edges; `some`, of a frame of views: whether with what each tile takes. Tiles are patched up then, and those
    /// without triangles are delivered too.
    fn make(
        &mut self,
        frame: u64,
        plan: &S::Plan,
        tiles: &[(PartId, TileId, FaceId)],
        edges: &[(PartId, EdgeId)],
        some: Option<bool>,
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
            let clock = (some == Some(true)).then(Laps::start);
            let reuse = (some.is_some() && self.reuse != Reuse::NONE).then_some(self.reuse);
            let memory = reuse.map(|reuse| (reuse, self.memories.entry((part, tile)).or_default()));
            let (stages, scratch, kept) = (&*self.stages, &mut self.scratch, &mut self.kept);
            let outcome = catch_unwind(AssertUnwindSafe(|| match memory {
                None => stages.tile(plan, part, tile, scratch),
                Some((reuse, (memory, bytes))) => {
                    let (outcome, now) = stages.update(plan, (part, tile), reuse, memory, scratch);
                    *kept = *kept - *bytes + now;
                    *bytes = now;
                    outcome
                }
            }));
            let outcome = outcome.unwrap_or_else(|payload| {
                self.forget((part, tile));
                // The scratch may be half written: the next tile gets a new one.
                self.scratch = S::Scratch::default();
                let why = format!("internal error: {}", panic_message(&*payload));
                let fill = || self.stages.fill(plan, part, tile, why.clone());
                catch_unwind(AssertUnwindSafe(fill)).unwrap_or_else(|_| TileOutcome::lost(face, why))
            });
            if self.memories.get(&(part, tile)).is_some_and(|(_, bytes)| *bytes == 0) {
                self.forget((part, tile));
            }
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
        delivery.metrics.kept = self.kept as u64;
        delivery.metrics.cpu = processor.used();
        delivery
    }

    /// Keeps nothing of a tile.
    fn forget(&mut self, tile: (PartId, TileId)) {
        self.kept -= self.memories.remove(&tile).map_or(0, |(_, bytes)| bytes);
    }

    /// Serves orders until the master or the render thread hangs up.
    pub(super) fn serve(mut self, end: &WorkerEnd<S::Plan>) {
        while let Ok(Order { frame, plan, task, timed, spare }) = end.orders.recv() {
            spare.into_iter().for_each(|mesh| S::reuse(&mut self.scratch, mesh));
            let delivery = match task {
                Task::All(parts) => self.make_all(frame, &plan, parts),
                Task::Some(hand) => {
                    if hand.gone.all {
                        self.memories = HashMap::default();
                        self.kept = 0;
                    }
                    hand.gone.tiles.iter().for_each(|&tile| self.forget(tile));
                    self.make(frame, &plan, &hand.tiles, &hand.edges, Some(timed))
                }
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
    let TileOutcome { mesh, face, rung, degradation, slivers, rewound } = outcome;
    delivery.metrics.tiles += 1;
    delivery.metrics.triangles += mesh.triangles.len() as u64;
    if rung > Rung::Normal {
        delivery.rungs.push(FaceRung { part, face, rung });
    }
    if slivers > 0 || rewound > 0.0 {
        delivery.fills.push((tile, FaceFill { part, face, slivers, rewound }));
    }
    if let Some(degradation) = degradation {
        delivery.degraded.push(DegradedTile { part, face, tile, degradation });
    }
    delivery.batches.push(Batch { part, face, tile, worker: delivery.metrics.worker, mesh });
}
