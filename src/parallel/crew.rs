//! Threads and queues of a session: sends orders, receives deliveries, returns used buffers to the workers.

use super::commit::{Feed, FrameReport, commit, gather};
use super::cores::{cores, stay_on};
use super::error::{FrameError, StartError};
use super::handoff::{Delivery, FrameOrder, Hand, Task, Watch, queues};
use super::metrics::Laps;
use super::worker::{Stages, Worker};
use crate::frame::Reuse;
use crate::mesh::{Batch, MeshSink, Scene, TileMesh};
use crossbeam_channel::{Receiver, Sender};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{self, JoinHandle};

/// The work of one frame.
pub(super) enum Work {
    /// Everything that the workers own of the first `n` parts.
    All(usize),
    /// One hand per worker, each a subset of what it owns.
    Some(Vec<Hand>),
}

/// A frame in progress.
pub(super) struct FrameInFlight {
    frame: u64,
    /// By worker: whether it got an order and has to deliver.
    asked: Vec<bool>,
    pub(super) laps: Laps,
}

/// The workers of a session and the master's ends of their queues.
pub(super) struct Crew<S: Stages> {
    orders: Vec<Sender<FrameOrder<S::Plan>>>,
    deliveries: Vec<Receiver<Delivery>>,
    threads: Vec<JoinHandle<()>>,
    /// Used buffers of each worker, returned with its next order.
    spare: Vec<Vec<TileMesh>>,
    next_frame: u64,
    /// Earlier frames are cancelled. Written by the master, read by workers between tiles.
    wanted_from: Arc<AtomicU64>,
}

impl<S: Stages> Crew<S> {
    /// Starts one thread per hand. If the system refuses a thread, those already started end.
    pub(super) fn start(stages: &Arc<S>, hands: Vec<Hand>, reuse: Reuse, pin: bool) -> Result<Self, StartError> {
        let cores = if pin { cores() } else { Vec::new() };
        let mut crew = Self {
            orders: Vec::new(),
            deliveries: Vec::new(),
            threads: Vec::new(),
            spare: vec![Vec::new(); hands.len()],
            next_frame: 0,
            wanted_from: Arc::default(),
        };
        for (worker, hand) in hands.into_iter().enumerate() {
            let (order, end, delivery) = queues();
            #[allow(clippy::cast_possible_truncation, reason = "threads are fewer than 2^32")]
            let worker_state =
                Worker::new(worker as u32, Arc::clone(stages), hand, reuse, Arc::clone(&crew.wanted_from));
            let core = (!cores.is_empty()).then(|| cores[worker % cores.len()]);
            let thread = thread::Builder::new()
                .name(format!("trimtess-worker-{worker}"))
                .spawn(move || {
                    if let Some(core) = core {
                        stay_on(core);
                    }
                    worker_state.serve(&end);
                })
                .map_err(|cause| StartError { worker, cause })?;
            crew.orders.push(order);
            crew.deliveries.push(delivery);
            crew.threads.push(thread);
        }
        Ok(crew)
    }

    /// Number of workers.
    pub(super) fn len(&self) -> usize {
        self.threads.len()
    }

    /// Sends the plan to the workers that have something to do. With `timed`, they measure each tile.
    pub(super) fn give(
        &mut self,
        plan: &Arc<S::Plan>,
        work: Work,
        timed: bool,
        watch: &Watch,
    ) -> Result<FrameInFlight, FrameError> {
        let laps = Laps::start();
        let frame = self.next_frame;
        self.next_frame += 1;
        // Deliveries of cancelled frames would fill the queues, and then block the workers and the master.
        for delivery in self.deliveries.iter().flat_map(Receiver::try_iter) {
            drop(delivery);
        }
        let tasks: Vec<Task> = match work {
            Work::All(parts) => (0..self.len()).map(|_| Task::All(parts)).collect(),
            Work::Some(hands) => hands.into_iter().map(Task::Some).collect(),
        };
        let mut asked = vec![false; self.len()];
        for (worker, task) in tasks.into_iter().enumerate() {
            if matches!(&task, Task::Some(hand) if hand.is_empty()) {
                continue;
            }
            asked[worker] = true;
            let order = FrameOrder {
                frame,
                plan: Arc::clone(plan),
                task,
                timed,
                watch: watch.clone(),
                spare: std::mem::take(&mut self.spare[worker]),
            };
            self.orders[worker].send(order).map_err(|_| FrameError::WorkerLost { worker })?;
        }
        Ok(FrameInFlight { frame, asked, laps })
    }

    /// Whether all workers have delivered, so that [`take`](Self::take) does not wait.
    pub(super) fn is_made(&self, underway: &FrameInFlight) -> bool {
        let mut asked = self.deliveries.iter().zip(&underway.asked).filter(|(_, asked)| **asked);
        asked.all(|(queue, _)| !queue.is_empty())
    }

    /// Waits for all deliveries of a frame.
    pub(super) fn take(&mut self, underway: &FrameInFlight) -> Result<Vec<Delivery>, FrameError> {
        gather(&self.deliveries, &underway.asked, underway.frame)
    }

    /// Cancels all frames given so far. Workers stop after their current tile.
    pub(super) fn cancel(&self) {
        self.wanted_from.store(self.next_frame, Ordering::Relaxed);
    }

