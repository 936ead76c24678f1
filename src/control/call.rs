//! A call that reads or prepares: its loops, and whether it goes on.

use super::jobs::{Jobs, width};
use super::map::{Slot, drop_later, lock};
use super::progress::Control;
use std::any::Any;
use std::cmp::Reverse;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Where a call works, and its caller's request to stop.
#[derive(Clone, Copy)]
pub(crate) struct Call<'a> {
    pub(crate) jobs: &'a dyn Jobs,
    pub(crate) control: &'a Control,
}

impl<'a> Call<'a> {
    pub(crate) fn new(jobs: &'a dyn Jobs, control: &'a Control) -> Self {
        Self { jobs, control }
    }

    /// Whether the caller asked to stop. Results then do not matter, and what is left of a loop can be skipped.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.control.is_cancelled()
    }

    /// `None` once the caller asked to stop.
    pub(crate) fn goes_on(&self) -> Option<()> {
        (!self.is_cancelled()).then_some(())
    }

    /// The items, until the caller asks to stop. Looks every 4096 items: for those that take nanoseconds.
    pub(crate) fn while_wanted<T>(self, items: impl Iterator<Item = T>) -> impl Iterator<Item = T> {
        const LOOK_EVERY: usize = 1 << 12;
        let wanted = move |(k, _): &(usize, T)| !k.is_multiple_of(LOOK_EVERY) || !self.is_cancelled();
        items.enumerate().take_while(wanted).map(|(_, item)| item)
    }

    /// What a loop made, one item after the other, until the caller asks to stop. Threads free the rest then.
    pub(crate) fn until_cancelled<T: Send + 'static>(self, made: Vec<T>) -> impl Iterator<Item = T> {
        let mut rest = made.into_iter();
        std::iter::from_fn(move || {
            if self.is_cancelled() {
                drop_later(self.jobs, rest.by_ref().collect());
            }
            rest.next()
        })
    }

    /// Calls `work` with each item, and returns its results in order. Items are begun in order. A thread takes `share`
    /// items at a time: one, if each takes longer than a few microseconds.
    ///
    /// `work` may call this again. A panic of `work` reaches the caller, after all threads have left.
    pub(crate) fn each<I, R>(
        &self,
        share: usize,
        items: impl IntoIterator<Item = I>,
        work: impl Fn(I) -> R + Sync,
    ) -> Vec<R>
    where
        I: Send,
        R: Send,
    {
        if width(self.jobs) == 1 {
            return items.into_iter().map(work).collect();
        }
        // Results replace their items, and the vector of results the one of slots, so there is no second list.
        let mut slots: Vec<Slot<I, R>> = items.into_iter().map(Slot::Waiting).collect();
        if slots.len() > share {
            let shares: Vec<Mutex<&mut [Slot<I, R>]>> = slots.chunks_mut(share).map(Mutex::new).collect();
            let panic: Mutex<Option<Box<dyn Any + Send>>> = Mutex::default();
            // Whatever call comes first takes the first share: pools make calls in any order.
            let next = AtomicUsize::new(0);
            self.jobs.for_each(shares.len(), &|_| {
                let Some(share) = shares.get(next.fetch_add(1, Ordering::Relaxed)) else { return };
                let fill = || lock(share).iter_mut().for_each(|slot| slot.fill(&work));
                if let Err(payload) = catch_unwind(AssertUnwindSafe(fill)) {
                    lock(&panic).get_or_insert(payload);
                }
            });
            if let Some(payload) = panic.into_inner().unwrap_or_else(PoisonError::into_inner) {
                resume_unwind(payload);
            }
        }
        slots.into_iter().map(|slot| slot.result(&work)).collect()
    }

    /// As [`each`](Self::each), one item at a time, the largest first: what a thread begins last is short, so all end
    /// at about the same time.
    pub(crate) fn each_by_size<I: Send, R: Send>(
        &self,
        items: impl IntoIterator<Item = I>,
        size: impl Fn(&I) -> usize,
        work: impl Fn(I) -> R + Sync,
    ) -> Vec<R> {
        if width(self.jobs) == 1 {
            return self.each(1, items, work);
        }
        let mut items: Vec<(usize, I)> = items.into_iter().enumerate().collect();
        items.sort_by_key(|(_, item)| Reverse(size(item)));
        let mut made = self.each(1, items, |(k, item)| (k, work(item)));
        made.sort_unstable_by_key(|(k, _)| *k);
        made.into_iter().map(|(_, result)| result).collect()
    }

    /// Makes both calls, on two threads if there are, and returns their results. The first should be the longer one.
    pub(crate) fn both<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        let (mut of_a, mut of_b) = (None, None);
        let calls: [Box<dyn FnOnce() + Send + '_>; 2] = [Box::new(|| of_a = Some(a())), Box::new(|| of_b = Some(b()))];
        self.each(1, calls, |call| call());
        (of_a.expect("was called"), of_b.expect("was called"))
    }

    /// Frees items on all threads.
    pub(crate) fn discard<T: Send>(&self, items: Vec<T>) {
        self.each(16, items, drop);
    }
}

