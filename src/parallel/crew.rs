//! The workers of a session: each makes its own tiles, on whichever thread is free.

use super::handoff::{Delivery, Hand};
use super::seats::Seats;
use super::worker::{Order, Stages, Worker};
use crate::control::{Jobs, map_with};
use crate::mesh::WrittenTile;
use std::cmp::Reverse;
use std::sync::Arc;
use std::time::Duration;

/// What each worker has to make in a frame.
pub(super) enum Work {
    /// Everything that it owns of the first `n` parts.
    All(usize),
    /// Its hand of these, a subset of what it owns; and whether to measure each tile.
    Some(Vec<Hand>, bool),
}

/// The workers of a session.
pub(super) struct Crew<S: Stages> {
    stages: Arc<S>,
    /// What each worker owns.
    hands: Arc<Vec<Hand>>,
    /// How long each worker took in the last frame of everything.
    took: Vec<Duration>,
    /// Of each thread, whichever workers it runs: what was used last is in its caches.
    // Boxed: they are large, and move to threads and back.
    #[allow(clippy::vec_box, reason = "see above")]
    scratches: Vec<Box<S::Scratch>>,
    seats: Seats,
}

impl<S: Stages> Crew<S> {
    /// One worker per hand.
    pub(super) fn of(stages: &Arc<S>, hands: Vec<Hand>) -> Self {
        Self {
            stages: Arc::clone(stages),
            took: vec![Duration::ZERO; hands.len()],
            scratches: Vec::new(),
            seats: Seats::of(&hands),
            hands: Arc::new(hands),
        }
    }

    /// Replaces what the stages work on by the same with more parts.
    pub(super) fn set_stages(&mut self, stages: &Arc<S>) {
        self.stages = Arc::clone(stages);
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
        order: Order<S::Plan>,
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
        let stages = Arc::clone(&self.stages);
        let with_list = |worker: usize| (worker, lists.get_mut(worker).map(std::mem::take).unwrap_or_default());
        let busy = busy.into_iter().map(with_list).collect();
        let make = move |scratch: &mut Box<S::Scratch>, (worker, list): (usize, Vec<WrittenTile>)| {
            let mut at_work = Worker { number: worker as u32, stages: &*stages, scratch: &mut **scratch };
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

#[cfg(test)]
mod tests {
    use super::super::commit::{Feed, FrameReport, Rows, commit};
    use super::super::error::FrameError;
    use super::super::handoff::{FaceRung, Watch};
    use super::*;
    use crate::control::{Control, Threads};
    use crate::frame::internals::TileOutcome;
    use crate::frame::{Degradation, Rung};
    use crate::mesh::{Batch, EdgeLine, MemorySink, MeshLists, MeshSink, Scene, SinkError, TileMesh};
    use crate::model::TileId;
    use crate::model::{EdgeId, FaceId, PartId};
    use glam::DVec3;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// Stands in for a prepared model: one triangle per tile, whose position encodes the tile and the plan.
    struct Fake {
        panics_at: Option<u32>,
        made: AtomicU32,
    }

    impl Stages for Fake {
        type Plan = f64;
        type Scratch = u32;

        fn reuse(_: &mut u32, _: TileMesh) {}

        fn tile(&self, plan: &f64, (_, tile): (PartId, TileId), _: MeshLists, scratch: &mut u32) -> TileOutcome {
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

        fn chord(plan: &f64, _: PartId, _: TileId) -> f64 {
            *plan
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

    struct FakeSession {
        jobs: Threads,
        crew: Crew<Fake>,
    }

    impl FakeSession {
        fn frame(&mut self, plan: f64, sink: &mut dyn MeshSink) -> Result<FrameReport, FrameError> {
            let order = Order { plan: Arc::new(plan), watch: Watch::default(), writer: None, lists: MeshLists::ALL };
            let made = self.crew.make(&self.jobs, order, Work::All(9), &mut []);
            let mut rows = Rows::default();
            let seats = self.crew.seats();
            let feed = Feed::All(&Control::default(), seats);
            commit((made, seats.of_first(9)), (&Scene::default(), None), feed, (&mut rows, sink))
        }
    }

    fn start(panics_at: Option<u32>, workers: u32) -> (Arc<Fake>, FakeSession) {
        let fake = Arc::new(Fake { panics_at, made: AtomicU32::new(0) });
        let mut hands = vec![Hand::default(); workers as usize];
        for k in 0..TILES {
            let hand = &mut hands[(k * 7 % workers) as usize];
            hand.tiles.push((PartId(k / 20), TileId(k), FaceId(k / 2)));
            hand.edges.push((PartId(k / 20), EdgeId(k)));
        }
        let crew = Crew::of(&fake, hands);
        (fake, FakeSession { jobs: Threads::start(3).unwrap(), crew })
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
                let report = crew.frame(plan, &mut sink).unwrap();
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
                let report = crew.frame(1.0, &mut sink).unwrap();
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
                return Err(SinkError::new("disk", std::io::Error::other("full")));
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
            let error = crew.frame(1.0, &mut sink).unwrap_err();
            assert_eq!(error.to_string(), "disk: full");
            assert_eq!((sink.calls, sink.aborts, sink.ends), (at, 1, usize::from(at == calls)));
        }
        let report = crew.frame(1.0, &mut MemorySink::default()).unwrap();
        assert_eq!(report.batches, TILES as usize);
    }
}
