//! Prepared model + worker count -> a session: tiles dealt once, plans broadcast, frames committed on the caller's thread.

use super::distribute::{deal, loads};
use super::handoff::{Delivery, Order, queues};
use super::metrics::Laps;
use super::render_thread::{FrameError, FrameReport, commit, gather};
use super::worker::{Hand, Stages, Worker};
use crate::frame::{Plan, Scratch, TileOutcome, edge_line, tessellate_tile};
use crate::mesh::{EdgeLine, MeshSink, Scene, TileId};
use crate::model::{EdgeId, PartId};
use crate::prepare::Prepared;
use crossbeam::channel::{Receiver, Sender};
use std::fmt;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

/// Knobs of a [`Session`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionOptions {
    /// Worker threads; 0 = one per core that the process may use. More than there are tiles is a waste, not an error.
    pub workers: usize,
    /// Whether sinks get the polylines of B-rep edges too.
    pub edge_lines: bool,
}

impl SessionOptions {
    /// One worker per core, with edge lines.
    pub const DEFAULT: Self = Self { workers: 0, edge_lines: true };

    /// The same with `workers` threads.
    #[must_use]
    pub const fn with_workers(self, workers: usize) -> Self {
        Self { workers, ..self }
    }

    /// The same with or without edge lines.
    #[must_use]
    pub const fn with_edge_lines(self, edge_lines: bool) -> Self {
        Self { edge_lines, ..self }
    }
}

impl Default for SessionOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Why a session did not start: the operating system refused a thread.
#[derive(Debug)]
pub struct StartError {
    /// The worker whose thread was refused.
    pub worker: usize,
    /// What the system said.
    pub cause: std::io::Error,
}

impl fmt::Display for StartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot start the thread of worker {}: {}", self.worker, self.cause)
    }
}

impl std::error::Error for StartError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.cause)
    }
}

/// The workers of a session and the ends of their queues.
pub(super) struct Crew<S: Stages> {
    orders: Vec<Sender<Order<S::Plan>>>,
    deliveries: Vec<Receiver<Delivery>>,
    threads: Vec<JoinHandle<()>>,
    next_frame: u64,
}

impl<S: Stages> Crew<S> {
    /// One thread per hand. Threads already started end when a later one is refused.
    pub(super) fn start(stages: &Arc<S>, hands: Vec<Hand>) -> Result<Self, StartError> {
        let mut crew = Self { orders: Vec::new(), deliveries: Vec::new(), threads: Vec::new(), next_frame: 0 };
        for (worker, hand) in hands.into_iter().enumerate() {
            let (order, end, delivery) = queues();
            #[allow(clippy::cast_possible_truncation, reason = "threads are fewer than 2^32")]
            let worker_state = Worker::new(worker as u32, Arc::clone(stages), hand);
            let thread = thread::Builder::new()
                .name(format!("trimtess-worker-{worker}"))
                .spawn(move || worker_state.serve(&end))
                .map_err(|cause| StartError { worker, cause })?;
            crew.orders.push(order);
            crew.deliveries.push(delivery);
            crew.threads.push(thread);
        }
        Ok(crew)
    }

    /// Broadcasts the plan, waits for all workers, commits.
    pub(super) fn frame(
        &mut self,
        plan: &Arc<S::Plan>,
        scene: &Scene,
        sink: &mut dyn MeshSink,
    ) -> Result<FrameReport, FrameError> {
        let _span = tracing::debug_span!("frame", number = self.next_frame).entered();
        let laps = Laps::start();
        let frame = self.next_frame;
        self.next_frame += 1;
        for (worker, orders) in self.orders.iter().enumerate() {
            let order = Order { frame, plan: Arc::clone(plan) };
            orders.send(order).map_err(|_| FrameError::WorkerLost { worker })?;
        }
        commit(gather(&self.deliveries, frame)?, scene, sink, laps)
    }
}

impl<S: Stages> Drop for Crew<S> {
    fn drop(&mut self) {
        // Hanging up both queues ends every worker after the tile loop that it is in.
        self.orders.clear();
        self.deliveries.clear();
        for thread in self.threads.drain(..) {
            // A worker that died was reported by the frame that missed it.
            let _ = thread.join();
        }
    }
}

impl Stages for Prepared {
    type Plan = Plan;
    type Scratch = Scratch;

    fn tile(&self, plan: &Plan, part: PartId, tile: TileId, scratch: &mut Scratch) -> TileOutcome {
        tessellate_tile(self, plan, part, tile, scratch)
    }

    fn edge_line(&self, plan: &Plan, part: PartId, edge: EdgeId) -> EdgeLine {
        edge_line(self, plan, part, edge)
    }
}

