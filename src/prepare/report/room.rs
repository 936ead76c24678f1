//! Memory that prepare may still take, counted by all threads.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Memory spent so far, and its limit, bytes.
pub(crate) struct Room {
    pub(crate) limit: u64,
    spent: AtomicU64,
    refused: AtomicBool,
}

impl Room {
    pub(crate) fn new(limit: u64) -> Self {
        Self { limit, spent: AtomicU64::new(0), refused: AtomicBool::new(false) }
    }

    /// Adds memory that is held.
    pub(crate) fn spend(&self, bytes: usize) {
        self.spent.fetch_add(bytes as u64, Ordering::Relaxed);
    }

    /// Whether there is room for `bytes` more; if not, the whole call fails, as if the limit were exceeded. Ask before
    /// they are allocated.
    pub(crate) fn has(&self, bytes: usize) -> bool {
        let fits = self.spent.load(Ordering::Relaxed).saturating_add(bytes as u64) <= self.limit;
        if !fits {
            self.refused.store(true, Ordering::Relaxed);
        }
        fits
    }

    /// Whether the limit is exceeded, or would have been.
    pub(crate) fn exceeded(&self) -> bool {
        self.refused.load(Ordering::Relaxed) || self.spent.load(Ordering::Relaxed) > self.limit
    }
}
