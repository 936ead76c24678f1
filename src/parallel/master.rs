//! Prepared model + worker count -> a session: tiles dealt once, plans broadcast, frames committed on the caller's thread.

use super::distribute::{Load, deal};
use super::handoff::{Delivery, Order, queues};
use super::metrics::Laps;
use super::render_thread::{FrameError, FrameReport, commit, gather};
use super::worker::{Hand, Stages, Worker};
use crate::mesh::{MeshSink, Scene};
use crossbeam::channel::{Receiver, Sender};
use std::fmt;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

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