/// A prepared model with its workers. Threads start here and end when the session is dropped.
///
/// ```no_run
/// use std::sync::Arc;
/// use trimtess::{frame, mesh::MemorySink, parallel, prepare};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let model = trimtess::model::Model::default();
/// let prepared = Arc::new(prepare::prepare(model, &prepare::PrepareOptions::DEFAULT)?);
/// let tolerance = frame::Tolerance { chord: 0.1, angle: 0.35, max_edge: None };
/// let mut session = parallel::Session::start(Arc::clone(&prepared), &parallel::SessionOptions::DEFAULT)?;
/// let mut sink = MemorySink::default();
/// let report = session.frame(&Arc::new(frame::plan(&prepared, &tolerance)), &mut sink)?;
/// assert_eq!(report.batches, sink.batches.len());
/// # Ok(())
/// # }
/// ```
pub struct Session {
    prepared: Arc<Prepared>,
    crew: Crew<Prepared>,
}

impl Session {
    /// Deals the tiles and starts the workers.
    ///
    /// # Errors
    /// When the system refuses a thread; none is left behind.
    pub fn start(prepared: Arc<Prepared>, options: &SessionOptions) -> Result<Self, StartError> {
        let workers = match options.workers {
            0 => thread::available_parallelism().map_or(1, usize::from),
            workers => workers,
        };
        let crew = Crew::start(&prepared, hands(&prepared, workers, options.edge_lines))?;
        Ok(Self { prepared, crew })
    }

    /// How many workers there are.
    #[must_use]
    pub fn workers(&self) -> usize {
        self.crew.threads.len()
    }

    /// Makes one frame by `plan` and feeds it to `sink`, from this thread. The sink sees the same calls with the same
    /// bytes for any number of workers ([`Batch::worker`](crate::mesh::Batch::worker) excepted).
    ///
    /// # Errors
    /// When the sink refuses (it has been told to abort; the session goes on) or a worker is gone (the session is over).
    pub fn frame(&mut self, plan: &Arc<Plan>, sink: &mut dyn MeshSink) -> Result<FrameReport, FrameError> {
        self.crew.frame(plan, &self.prepared.scene, sink)
    }
}

/// The same frame with no thread but the caller's: the stages of [`Session::frame`], called in order.
///
/// # Errors
/// When the sink refuses; it has been told to abort.
pub fn serial(
    prepared: &Arc<Prepared>,
    plan: &Plan,
    edge_lines: bool,
    sink: &mut dyn MeshSink,
) -> Result<FrameReport, FrameError> {
    let laps = Laps::start();
    let deliveries = hands(prepared, 1, edge_lines)
        .into_iter()
        .map(|hand| Worker::new(0, Arc::clone(prepared), hand).make(0, plan))
        .collect();
    commit(deliveries, &prepared.scene, sink, laps)
}

/// What each worker owns: tiles as they are dealt; edges, far cheaper, in turn.
fn hands(prepared: &Prepared, workers: usize, edge_lines: bool) -> Vec<Hand> {
    let tiles: Vec<_> = prepared.tiles().map(|(part, tile, row)| (part, tile, row.face)).collect();
    let mut hands: Vec<Hand> = deal(&loads(prepared), workers)
        .into_iter()
        .map(|hand| Hand { tiles: hand.into_iter().map(|index| tiles[index]).collect(), edges: Vec::new() })
        .collect();
    if edge_lines {
        for (index, edge) in prepared.brep_edges().enumerate() {
            hands[index % workers.max(1)].edges.push(edge);
        }
    }
    hands
}

#[cfg(test)]
mod tests {
    use super::super::handoff::FaceRung;
    use super::*;
    use crate::frame::{Degradation, Rung};
    use crate::mesh::{Batch, MemorySink, PatchMesh, SinkError};
    use crate::model::FaceId;
    use glam::DVec3;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// Stands in for a prepared model: one triangle per tile, named by tile, plan and the scratch's history.
    struct Fake {
        panics_at: Option<u32>,
        made: AtomicU32,
    }

    impl Stages for Fake {
        type Plan = f64;
        type Scratch = u32;

        fn tile(&self, plan: &f64, _: PartId, tile: TileId, scratch: &mut u32) -> TileOutcome {
            *scratch += 1;
            self.made.fetch_add(1, Ordering::Relaxed);
            assert!(self.panics_at != Some(tile.0), "tile {} is bad", tile.0);
            let x = f64::from(tile.0);
            let positions = vec![DVec3::new(x, *plan, 0.0), DVec3::X, DVec3::Y];
            let mesh = PatchMesh { positions, triangles: vec![[0, 1, 2]], ..PatchMesh::default() };
            TileOutcome { face: FaceId(tile.0 / 2), mesh, rung: Rung::Normal, degradation: None }
        }

        fn edge_line(&self, plan: &f64, part: PartId, edge: EdgeId) -> EdgeLine {
            assert!(self.panics_at != Some(edge.0), "edge {} is bad", edge.0);
            EdgeLine { part, edge, points: vec![DVec3::splat(*plan)] }
        }
    }

    const TILES: u32 = 37;

    fn start(panics_at: Option<u32>, workers: u32) -> (Arc<Fake>, Crew<Fake>) {
        let fake = Arc::new(Fake { panics_at, made: AtomicU32::new(0) });
        let mut hands = vec![Hand::default(); workers as usize];
        for k in 0..TILES {
            let hand = &mut hands[(k * 7 % workers) as usize];
            hand.tiles.push((PartId(k / 20), TileId(k), FaceId(k / 2)));
            hand.edges.push((PartId(k / 20), EdgeId(k)));
        }
        let crew = Crew::start(&fake, hands).unwrap();
        (fake, crew)
    }

