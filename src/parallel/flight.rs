//! Work that runs somewhere else, its orders and its result. Whoever needs the result does the work, if no thread has
//! begun it: so nobody waits for a thread that is itself waiting. Whoever waits helps meanwhile.

use crate::control::{Helpers, Jobs, Priority};
use crate::prepare::internals::panic_message;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// What has become of work. The lock of one is held for as long as it takes to look, never while work runs.
enum Stage<T> {
    Unclaimed(Box<dyn FnOnce() -> T + Send>),
    Running,
    /// With the message of a panic instead, if it panicked.
    Landed(Result<T, String>),
}

/// Work and its result.
struct Slot<T> {
    stage: Mutex<Stage<T>>,
    /// The helpers that the work spawns.
    helpers: Arc<Helpers>,
}

impl<T> Slot<T> {
    fn lock(&self) -> MutexGuard<'_, Stage<T>> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does the work, if nobody has begun it.
    fn claim(&self) {
        let mut stage = self.lock();
        if !matches!(*stage, Stage::Unclaimed(_)) {
            return;
        }
        let claimed = std::mem::replace(&mut *stage, Stage::Running);
        drop(stage);
        if let Stage::Unclaimed(work) = claimed {
            let result = catch_unwind(AssertUnwindSafe(work)).map_err(|payload| panic_message(&*payload));
            *self.lock() = Stage::Landed(result);
            self.helpers.look_again();
        }
    }

    fn has_landed(&self) -> bool {
        matches!(*self.lock(), Stage::Landed(_))
    }

    /// Waits for the result, which is there once, and helps meanwhile.
    fn take(&self) -> Result<T, String> {
        self.helpers.help_until(|| self.has_landed());
        match std::mem::replace(&mut *self.lock(), Stage::Running) {
            Stage::Landed(result) => result,
            Stage::Unclaimed(_) | Stage::Running => Err("a result that was taken".into()),
        }
    }
}

/// Work on its way.
pub(super) struct Flight<T>(Arc<Slot<T>>);

impl<T: Send + 'static> Flight<T> {
    /// Keeps `work` until [`spawn`](Self::spawn) or [`land`](Self::land). `helpers`: those that it spawns.
    pub(super) fn of(helpers: &Arc<Helpers>, work: impl FnOnce() -> T + Send + 'static) -> Self {
        let (stage, helpers) = (Mutex::new(Stage::Unclaimed(Box::new(work))), Arc::clone(helpers));
        Self(Arc::new(Slot { stage, helpers }))
    }

    /// Spawns the work on `jobs`, unless they have it or someone has begun it.
    pub(super) fn spawn(&self, jobs: &dyn Jobs) {
        if Arc::strong_count(&self.0) == 1 && matches!(*self.0.lock(), Stage::Unclaimed(_)) {
            let theirs = Arc::clone(&self.0);
            jobs.spawn(Priority::Frame, Box::new(move || theirs.claim()));
        }
    }

    /// Whether [`land`](Self::land) would return at once. Spawns the work again if `jobs` have dropped it: whoever only
    /// asks would wait for ever.
    pub(super) fn has_landed(&self, jobs: &dyn Jobs) -> bool {
        self.spawn(jobs);
        self.0.has_landed()
    }

    /// As [`has_landed`](Self::has_landed), after waiting at most so long. Does no work.
    pub(super) fn lands_within(&self, jobs: &dyn Jobs, at_most: Duration) -> bool {
        self.has_landed(jobs) || self.0.helpers.wait_until(|| self.0.has_landed(), at_most)
    }

    /// The result. Does the work here if no thread has begun it, else helps. The message of a panic instead, if it
    /// panicked.
    pub(super) fn land(self) -> Result<T, String> {
        self.0.claim();
        self.0.take()
    }
}

/// Orders for work on its way, which serves them one after the other.
pub(super) struct Orders<T>(Mutex<(bool, VecDeque<T>)>);

impl<T> Orders<T> {
    /// No work is on its way.
    pub(super) fn new() -> Self {
        Self(Mutex::new((false, VecDeque::new())))
    }

    fn lock(&self) -> MutexGuard<'_, (bool, VecDeque<T>)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an order. Returns whether work is on its way that will serve it. Otherwise new work has to begin.
    pub(super) fn add(&self, order: T) -> bool {
        let (is_open, orders) = &mut *self.lock();
        orders.push_back(order);
        std::mem::replace(is_open, true)
    }

    /// Takes the next order. `None` closes the queue: the work must end, and the next order begins new work.
    pub(super) fn next(&self) -> Option<T> {
        let (is_open, orders) = &mut *self.lock();
        let next = orders.pop_front();
        *is_open = next.is_some();
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{Alone, Job, Threads};

    fn start<T: Send + 'static>(jobs: &dyn Jobs, work: impl FnOnce() -> T + Send + 'static) -> Flight<T> {
        let flight = Flight::of(&Arc::default(), work);
        flight.spawn(jobs);
        flight
    }

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
        for jobs in [&Alone as &dyn Jobs, &Threads::start(2).expect("threads")] {
            assert_eq!(start(jobs, || 7).land(), Ok(7));
            assert_eq!(Flight::of(&Arc::default(), || 7).land(), Ok(7));
        }
        for keeps in [true, false] {
            let jobs = Holding(Mutex::default(), keeps);
            let flight = start(&jobs, || 7);
            assert!(!flight.has_landed(&jobs) && !flight.lands_within(&jobs, Duration::from_millis(1)));
            assert_eq!(flight.land(), Ok(7));
            let kept = jobs.0.into_inner().expect("no panic");
            assert_eq!(kept.len(), usize::from(keeps));
            kept.into_iter().for_each(|late| late());
        }
    }

    #[test]
    fn work_that_was_dropped_is_spawned_again_by_whoever_asks() {
        let flight = start(&Holding(Mutex::default(), false), || 7);
        assert!(flight.has_landed(&Alone));
        assert_eq!(flight.land(), Ok(7));
    }

    #[test]
    fn work_on_its_way_serves_all_orders() {
        let orders = Orders::new();
        assert!(!orders.add(1) && orders.add(2));
        assert_eq!([orders.next(), orders.next(), orders.next()], [Some(1), Some(2), None]);
        assert!(!orders.add(3));
        assert_eq!(orders.next(), Some(3));
    }

    #[test]
    fn what_was_waited_for_lands_once() {
        let flight = start(&Alone, || 7);
        for _ in 0..2 {
            assert!(flight.lands_within(&Alone, Duration::ZERO) && flight.has_landed(&Alone));
        }
        assert_eq!(flight.land(), Ok(7));
    }

    #[test]
    fn a_job_may_wait_for_one_of_its_own_pool() {
        let jobs = Arc::new(Threads::start(1).expect("a thread"));
        let inner = Arc::clone(&jobs);
        assert_eq!(start(&*jobs, move || start(&*inner, || 7).land()).land(), Ok(Ok(7)));
    }

    #[test]
    fn a_panic_is_told() {
        let jobs = Threads::start(1).expect("a thread");
        let landed = start(&jobs, || assert!(std::hint::black_box(false), "told")).land();
        assert_eq!(landed, Err("told".into()));
    }
}