#[cfg(test)]
mod tests {
    use super::super::jobs::{Alone, Job, Priority, Rayon, Threads};
    use super::*;
    use std::sync::Arc;
    use std::thread;

    /// Makes some calls twice and leaves others out, or gives each a thread.
    enum Odd {
        Careless,
        Threads,
    }

    impl Jobs for Odd {
        fn width(&self) -> usize {
            4
        }

        fn spawn(&self, _: Priority, job: Job) {
            job();
        }

        fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
            match self {
                Self::Careless => (0..count).rev().filter(|k| k % 3 > 0).for_each(|k| (0..k % 3).for_each(|_| body(k))),
                Self::Threads => thread::scope(|scope| (0..count).for_each(|k| drop(scope.spawn(move || body(k))))),
            }
        }
    }

    fn pools() -> [Box<dyn Jobs>; 6] {
        let threads = |count| Box::new(Threads::start(count).expect("threads"));
        [Box::new(Alone), Box::new(Odd::Careless), Box::new(Odd::Threads), threads(1), threads(3), Box::new(Rayon)]
    }

    #[test]
    fn every_item_is_done_once_and_results_are_in_order() {
        let control = Control::default();
        for jobs in pools() {
            let call = Call::new(&*jobs, &control);
            for (count, share) in [(0, 1), (1, 1), (7, 8), (9, 8), (100, 8), (100, 1)] {
                let mut seen = vec![0; count];
                let made = call.each(share, seen.iter_mut().enumerate(), |(k, seen)| {
                    *seen += 1;
                    call.each(1, 0..k, |j| j.to_string()).len()
                });
                assert!(made.iter().copied().eq(0..count), "{made:?}");
                assert_eq!(seen, vec![1; count]);
                let made = call.each_by_size(0..count, |k| k % 7, |k| k);
                assert!(made.iter().copied().eq(0..count), "{made:?}");
            }
        }
    }

    /// Makes calls one after the other, from the last on.
    struct Backwards;

    impl Jobs for Backwards {
        fn width(&self) -> usize {
            2
        }

        fn spawn(&self, _: Priority, job: Job) {
            job();
        }

        fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
            (0..count).rev().for_each(body);
        }
    }

    #[test]
    fn the_largest_items_are_begun_first() {
        let (control, begun) = (Control::default(), Mutex::new(Vec::new()));
        let call = Call::new(&Backwards, &control);
        call.each_by_size([3, 9, 1, 7, 5], |size| *size, |size| lock(&begun).push(size));
        assert_eq!(*lock(&begun), [9, 7, 5, 3, 1]);
    }

    #[test]
    fn both_calls_are_made_and_may_loop() {
        let control = Control::default();
        for jobs in pools() {
            let call = Call::new(&*jobs, &control);
            let mut seen = 0;
            let (squares, text) = call.both(
                || call.each(1, 0..9, |k| k * k),
                || {
                    seen += 1;
                    "text".to_owned()
                },
            );
            assert!(squares.into_iter().eq((0..9).map(|k| k * k)));
            assert_eq!((text.as_str(), seen), ("text", 1));
        }
    }

    #[test]
    fn items_come_until_the_caller_asks_to_stop() {
        let (control, owned) = (Control::default(), Arc::new(()));
        let mut items = Call::new(&Alone, &control).until_cancelled(vec![Arc::clone(&owned); 9]);
        assert_eq!(items.by_ref().take(3).count(), 3);
        assert_eq!(Arc::strong_count(&owned), 7);
        control.cancel();
        assert!(items.next().is_none());
        assert_eq!(Arc::strong_count(&owned), 1);
    }

    #[test]
    fn a_panic_reaches_the_caller() {
        let control = Control::default();
        for jobs in pools() {
            let bad = |k: u32| assert!(k != 5, "bad");
            let ended = catch_unwind(AssertUnwindSafe(|| Call::new(&*jobs, &control).each(2, 0..9, bad)));
            assert_eq!(ended.expect_err("a panic").downcast_ref(), Some(&"bad"));
        }
    }
}