    fn without_worker(sink: &MemorySink) -> Vec<Batch> {
        sink.batches.iter().cloned().map(|batch| Batch { worker: 0, ..batch }).collect()
    }

    #[test]
    fn order_and_content_do_not_depend_on_workers() {
        let mut seen = Vec::new();
        for workers in [1, 2, 3, 8, 64] {
            let (_, mut crew) = start(None, workers);
            for plan in [0.5, 0.25] {
                let mut sink = MemorySink::default();
                let report = crew.frame(&Arc::new(plan), &Scene::default(), &mut sink).unwrap();
                assert_eq!((report.batches, report.triangles), (TILES as usize, u64::from(TILES)));
                assert_eq!(report.workers.len(), workers as usize);
                assert!(sink.batches.is_sorted_by_key(|b| (b.part, b.tile)));
                assert!(sink.edge_lines.is_sorted_by_key(|l| (l.part, l.edge)));
                seen.push((plan.to_bits(), without_worker(&sink), sink.edge_lines));
            }
        }
        for k in 2..seen.len() {
            assert_eq!(seen[k], seen[k % 2]);
        }
    }

    #[test]
    fn a_panic_costs_one_tile_or_line_and_neither_frame_nor_session() {
        for workers in [1, 3] {
            let (fake, mut crew) = start(Some(11), workers);
            for frame in 1..=3 {
                let mut sink = MemorySink::default();
                let report = crew.frame(&Arc::new(1.0), &Scene::default(), &mut sink).unwrap();
                assert_eq!(report.batches, TILES as usize - 1);
                assert_eq!(fake.made.load(Ordering::Relaxed), frame * TILES);
                let [bad] = &report.degraded[..] else { panic!("{:?}", report.degraded) };
                assert_eq!((bad.tile, bad.face), (TileId(11), FaceId(5)));
                assert_eq!(bad.degradation, Degradation::Failed("internal error: tile 11 is bad".into()));
                let face = FaceRung { part: PartId(0), face: FaceId(5), rung: Rung::Lost };
                assert_eq!((&report.rungs[..], report.ladder.count(Rung::Lost)), (&[face][..], 1));
                let [lost] = &report.lost_lines[..] else { panic!("{:?}", report.lost_lines) };
                assert_eq!((lost.edge, lost.why.as_str()), (EdgeId(11), "internal error: edge 11 is bad"));
                assert_eq!(sink.edge_lines.len(), TILES as usize - 1);
            }
        }
    }

    /// Refuses call number `at` and counts what comes after.
    struct Refusing {
        at: usize,
        calls: usize,
        aborts: usize,
        ends: usize,
    }

    impl Refusing {
        fn call(&mut self) -> Result<(), SinkError> {
            self.calls += 1;
            if self.calls == self.at {
                return Err(SinkError { context: "disk".into(), cause: std::io::Error::other("full") });
            }
            assert!(self.calls < self.at, "called after it refused");
            Ok(())
        }
    }

    impl MeshSink for Refusing {
        fn begin(&mut self, _: &Scene) -> Result<(), SinkError> {
            self.call()
        }
        fn batch(&mut self, _: &mut Batch) -> Result<(), SinkError> {
            self.call()
        }
        fn edge_line(&mut self, _: EdgeLine) -> Result<(), SinkError> {
            self.call()
        }
        fn end(&mut self) -> Result<(), SinkError> {
            self.ends += 1;
            self.call()
        }
        fn abort(&mut self) {
            self.aborts += 1;
        }
    }

    #[test]
    fn a_refusing_sink_is_aborted_once_and_the_session_goes_on() {
        let (_, mut crew) = start(None, 3);
        let calls = 2 + 2 * TILES as usize;
        for at in [1, 2, TILES as usize + 2, calls] {
            let mut sink = Refusing { at, calls: 0, aborts: 0, ends: 0 };
            let error = crew.frame(&Arc::new(1.0), &Scene::default(), &mut sink).unwrap_err();
            assert_eq!(error.to_string(), "disk: full");
            assert_eq!((sink.calls, sink.aborts, sink.ends), (at, 1, usize::from(at == calls)));
        }
        let report = crew.frame(&Arc::new(1.0), &Scene::default(), &mut MemorySink::default()).unwrap();
        assert_eq!((report.frame, report.batches), (4, TILES as usize));
    }

    #[test]
    fn a_lost_worker_is_an_error_and_dropping_the_session_ends_all_threads() {
        let (fake, mut crew) = start(None, 2);
        // Hanging up one worker's orders ends its thread, as a crash outside a tile would.
        let (order, _, _) = queues();
        drop(std::mem::replace(&mut crew.orders[1], order));
        let error = crew.frame(&Arc::new(1.0), &Scene::default(), &mut MemorySink::default()).unwrap_err();
        assert!(matches!(error, FrameError::WorkerLost { worker: 1 }), "{error}");
        drop(crew);
        assert_eq!(Arc::strong_count(&fake), 1, "a worker outlived its session");
    }
}
