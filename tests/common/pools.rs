//! Pools for sessions: an engine's, and one that runs jobs in any order.
#![allow(dead_code, reason = "not every test uses all of it")]

use std::collections::HashSet;
use std::sync::{Arc, Mutex};
use std::thread::{self, ThreadId};
use trimtess::control::{Job, Jobs, Priority};

/// An engine's pool: rayon's.
pub(crate) struct Engine {
    pub(crate) pool: rayon::ThreadPool,
    /// The threads that jobs ran on.
    pub(crate) seen: Arc<Mutex<HashSet<ThreadId>>>,
}

impl Engine {
    pub(crate) fn of(threads: usize) -> Self {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        Self { pool, seen: Arc::default() }
    }
}

impl Jobs for Engine {
    fn width(&self) -> usize {
        self.pool.current_num_threads()
    }

    fn spawn(&self, _: Priority, job: Job) {
        let seen = Arc::clone(&self.seen);
        self.pool.spawn(move || {
            seen.lock().unwrap().insert(thread::current().id());
            job();
        });
    }
}

/// Keeps jobs, and runs some of them in between, in shuffled order: one thread for each.
#[derive(Default)]
pub(crate) struct Shuffled(Mutex<Vec<Job>>);

impl Jobs for Shuffled {
    fn width(&self) -> usize {
        5
    }

    fn spawn(&self, _: Priority, job: Job) {
        let mut kept = self.0.lock().unwrap();
        kept.push(job);
        if kept.len() == 7 {
            // The others never run.
            for k in [5, 1, 3, 0] {
                thread::spawn(kept.swap_remove(k));
            }
            kept.clear();
        }
    }
}
