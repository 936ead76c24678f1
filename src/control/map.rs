//! Loops of frames: the caller makes the calls, and threads that have time join in. Nobody waits for a job that has not
//! begun.

use super::jobs::{Jobs, Priority, width};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Calls `work` with each item, and returns its results in order. The caller works, and so do those threads of `jobs`
/// that have time.
///
/// `work` must not wait for other jobs. Then the caller waits only for calls in progress, and cannot deadlock. `work`
/// is dropped before this returns, so what it shares has one owner again. A panic of `work` reaches the caller.
pub(crate) fn map<I, R>(jobs: &dyn Jobs, items: Vec<I>, work: impl Fn(I) -> R + Send + Sync + 'static) -> Vec<R>
where
    I: Send + 'static,
    R: Send + 'static,
{
    map_with(jobs, &mut Vec::<()>::new(), items, move |(), item| work(item))
}

/// As [`map`], where each thread has a work space: `spaces` has one for each thread that ever took part, made when it
/// first does. Results must not depend on them. A call that panics drops them.
pub(crate) fn map_with<S, I, R>(
    jobs: &dyn Jobs,
    spaces: &mut Vec<S>,
    items: Vec<I>,
    work: impl Fn(&mut S, I) -> R + Send + Sync + 'static,
) -> Vec<R>
where
    S: Default + Send + 'static,
    I: Send + 'static,
    R: Send + 'static,
{
    let _span = tracing::trace_span!("loop", calls = items.len()).entered();
    let helpers = width(jobs).min(items.len()).saturating_sub(1);
    if spaces.len() <= helpers {
        spaces.resize_with(helpers + 1, S::default);
    }
    if helpers == 0 {
        let space = &mut spaces[0];
        let call = |item| tracing::trace_span!("call").in_scope(|| work(space, item));
        return items.into_iter().map(call).collect();
    }
    let slots = items.into_iter().map(|item| Mutex::new(Slot::Waiting(item))).collect();
    let theirs = std::mem::take(spaces).into_iter().map(Mutex::new).collect();
    let (next, entered) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let calls = Arc::new(Calls { slots, next, spaces: theirs, entered, work });
    let door = Arc::new(Door::to(&calls));
    for _ in 0..helpers {
        let door = Arc::clone(&door);
        jobs.spawn(Priority::Helper, Box::new(move || door.help()));
    }
    let ended = catch_unwind(AssertUnwindSafe(|| calls.make()));
    let theirs = door.close();
    if let Some(panic) = ended.err().or(theirs) {
        resume_unwind(panic);
    }
    let calls = Arc::into_inner(calls).expect("all helpers have left");
    spaces.extend(calls.spaces.into_iter().map(|space| space.into_inner().unwrap_or_else(PoisonError::into_inner)));
    let results = calls.slots.into_iter().map(|slot| match slot.into_inner() {
        Ok(Slot::Done(result)) => result,
        _ => unreachable!("a call that neither ended nor panicked"),
    });
    results.collect()
}

/// Drops values on threads of `jobs`, without waiting for that. A pool that drops the jobs drops these, too.
pub(crate) fn drop_later<T: Send + 'static>(jobs: &dyn Jobs, values: Vec<T>) {
    /// Jobs of a thread. A frame that begins meanwhile waits for one of them.
    const SHARES: usize = 16;
    let size = values.len().div_ceil(SHARES * width(jobs));
    let shares = chunks(jobs, values, size).into_iter();
    shares.for_each(|share| jobs.spawn(Priority::Free, Box::new(move || drop(share))));
}

/// Items in lists of `size`, for [`map`]; all in one if there is one thread.
pub(crate) fn chunks<I>(jobs: &dyn Jobs, mut items: Vec<I>, size: usize) -> Vec<Vec<I>> {
    if items.is_empty() {
        return Vec::new();
    }
    if width(jobs) == 1 || items.len() <= size {
        return vec![items];
    }
    let mut lists = Vec::with_capacity(items.len().div_ceil(size));
    // From the end: each item moves once, in one copy of its list.
    while items.len() > size {
        lists.push(items.split_off((items.len() - 1) / size * size));
    }
    lists.push(items);
    lists.reverse();
    lists
}

/// The calls of a loop. Each is made by one thread.
struct Calls<S, I, R, F> {
    slots: Vec<Mutex<Slot<I, R>>>,
    /// The first one that nobody has begun.
    next: AtomicUsize,
    /// At least one for each thread that may enter.
    spaces: Vec<Mutex<S>>,
    /// Threads that have entered.
    entered: AtomicUsize,
    work: F,
}

/// An item, then its result.
pub(super) enum Slot<I, R> {
    Waiting(I),
    /// In work, or its call panicked.
    Begun,
    Done(R),
}

impl<I, R> Slot<I, R> {
    /// Makes the result, unless that was done.
    pub(super) fn fill(&mut self, work: impl FnOnce(I) -> R) {
        *self = match std::mem::replace(self, Self::Begun) {
            Self::Waiting(item) => Self::Done(work(item)),
            other => other,
        };
    }

    /// The result, made here if a pool left it out.
    pub(super) fn result(self, work: impl FnOnce(I) -> R) -> R {
        match self {
            Self::Waiting(item) => work(item),
            Self::Done(result) => result,
            Self::Begun => unreachable!("a panic was passed on"),
        }
    }
}

