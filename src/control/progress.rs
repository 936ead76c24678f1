//! Long work -> progress for its caller, and a request to stop it.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// A stage of the way from a file to a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Stage {
    /// Reading. Counts parts, once the syntax is parsed.
    Read,
    /// Preparing. Counts faces, each part once.
    Prepare,
    /// Tessellating. Counts tiles, each part once.
    Tessellate,
    /// Writing a file. Counts the tiles that the file has, in formats without instances those of each instance, and all
    /// of them twice: when their bytes are made, and when they are written.
    Write,
}

impl Stage {
    /// The stage in one word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Prepare => "prepare",
            Self::Tessellate => "tessellate",
            Self::Write => "write",
        }
    }
}

/// How far a stage has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// The stage.
    pub stage: Stage,
    /// What is done, from 0 to `total`.
    pub done: u64,
    /// What there is to do.
    pub total: u64,
}

type Observer = Box<dyn Fn(Progress) + Send + Sync>;

/// The caller's end of long work: hears of its progress, and asks it to stop. Clones share one request.
///
/// ```
/// use trimtess::control::{Alone, Control};
/// use trimtess::{model::shapes, prepare};
///
/// let control = Control::default();
/// control.cancel(); // usually from another thread
/// let model = shapes::by_name("washer").unwrap_or_default();
/// let error = prepare::prepare_on(&Alone, &model, &prepare::PrepareOptions::DEFAULT, &control).err();
/// assert_eq!(error, Some(prepare::PrepareError::Cancelled));
/// ```
#[derive(Clone, Default)]
pub struct Control(Arc<Shared>);

#[derive(Default)]
struct Shared {
    cancelled: AtomicBool,
    observer: Option<Observer>,
    #[cfg(test)]
    looks: looks::Looks,
}

impl Control {
    /// A control whose `observer` hears of progress: of 0 first, then of larger and larger numbers, at most once per
    /// part, face or tile, and last of the total, before the call returns. Threads that do the work call it, one at a
    /// time. None waits for another, so numbers are left out while it runs. It should return at once.
    #[must_use]
    pub fn observed_by(observer: impl Fn(Progress) + Send + Sync + 'static) -> Self {
        Self(Arc::new(Shared { observer: Some(Box::new(observer)), ..Shared::default() }))
    }

    /// Asks the work to stop. It ends with an error after the piece of text, part, face or tile in hand, or
    /// a MiB that is being written.
    pub fn cancel(&self) {
        self.0.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether the work was asked to stop.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        #[cfg(test)]
        self.0.looks.count(self);
        self.0.cancelled.load(Ordering::Relaxed)
    }
}

/// What is done of a stage. Tells the observer, if there is one.
pub(crate) struct Counter {
    control: Control,
    stage: Stage,
    done: AtomicU64,
    total: u64,
    /// The last number that the observer heard. Belongs to the thread that set `telling`.
    told: AtomicU64,
    telling: AtomicBool,
}

impl Counter {
    /// Nothing is done yet.
    pub(crate) fn start(control: &Control, stage: Stage, total: u64) -> Self {
        let (done, told) = Default::default();
        let counter = Self { control: control.clone(), stage, done, total, told, telling: AtomicBool::new(false) };
        if let Some(observer) = &control.0.observer {
            observer(Progress { stage, done: 0, total });
        }
        counter
    }

    /// Counts one more.
    pub(crate) fn advance(&self) {
        self.advance_by(1);
    }

    /// Counts so many more.
    ///
    /// No lock: the observer may itself do work that this thread joins, and would then wait for itself. So a thread
    /// that finds another one telling leaves its number to it.
    pub(crate) fn advance_by(&self, count: u64) {
        let Some(observer) = &self.control.0.observer else { return };
        self.done.fetch_add(count, Ordering::SeqCst);
        while self.done.load(Ordering::SeqCst) > self.told.load(Ordering::SeqCst) {
            if self.telling.swap(true, Ordering::SeqCst) {
                return;
            }
            let _ends = Telling(&self.telling);
            let done = self.done.load(Ordering::SeqCst);
            if self.told.swap(done, Ordering::SeqCst) < done {
                observer(Progress { stage: self.stage, done, total: self.total });
            }
        }
    }
}

/// Ends when the observer returns, or panics.
struct Telling<'a>(&'a AtomicBool);

