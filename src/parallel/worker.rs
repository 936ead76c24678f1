//! Own tiles and a plan -> one delivery of each worker per frame, on whichever thread is free. A worker owns its tiles
//! and shares no mutable data: no locks, no messages to other workers.

use super::handoff::{DegradedTile, Delivery, FaceFill, FaceRung, Hand, LostLine, MadeTile, Seats, Watch};
use super::metrics::{Laps, Processor};
use super::writer::{Rooms, Writer};
use crate::control::{Jobs, map_with};
use crate::frame::internals::{Scratch, TileOutcome, edge_line, fill_tile, tessellate_tile};
use crate::frame::{Plan, Rung};
use crate::mesh::{Batch, MeshLists, NotWritten, SinkError, TileMesh, WrittenTile};
use crate::model::{PartId, TileId};
use crate::prepare::Prepared;
use crate::prepare::internals::panic_message;
use std::any::Any;
use std::cmp::Reverse;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

/// What all workers are told about a frame.
pub(super) struct Order {
    pub(super) plan: Arc<Plan>,
    pub(super) watch: Watch,
    /// Where triangles go, if not into batches.
    pub(super) writer: Option<Arc<Writer>>,
    /// Lists of meshes that are read.
    pub(super) lists: MeshLists,
}

/// A worker at work, in the scratch of the thread that it runs on.
struct Worker<'a> {
    /// Its place among the workers.
    pub(super) number: u32,
    pub(super) prepared: &'a Prepared,
    pub(super) scratch: &'a mut Scratch,
}

impl Worker<'_> {
    /// Makes the tiles and edges of a hand in the first `parts` parts, in ascending order. `timed`: whether to measure
    /// each tile.
    ///
    /// A panic in a tile is a defect of this crate and costs the inside of that tile: its boundary is filled, and it is
    /// delivered as [`Degradation::Filled`](crate::frame::Degradation::Filled) with the panic's message. A panic in an
    /// edge costs its polyline, see [`LostLine`].
    ///
    /// `list`: of the tiles that it wrote last, for its room.
    pub(super) fn make(
        &mut self,
        order: &Order,
        (hand, parts): (&Hand, usize),
        timed: bool,
        list: Vec<WrittenTile>,
    ) -> Delivery {
        let Order { plan, watch, writer, lists } = order;
        let tiles = &hand.tiles[..hand.tiles.partition_point(|(part, _, _)| part.index() < parts)];
        let edges = &hand.edges[..hand.edges.partition_point(|(part, _)| part.index() < parts)];
        let _span = tracing::debug_span!("worker", number = self.number).entered();
        let mut delivery = Delivery { written: Rooms::of(writer.as_ref(), tiles.len(), list), ..Delivery::default() };
        delivery.metrics.worker = self.number;
        let (mut laps, processor) = (Laps::start(), Processor::start());
        if writer.is_none() {
            delivery.made.reserve_exact(tiles.len());
            delivery.batches.reserve_exact(tiles.len());
        }
        for &(part, tile, face) in tiles {
            if watch.is_cancelled() {
                return delivery;
            }
            let _span = tracing::trace_span!("tile", part = part.0, tile = tile.0, face = face.0).entered();
            let clock = timed.then(Laps::start);
            let (prepared, scratch) = (self.prepared, &mut *self.scratch);
            let make = || tessellate_tile(prepared, plan, (part, tile), *lists, scratch);
            let outcome = catch_unwind(AssertUnwindSafe(make));
            let outcome = outcome.unwrap_or_else(|payload| {
                // The scratch may be half written, so the next tile gets a new one.
                *self.scratch = Scratch::default();
                let why = format!("internal error: {}", panic_message(&*payload));
                let fill = || fill_tile(prepared, plan, part, tile, why.clone());
                catch_unwind(AssertUnwindSafe(fill)).unwrap_or_else(|_| TileOutcome::lost(face, why))
            });
            let triangles = outcome.mesh.triangles.len() as u32;
            if let Some(writer) = writer {
                let chord = plan.parts[part.index()].tiles[tile.0 as usize].chord;
                if !self.write(writer, (part, tile), &outcome, chord, &mut delivery) {
                    return delivery;
                }
            }
            let mut mesh = take(&mut delivery, part, tile, outcome);
            if triangles == 0 {
                delivery.note().bare.push((part, face));
            }
            if writer.is_some() {
                self.scratch.reuse(mesh);
            } else {
                // A sink may keep it for long.
                mesh.shrink_to_fit();
                delivery.made.push(MadeTile::new(part, tile, (triangles, mesh.bytes())));
                delivery.batches.push(Batch { part, face, tile, worker: self.number, mesh });
            }
            watch.advance();
            if let Some(mut clock) = clock {
                delivery.note().times.push((part, tile, clock.lap()));
            }
        }
        delivery.metrics.tiles_time = laps.lap();
        for &(part, edge) in edges {
            if watch.is_cancelled() {
                return delivery;
            }
            match catch_unwind(AssertUnwindSafe(|| edge_line(self.prepared, plan, part, edge))) {
                Ok(line) => delivery.note().lines.push(line),
                Err(payload) => {
                    let why = format!("internal error: {}", panic_message(&*payload));
                    delivery.note().lost_lines.push(LostLine { part, edge, why });
                }
            }
        }
        delivery.metrics.lines_time = laps.lap();
        delivery.metrics.cpu = processor.used();
        delivery
    }

    /// Writes a tile into the sink's memory. Returns whether that succeeded.
    fn write(
        &self,
        writer: &Writer,
        (part, tile): (PartId, TileId),
        outcome: &TileOutcome,
        chord: f64,
        delivery: &mut Delivery,
    ) -> bool {
        let write = || writer.write((part, outcome.face, tile), &outcome.mesh, (self.number, chord));
        let written = catch_unwind(AssertUnwindSafe(write)).unwrap_or_else(|panic| Err(panicked(&*panic)));
        let is_written = written.is_ok();
        match written {
            Ok(written) => delivery.written.push(written),
            Err(why) => delivery.note().refused = Some((part, tile, why)),
        }
        is_written
    }
}