/// Makes calls until all have begun.
trait Make {
    fn make(&self);
}

impl<S, I, R, F: Fn(&mut S, I) -> R> Make for Calls<S, I, R, F> {
    fn make(&self) {
        // No lock is waited for: each belongs to whoever took the number.
        let Some(space) = self.spaces.get(self.entered.fetch_add(1, Ordering::Relaxed)) else { return };
        let space = &mut *lock(space);
        while let Some(slot) = self.slots.get(self.next.fetch_add(1, Ordering::Relaxed)) {
            let _span = tracing::trace_span!("call").entered();
            lock(slot).fill(|item| (self.work)(space, item));
        }
    }
}

/// Lets helpers in to the calls of a loop, and tells when all have left.
struct Door<C> {
    inside: Mutex<Inside<C>>,
    left: Condvar,
}

struct Inside<C> {
    /// `None` once the door is closed.
    calls: Option<Arc<C>>,
    helpers: usize,
    panic: Option<Box<dyn Any + Send>>,
}

impl<C: Make> Door<C> {
    fn to(calls: &Arc<C>) -> Self {
        let inside = Inside { calls: Some(Arc::clone(calls)), helpers: 0, panic: None };
        Self { inside: Mutex::new(inside), left: Condvar::new() }
    }

    fn help(&self) {
        let calls = {
            let mut inside = lock(&self.inside);
            let Some(calls) = inside.calls.clone() else { return };
            inside.helpers += 1;
            calls
        };
        let ended = catch_unwind(AssertUnwindSafe(|| calls.make()));
        // Before the caller hears of it, who wants to be the only owner.
        drop(calls);
        let mut inside = lock(&self.inside);
        inside.helpers -= 1;
        inside.panic = inside.panic.take().or(ended.err());
        self.left.notify_one();
    }

    /// Waits until all helpers have left. Returns the first panic.
    fn close(&self) -> Option<Box<dyn Any + Send>> {
        let mut inside = lock(&self.inside);
        inside.calls = None;
        while inside.helpers > 0 {
            inside = self.left.wait(inside).unwrap_or_else(PoisonError::into_inner);
        }
        inside.panic.take()
    }
}

pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::super::jobs::{Alone, Job};
    use super::*;
    use std::thread;
    use std::time::{Duration, Instant};

    /// Has no thread, runs jobs at once, drops them, or gives each a thread.
    enum Odd {
        None,
        AtOnce,
        Drops,
        Threads,
    }

    impl Jobs for Odd {
        fn width(&self) -> usize {
            if matches!(self, Self::None) { 0 } else { 4 }
        }

        fn spawn(&self, _: Priority, job: Job) {
            match self {
                Self::AtOnce => job(),
                Self::None | Self::Drops => {}
                Self::Threads => drop(thread::spawn(job)),
            }
        }
    }

    fn pools() -> [Box<dyn Jobs>; 5] {
        let odd = |pool: Odd| -> Box<dyn Jobs> { Box::new(pool) };
        [Box::new(Alone), odd(Odd::None), odd(Odd::AtOnce), odd(Odd::Drops), odd(Odd::Threads)]
    }

    #[test]
    fn values_are_dropped_whatever_becomes_of_the_jobs() {
        for jobs in pools() {
            for count in [0, 1, 7, 1000] {
                let owned = Arc::new(());
                drop_later(&*jobs, vec![Arc::clone(&owned); count]);
                let start = Instant::now();
                while Arc::strong_count(&owned) > 1 && start.elapsed() < Duration::from_secs(60) {
                    thread::yield_now();
                }
                assert_eq!(Arc::strong_count(&owned), 1, "{count}");
            }
        }
    }

    #[test]
    fn every_item_is_done_once_and_results_are_in_order() {
        for jobs in pools() {
            for count in [0_u32, 1, 7, 8, 9, 100] {
                let shared = Arc::new(1000);
                let theirs = Arc::clone(&shared);
                let made = map(&*jobs, (0..count).collect(), move |k: u32| *theirs + k);
                assert!(made.iter().copied().eq(1000..1000 + count), "{made:?}");
                assert_eq!(Arc::into_inner(shared), Some(1000));
                // Each thread counts its calls.
                let mut counts = vec![0_u32; 2];
                for _ in 0..2 {
                    map_with(&*jobs, &mut counts, made.clone(), |calls: &mut u32, _| *calls += 1);
                }
                assert_eq!(counts.iter().sum::<u32>(), 2 * count);
                assert!(counts.len() <= jobs.width().max(2));
                assert_eq!(chunks(&*jobs, made.clone(), 8).concat(), made);
            }
        }
    }

    #[test]
    fn a_panic_reaches_the_caller() {
        for jobs in pools() {
            let bad = |k: u32| {
                thread::sleep(Duration::from_millis(1));
                assert!(k != 5, "bad");
            };
            let ended = catch_unwind(AssertUnwindSafe(|| map(&*jobs, (0..9).collect(), bad)));
            assert_eq!(ended.expect_err("a panic").downcast_ref(), Some(&"bad"));
        }
    }
}