impl Drop for Telling<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::SeqCst);
    }
}

impl fmt::Debug for Control {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Control").field("cancelled", &self.is_cancelled()).finish_non_exhaustive()
    }
}

/// Cancels at each place of the code that looks for one.
#[cfg(test)]
pub(crate) mod looks {
    use super::{Control, Shared};
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU64, Ordering};

    /// How often somebody has looked for a cancel, and the look that finds the first one.
    #[derive(Default)]
    pub(super) struct Looks {
        so_far: AtomicU64,
        cancel_at: Option<u64>,
    }

    impl Looks {
        pub(super) fn count(&self, control: &Control) {
            if Some(self.so_far.fetch_add(1, Ordering::Relaxed)) == self.cancel_at {
                control.cancel();
            }
        }
    }

    /// A control that is cancelled at a look, counted from 0.
    pub(crate) fn cancelled_at(look: u64) -> Control {
        let looks = Looks { cancel_at: Some(look), ..Looks::default() };
        Control(Arc::new(Shared { looks, ..Shared::default() }))
    }

    /// How often somebody has looked.
    pub(crate) fn so_far(control: &Control) -> u64 {
        control.0.looks.so_far.load(Ordering::Relaxed)
    }

    /// Cancels `work` at one of its looks after another. Asserts that it then returns `true`, for cancelled, and does
    /// not panic. If it looks more than `count` times: at about so many looks, evenly spread, and at each of the last
    /// 50.
    pub(crate) fn assert_each_cancels(name: &str, count: u64, work: impl Fn(&Control) -> bool) {
        let whole = Control::default();
        assert!(!work(&whole), "{name}: nobody cancels");
        let total = so_far(&whole);
        assert!(total > 0, "{name}: nobody looks");
        let step = usize::try_from(total.div_ceil(count)).expect("few looks");
        for look in (0..total).step_by(step).chain(total.saturating_sub(50)..total) {
            let control = cancelled_at(look);
            let cancelled = catch_unwind(AssertUnwindSafe(|| work(&control)));
            assert!(cancelled.is_ok_and(|cancelled| cancelled), "{name}: cancelled at look {look} of {total}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;
    use std::thread;

    #[test]
    fn observers_hear_of_more_and_more_and_of_the_total() {
        for threads in [1, 2, 8] {
            let heard = Arc::<Mutex<Vec<u64>>>::default();
            let theirs = Arc::clone(&heard);
            let control = Control::observed_by(move |progress| {
                theirs.lock().expect("no panic").push(progress.done);
                thread::yield_now();
            });
            let counter = Counter::start(&control, Stage::Read, 1000 * threads);
            thread::scope(|scope| {
                for _ in 0..threads {
                    scope.spawn(|| (0..1000).for_each(|_| counter.advance()));
                }
            });
            let heard = heard.lock().expect("no panic");
            assert!(heard.is_sorted_by(|a, b| a < b), "{heard:?}");
            assert_eq!((heard.first(), heard.last()), (Some(&0), Some(&(1000 * threads))));
            assert!(threads > 1 || heard.len() == 1001);
        }
    }

    #[test]
    fn an_observer_may_advance_the_count_itself() {
        let own = Arc::<Mutex<Option<Arc<Counter>>>>::default();
        let (reader, calls) = (Arc::clone(&own), Arc::new(AtomicU64::new(0)));
        let count = Arc::clone(&calls);
        let control = Control::observed_by(move |progress| {
            count.fetch_add(1, Ordering::Relaxed);
            let counter = reader.lock().expect("no panic").clone();
            counter.iter().filter(|_| progress.done < 9).for_each(|counter| counter.advance());
        });
        let counter = Arc::new(Counter::start(&control, Stage::Read, 9));
        *own.lock().expect("no panic") = Some(Arc::clone(&counter));
        counter.advance();
        assert_eq!((calls.load(Ordering::Relaxed), counter.done.load(Ordering::Relaxed)), (10, 9));
        *own.lock().expect("no panic") = None;
    }

    #[test]
    fn an_observer_that_panics_is_called_again() {
        let control = Control::observed_by(|progress| assert!(progress.done == 0, "bad"));
        let counter = Counter::start(&control, Stage::Read, 2);
        for _ in 0..2 {
            assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| counter.advance())).is_err());
        }
    }
}