    /// Collects the buffers that a sink left in its batches, for the workers that filled them.
    pub(super) fn recycle(&mut self, batches: Vec<Batch>) {
        for Batch { worker, mut mesh, .. } in batches {
            if let Some(spare) = self.spare.get_mut(worker as usize)
                && mesh.positions.capacity() > 0
                && spare.len() < MOST_SPARE
            {
                mesh.clear();
                spare.push(mesh);
            }
        }
    }

    /// Makes a whole frame of the first `parts` parts and feeds it to the sink.
    pub(super) fn frame(
        &mut self,
        plan: &Arc<S::Plan>,
        parts: usize,
        (scene, watch): (&Scene, &Watch),
        sink: &mut dyn MeshSink,
    ) -> Result<FrameReport, FrameError> {
        let _span = tracing::debug_span!("frame", number = self.next_frame).entered();
        let mut underway = self.give(plan, Work::All(parts), false, watch)?;
        let deliveries = self.take(&underway)?;
        if watch.is_cancelled() {
            return Err(FrameError::Cancelled);
        }
        let (report, batches) = commit(deliveries, scene, Feed::All, sink, &mut underway.laps)?;
        self.recycle(batches);
        Ok(report)
    }

    pub(super) fn next_frame(&self) -> u64 {
        self.next_frame
    }

    #[cfg(test)]
    pub(super) fn hang_up_on(&mut self, worker: usize) {
        let (order, _, _) = queues();
        drop(std::mem::replace(&mut self.orders[worker], order));
    }
}

/// Most spare buffers per worker: enough for a frame of a moving camera, far fewer than the first frame filled.
const MOST_SPARE: usize = 256;

impl<S: Stages> Drop for Crew<S> {
    fn drop(&mut self) {
        // Hanging up both queues ends every worker after its current tile.
        self.cancel();
        self.orders.clear();
        self.deliveries.clear();
        for thread in self.threads.drain(..) {
            // A panic of the thread was already reported, by the frame that missed its delivery.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::handoff::FaceRung;
    use super::*;
    use crate::frame::internals::TileOutcome;
    use crate::frame::{Degradation, Rung};
    use crate::mesh::{EdgeLine, MemorySink, SinkError};
    use crate::model::TileId;
    use crate::model::{EdgeId, FaceId, PartId};
    use glam::DVec3;
    use std::sync::atomic::AtomicU32;

    /// Stands in for a prepared model: one triangle per tile, whose position encodes the tile and the plan.
    struct Fake {
        panics_at: Option<u32>,
        made: AtomicU32,
    }

    impl Stages for Fake {
        type Plan = f64;
        type Scratch = u32;
        type Cache = ();

        fn reuse(_: &mut u32, _: TileMesh) {}

        fn tile(&self, plan: &f64, _: PartId, tile: TileId, scratch: &mut u32) -> TileOutcome {
            *scratch += 1;
            self.made.fetch_add(1, Ordering::Relaxed);
            assert!(self.panics_at != Some(tile.0), "tile {} is bad", tile.0);
            let x = f64::from(tile.0);
            let positions = vec![DVec3::new(x, *plan, 0.0), DVec3::X, DVec3::Y];
            let mesh = TileMesh { positions, triangles: vec![[0, 1, 2]], ..TileMesh::default() };
            TileOutcome {
                face: FaceId(tile.0 / 2),
                mesh,
                rung: Rung::Normal,
                degradation: None,
                slivers: 0,
                rewound: 0.0,
            }
        }

        fn update(
            &self,
            plan: &f64,
            (part, tile): (PartId, TileId),
            _: Reuse,
            (): &mut (),
            scratch: &mut u32,
        ) -> (TileOutcome, usize) {
            (self.tile(plan, part, tile, scratch), 0)
        }

        fn fill(&self, _: &f64, _: PartId, tile: TileId, why: String) -> TileOutcome {
            TileOutcome::lost(FaceId(tile.0 / 2), why)
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
        let crew = Crew::start(&fake, hands, Reuse::NONE, false).unwrap();
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
                let report = crew.frame(&Arc::new(plan), 9, (&Scene::default(), &Watch::default()), &mut sink).unwrap();
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
                let report = crew.frame(&Arc::new(1.0), 9, (&Scene::default(), &Watch::default()), &mut sink).unwrap();
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

    /// Refuses call number `at` and panics if a call other than `abort` follows.
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
            let error = crew.frame(&Arc::new(1.0), 9, (&Scene::default(), &Watch::default()), &mut sink).unwrap_err();
            assert_eq!(error.to_string(), "disk: full");
            assert_eq!((sink.calls, sink.aborts, sink.ends), (at, 1, usize::from(at == calls)));
        }
        let report =
            crew.frame(&Arc::new(1.0), 9, (&Scene::default(), &Watch::default()), &mut MemorySink::default()).unwrap();
        assert_eq!((report.frame, report.batches), (4, TILES as usize));
    }

    #[test]
    fn a_lost_worker_is_an_error_and_dropping_the_session_ends_all_threads() {
        let (fake, mut crew) = start(None, 2);
        // Hanging up its orders ends the worker's thread, as a crash outside a tile would.
        crew.hang_up_on(1);
        let error = crew
            .frame(&Arc::new(1.0), 9, (&Scene::default(), &Watch::default()), &mut MemorySink::default())
            .unwrap_err();
        assert!(matches!(error, FrameError::WorkerLost { worker: 1 }), "{error}");
        drop(crew);
        assert_eq!(Arc::strong_count(&fake), 1, "a worker outlived its session");
    }
}
