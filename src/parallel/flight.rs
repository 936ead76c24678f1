//! Work that runs somewhere else, and its result. Whoever needs the result does the work, if no thread has begun it: so
//! nobody waits for a thread that is itself waiting.

use crate::control::{Job, Jobs, Priority};
use crate::prepare::internals::panic_message;
use crossbeam_channel::{Receiver, bounded};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// The work until somebody begins it. The lock is held for as long as it takes to see who does.
type Unclaimed = Arc<Mutex<Option<Job>>>;

/// Work on its way.
pub(super) struct Flight<T> {
    unclaimed: Unclaimed,
    /// The message of a panic instead, if it panicked.
    result: Receiver<Result<T, String>>,
    /// The result, if somebody waited for it.
    landed: Option<Result<T, String>>,
}

impl<T: Send + 'static> Flight<T> {
    /// Starts `work` on `jobs`.
    pub(super) fn start(jobs: &dyn Jobs, work: impl FnOnce() -> T + Send + 'static) -> Self {
        let (send, result) = bounded(1);
        let job: Job = Box::new(move || {
            // Nobody may be left to hear of it.
            let _ = send.send(catch_unwind(AssertUnwindSafe(work)).map_err(|payload| panic_message(&*payload)));
        });
        let unclaimed = Arc::new(Mutex::new(Some(job)));
        let theirs = Arc::clone(&unclaimed);
        jobs.spawn(Priority::Frame, Box::new(move || claim(&theirs)));
        Self { unclaimed, result, landed: None }
    }

    /// Whether [`land`](Self::land) would return at once.
    pub(super) fn has_landed(&self) -> bool {
        self.landed.is_some() || !self.result.is_empty()
    }

    /// Waits at most so long, and tells whether [`land`](Self::land) would return at once. Does no work.
    pub(super) fn lands_within(&mut self, at_most: Duration) -> bool {
        if self.landed.is_none() {
            self.landed = self.result.recv_timeout(at_most).ok();
        }
        self.landed.is_some()
    }

    /// The result. Does the work here if no thread has begun it, else waits. The message of a panic instead, if it
    /// panicked.
    pub(super) fn land(self) -> Result<T, String> {
        if let Some(landed) = self.landed {
            return landed;
        }
        claim(&self.unclaimed);
        self.result.recv().unwrap_or_else(|gone| Err(gone.to_string()))
    }
}

fn claim(unclaimed: &Unclaimed) {
    let job = unclaimed.lock().unwrap_or_else(PoisonError::into_inner).take();
    if let Some(job) = job {
        job();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{Alone, Threads};

    /// Keeps jobs, or drops them.
    struct Holding(Mutex<Vec<Job>>, bool);

    impl Jobs for Holding {
        fn width(&self) -> usize {
            1
        }

        fn spawn(&self, _: Priority, job: Job) {
            if self.1 {
                self.0.lock().expect("no panic").push(job);
            }
        }
    }

    #[test]
    fn work_is_done_once_whoever_begins_it() {
        for jobs in [&Alone as &dyn Jobs, &Threads::start(2, false).expect("threads")] {
            assert_eq!(Flight::start(jobs, || 7).land(), Ok(7));
        }
        for keeps in [true, false] {
            let jobs = Holding(Mutex::default(), keeps);
            let mut flight = Flight::start(&jobs, || 7);
            assert!(!flight.has_landed() && !flight.lands_within(Duration::from_millis(1)));
            assert_eq!(flight.land(), Ok(7));
            jobs.0.into_inner().expect("no panic").into_iter().for_each(|late| late());
        }
    }

    #[test]
    fn what_was_waited_for_lands_once() {
        let mut flight = Flight::start(&Alone, || 7);
        for _ in 0..2 {
            assert!(flight.lands_within(Duration::ZERO) && flight.has_landed());
        }
        assert_eq!(flight.land(), Ok(7));
    }

    #[test]
    fn a_job_may_wait_for_one_of_its_own_pool() {
        let jobs = Arc::new(Threads::start(1, false).expect("a thread"));
        let inner = Arc::clone(&jobs);
        assert_eq!(Flight::start(&*jobs, move || Flight::start(&*inner, || 7).land()).land(), Ok(Ok(7)));
    }

    #[test]
    fn a_panic_is_told() {
        let jobs = Threads::start(1, false).expect("a thread");
        let landed = Flight::start(&jobs, || assert!(std::hint::black_box(false), "told")).land();
        assert_eq!(landed, Err("told".into()));
    }
}
