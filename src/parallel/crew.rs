//! The workers of a session: each makes its own tiles, on whichever thread is free.

use super::handoff::{Delivery, Hand};
use super::seats::Seats;
use super::worker::{Order, Worker};
use crate::control::{Jobs, map_with};
use crate::frame::internals::Scratch;
use crate::mesh::WrittenTile;
use crate::prepare::Prepared;
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
            seats: Seats::of(&hands),
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
