//! Where work runs: on threads of the library, on an engine's pool, or on the caller's thread alone.

use std::sync::{Mutex, OnceLock, PoisonError};

/// Threads that run work: [`Threads`](crate::parallel::Threads), an engine's pool behind a few lines, or [`Alone`].
///
/// Results never depend on the number of threads, nor on when and in which order jobs run.
pub trait Jobs: Send + Sync {
    /// How many jobs can run at the same time, at least 1.
    fn width(&self) -> usize;

    /// Runs `job` once, on any thread, now or later. A pool that drops the job instead costs time: whoever waits for it
    /// does its work.
    fn spawn(&self, job: Box<dyn FnOnce() + Send>);

    /// Calls `job` with each of `0..count`, in any order and at the same time, and returns after the last call. Is also
    /// called from within jobs, and must then not wait for a thread that waits for it.
    fn each(&self, count: usize, job: &(dyn Fn(usize) + Sync));
}

/// No threads: all work is done by the caller, before the call returns.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Jobs for Alone {
    fn width(&self) -> usize {
        1
    }

    fn spawn(&self, job: Box<dyn FnOnce() + Send>) {
        job();
    }

    fn each(&self, count: usize, job: &(dyn Fn(usize) + Sync)) {
        (0..count).for_each(job);
    }
}

/// Calls `job` with each item and its index.
pub(crate) fn each_mut<T: Send>(jobs: &dyn Jobs, items: &mut [T], job: impl Fn(usize, &mut T) + Sync) {
    if jobs.width() == 1 || items.len() == 1 {
        items.iter_mut().enumerate().for_each(|(k, item)| job(k, item));
        return;
    }
    // No lock is ever waited for: each belongs to one call.
    let slots: Vec<Mutex<Option<&mut T>>> = items.iter_mut().map(|item| Mutex::new(Some(item))).collect();
    let call = |k: usize| {
        let item = slots[k].lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(item) = item {
            job(k, item);
        }
    };
    jobs.each(slots.len(), &call);
    // Does nothing unless a pool left some out.
    (0..slots.len()).for_each(call);
}

/// Calls `job` with consecutive chunks of about `size` items, and returns its results in order.
pub(crate) fn map_chunks<T: Sync, R: Send + Sync>(
    jobs: &dyn Jobs,
    items: &[T],
    size: usize,
    job: impl Fn(&[T]) -> R + Sync,
) -> Vec<R> {
    if items.is_empty() {
        return Vec::new();
    }
    if jobs.width() == 1 || items.len() <= size {
        return vec![job(items)];
    }
    let chunks: Vec<(&[T], OnceLock<R>)> = items.chunks(size).map(|chunk| (chunk, OnceLock::new())).collect();
    jobs.each(chunks.len(), &|k| {
        let (chunk, result) = &chunks[k];
        result.get_or_init(|| job(chunk));
    });
    chunks.into_iter().map(|(chunk, result)| result.into_inner().unwrap_or_else(|| job(chunk))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Leaves out every third call.
    struct Careless;

    impl Jobs for Careless {
        fn width(&self) -> usize {
            4
        }

        fn spawn(&self, _: Box<dyn FnOnce() + Send>) {}

        fn each(&self, count: usize, job: &(dyn Fn(usize) + Sync)) {
            (0..count).rev().filter(|k| k % 3 > 0).for_each(job);
        }
    }

    #[test]
    fn every_item_is_done_once_and_results_are_in_order() {
        for jobs in [&Alone as &dyn Jobs, &Careless] {
            for count in [0_u32, 1, 7, 8, 9, 100] {
                let mut items: Vec<u32> = (0..count).collect();
                each_mut(jobs, &mut items, |k, item| *item += 1000 + k as u32);
                assert!(items.iter().enumerate().all(|(k, &item)| item == 1000 + 2 * k as u32), "{items:?}");
                let chunks = map_chunks(jobs, &items, 8, <[u32]>::to_vec);
                assert_eq!(chunks.concat(), items);
            }
        }
    }
}