/// The memory of a sink panicked.
fn panicked(payload: &(dyn Any + Send)) -> NotWritten {
    let cause = std::io::Error::other(panic_message(payload));
    NotWritten::Sink(SinkError::new("the sink's memory panicked", cause))
}

/// Adds what is told about one tile to the delivery, and returns its triangles.
fn take(delivery: &mut Delivery, part: PartId, tile: TileId, outcome: TileOutcome) -> TileMesh {
    let TileOutcome { mesh, face, rung, degradation, slivers, rewound } = outcome;
    delivery.metrics.tiles += 1;
    delivery.metrics.triangles += mesh.triangles.len() as u64;
    if rung > Rung::Normal {
        delivery.note().rungs.push(FaceRung { part, face, rung });
    }
    if slivers > 0 || rewound > 0.0 {
        delivery.note().fills.push((tile, FaceFill { part, face, slivers, rewound }));
    }
    if let Some(degradation) = degradation {
        delivery.note().degraded.push(DegradedTile { part, face, tile, degradation });
    }
    mesh
}

/// What each worker has to make in a frame.
pub(super) enum Work {
    /// Everything that it owns of the first `n` parts.
    All(usize),
    /// Its hand of these, a subset of what it owns; and whether to measure each tile.
    Some(Vec<Hand>, bool),
}

/// The workers of a session.
pub(super) struct Crew {
    prepared: Arc<Prepared>,
    /// What each worker owns.
    hands: Arc<Vec<Hand>>,
    /// How long each worker took in the last frame of everything.
    took: Vec<Duration>,
    /// Of each thread, whichever workers it runs: what was used last is in its caches.
    // Boxed: they are large, and move to threads and back.
    #[allow(clippy::vec_box, reason = "see above")]
    scratches: Vec<Box<Scratch>>,
    seats: Seats,
}

impl Crew {
    /// One worker per hand.
    pub(super) fn of(prepared: &Arc<Prepared>, hands: Vec<Hand>) -> Self {
        Self {
            prepared: Arc::clone(prepared),
            took: vec![Duration::ZERO; hands.len()],
            scratches: Vec::new(),
            seats: Seats::of(&hands, &prepared.scene),
            hands: Arc::new(hands),
        }
    }

    /// Replaces the model by the same with more parts.
    pub(super) fn set_prepared(&mut self, prepared: &Arc<Prepared>) {
        self.prepared = Arc::clone(prepared);
    }

    /// Number of workers.
    pub(super) fn len(&self) -> usize {
        self.hands.len()
    }

    /// Where the tiles of a frame of everything are.
    pub(super) fn seats(&self) -> &Seats {
        &self.seats
    }

    /// Makes a frame: a delivery of each worker that has something to do, in any order. When cancelled, deliveries are
    /// incomplete.
    ///
    /// `lists`: by worker, of the tiles that it wrote last. Those of the workers are taken, for their room.
    pub(super) fn make(
        &mut self,
        jobs: &dyn Jobs,
        order: Order,
        work: Work,
        lists: &mut [Vec<WrittenTile>],
    ) -> Vec<Delivery> {
        let _span = tracing::trace_span!("tiles").entered();
        // The longest first: what a thread begins last is short, and all end at about the same time.
        let (hands, parts, timed, busy) = match work {
            Work::All(parts) => {
                let mut busy: Vec<usize> = (0..self.hands.len()).collect();
                busy.sort_unstable_by_key(|&worker| Reverse(self.took[worker]));
                (Arc::clone(&self.hands), parts, false, busy)
            }
            Work::Some(hands, timed) => {
                let mut busy: Vec<usize> = (0..hands.len()).filter(|&worker| !hands[worker].is_empty()).collect();
                busy.sort_unstable_by_key(|&worker| Reverse(hands[worker].tiles.len()));
                (Arc::new(hands), usize::MAX, timed, busy)
            }
        };
        let is_all = Arc::ptr_eq(&hands, &self.hands);
        let prepared = Arc::clone(&self.prepared);
        let with_list = |worker: usize| (worker, lists.get_mut(worker).map(std::mem::take).unwrap_or_default());
        let busy = busy.into_iter().map(with_list).collect();
        let make = move |scratch: &mut Box<Scratch>, (worker, list): (usize, Vec<WrittenTile>)| {
            let mut at_work = Worker { number: worker as u32, prepared: &prepared, scratch };
            at_work.make(&order, (&hands[worker], parts), timed, list)
        };
        let deliveries = map_with(jobs, &mut self.scratches, busy, make);
        if is_all {
            // One that stopped early tells no time.
            let whole = deliveries.iter().map(|delivery| &delivery.metrics).filter(|metrics| !metrics.busy().is_zero());
            whole.for_each(|metrics| self.took[metrics.worker as usize] = metrics.busy());
        }
        deliveries
    }
}
