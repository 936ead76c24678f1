//! Jobs that help with a frame, for the threads of a pool and for whoever waits for the frame.

use super::jobs::{Job, Jobs, Priority};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A pool whose helpers ([`Priority::Helper`]) are in a list, too. The pool gets a ticket for each, and a thread that
/// waits for a frame takes them without one.
pub(crate) struct WithHelpers {
    pool: Arc<dyn Jobs>,
    helpers: Arc<Helpers>,
}

impl WithHelpers {
    pub(crate) fn of(pool: Arc<dyn Jobs>) -> Self {
        Self { pool, helpers: Arc::default() }
    }

    pub(crate) fn helpers(&self) -> &Arc<Helpers> {
        &self.helpers
    }
}

impl Jobs for WithHelpers {
    fn width(&self) -> usize {
        self.pool.width()
    }

    fn spawn(&self, priority: Priority, job: Job) {
        match priority {
            Priority::Helper => {
                let ticket = self.helpers.add(job);
                self.pool.spawn(priority, Box::new(move || ticket.redeem()));
            }
            // Who waits for a frame does not free what the one before left.
            Priority::Frame | Priority::Free => self.pool.spawn(priority, job),
        }
    }

    fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
        self.pool.for_each(count, body);
    }
}

/// Helpers that nobody has begun. Never more than tickets.
#[derive(Default)]
pub(crate) struct Helpers {
    list: Mutex<List>,
    changed: Condvar,
}

#[derive(Default)]
struct List {
    /// The newest last. It is begun first: a loop that has ended leaves helpers with nothing to do.
    jobs: Vec<Job>,
    /// Threads in [`Helpers::help_until`] that wait for a job.
    sleeping: usize,
}

impl Helpers {
    fn lock(&self) -> MutexGuard<'_, List> {
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(self: &Arc<Self>, job: Job) -> Ticket {
        let mut list = self.lock();
        list.jobs.push(job);
        // A wake-up is a system call even if no thread sleeps.
        if list.sleeping > 0 {
            self.changed.notify_all();
        }
        Ticket(Some(Arc::clone(self)))
    }

    fn take(&self) -> Option<Job> {
        self.lock().jobs.pop()
    }

    /// Runs helpers until `is_over`, and waits while there are none. Whoever makes it true calls
    /// [`look_again`](Self::look_again) afterwards. Helpers do not panic: a loop keeps the panics of its calls.
    pub(crate) fn help_until(&self, is_over: impl Fn() -> bool) {
        let mut list = self.lock();
        while !is_over() {
            if let Some(job) = list.jobs.pop() {
                drop(list);
                job();
                list = self.lock();
            } else {
                list.sleeping += 1;
                list = self.changed.wait(list).unwrap_or_else(PoisonError::into_inner);
                list.sleeping -= 1;
            }
        }
    }

    /// As [`help_until`](Self::help_until), for at most so long, and without help. Returns whether it is over.
    pub(crate) fn wait_until(&self, is_over: impl Fn() -> bool, at_most: Duration) -> bool {
        let waited = self.changed.wait_timeout_while(self.lock(), at_most, |_| !is_over());
        !waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }

    /// Wakes the waiting threads, which check again.
    pub(crate) fn look_again(&self) {
        // A thread between its check and its sleep holds this lock, so it misses no wake-up.
        let _list = self.lock();
        self.changed.notify_all();
    }
}

/// A claim to one job of a list, if any is left. Dropping it drops a job.
struct Ticket(Option<Arc<Helpers>>);

impl Ticket {
    fn redeem(mut self) {
        if let Some(job) = self.0.take().and_then(|helpers| helpers.take()) {
            job();
        }
    }
}

impl Drop for Ticket {
    fn drop(&mut self) {
        drop(self.0.take().and_then(|helpers| helpers.take()));
    }
}

#[cfg(test)]
mod tests {
    use super::super::map::drop_later;
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc;
    use std::thread;

    /// Keeps tickets.
    #[derive(Default)]
    struct Holding(Mutex<Vec<Job>>);

    impl Jobs for Holding {
        fn width(&self) -> usize {
            2
        }

        fn spawn(&self, _: Priority, job: Job) {
            self.0.lock().expect("no panic").push(job);
        }
    }

    #[test]
    fn helpers_are_begun_once_by_the_pool_or_by_who_waits() {
        let pool = Arc::new(Holding::default());
        let (helped, done) = (WithHelpers::of(Arc::<Holding>::clone(&pool)), Arc::new(AtomicUsize::new(0)));
        let spawn = |count: usize| {
            for _ in 0..count {
                let done = Arc::clone(&done);
                helped.spawn(Priority::Helper, Box::new(move || _ = done.fetch_add(1, Ordering::Relaxed)));
            }
        };
        let tickets = || std::mem::take(&mut *pool.0.lock().expect("no panic"));
        let count = || done.load(Ordering::Relaxed);
        spawn(5);
        helped.helpers().help_until(|| count() == 2);
        // Three are left, one of which is dropped. Two tickets have nothing to do.
        let mut held = tickets();
        drop(held.pop());
        assert_eq!((held.len(), count()), (4, 2));
        held.into_iter().for_each(|ticket| ticket());
        assert_eq!(count(), 4);
        // Others are for the pool alone.
        helped.spawn(Priority::Frame, Box::new(|| ()));
        drop_later(&helped, vec![0; 64]);
        assert!(helped.helpers().take().is_none() && tickets().len() > 1);
    }

    #[test]
    fn dropped_tickets_leave_no_job() {
        let (pool, owned) = (Arc::new(Holding::default()), Arc::new(()));
        let helped = WithHelpers::of(Arc::<Holding>::clone(&pool));
        for _ in 0..3 {
            let owned = Arc::clone(&owned);
            helped.spawn(Priority::Helper, Box::new(move || drop(owned)));
        }
        pool.0.lock().expect("no panic").clear();
        assert_eq!(Arc::strong_count(&owned), 1);
        assert!(helped.helpers().take().is_none());
    }

    #[test]
    fn who_waits_hears_of_new_jobs_and_of_the_end() {
        let helped = Arc::new(WithHelpers::of(Arc::new(Holding::default())));
        let (ends, told) = (Arc::new(AtomicUsize::new(0)), mpsc::channel());
        let (theirs, seen) = (Arc::clone(&helped), Arc::clone(&ends));
        let waits = thread::spawn(move || theirs.helpers().help_until(|| seen.load(Ordering::Relaxed) > 0));
        for k in 0..100 {
            let tell = told.0.clone();
            helped.spawn(Priority::Helper, Box::new(move || tell.send(k).expect("an open channel")));
            assert_eq!(told.1.recv_timeout(Duration::from_secs(60)), Ok(k));
        }
        let is_over = || ends.load(Ordering::Relaxed) > 0;
        ends.store(1, Ordering::Relaxed);
        helped.helpers().look_again();
        waits.join().expect("no panic");
        assert!(helped.helpers().wait_until(is_over, Duration::ZERO));
        ends.store(0, Ordering::Relaxed);
        helped.spawn(Priority::Helper, Box::new(|| ()));
        assert!(!helped.helpers().wait_until(is_over, Duration::from_millis(1)));
        assert!(helped.helpers().take().is_some(), "who waits for a while does no work");
    }
}
