//! Handles: numbers that are never given twice, each with a row in the table of its kind.

use crate::status::Failure;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

/// Kinds of handles, in their highest byte.
const KINDS: [&str; 8] = ["", "control", "model", "builder", "prepared model", "mesh", "session", "job"];

/// Rows of all tables.
static LIVE: AtomicU64 = AtomicU64::new(0);

/// Number of handles that were given and not freed.
pub(crate) fn live() -> u64 {
    LIVE.load(Ordering::Relaxed)
}

/// All objects of a kind. A call holds the object for as long as it takes; the lock of the table is held for a look-up.
pub(crate) struct Table<T> {
    kind: u64,
    rows: Mutex<Rows<T>>,
}

struct Rows<T> {
    last: u64,
    live: BTreeMap<u64, Arc<T>>,
}

const KIND_SHIFT: u32 = 56;

impl<T> Table<T> {
    /// The table of the kind with this number in [`KINDS`].
    pub(crate) const fn new(kind: u8) -> Self {
        Self { kind: kind as u64, rows: Mutex::new(Rows { last: 0, live: BTreeMap::new() }) }
    }

    fn lock(&self) -> MutexGuard<'_, Rows<T>> {
        self.rows.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an object. Returns its handle's number, never 0.
    pub(crate) fn add(&self, object: T) -> u64 {
        let mut rows = self.lock();
        rows.last += 1;
        let id = self.kind << KIND_SHIFT | rows.last;
        rows.live.insert(id, Arc::new(object));
        LIVE.fetch_add(1, Ordering::Relaxed);
        id
    }

    /// The object of a handle.
    pub(crate) fn get(&self, id: u64) -> Result<Arc<T>, Failure> {
        let found = self.lock().live.get(&id).cloned();
        found.ok_or_else(|| self.dead(id))
    }

    /// The object of a handle, if it is not null.
    pub(crate) fn get_if(&self, id: u64) -> Result<Option<Arc<T>>, Failure> {
        if id == 0 { Ok(None) } else { self.get(id).map(Some) }
    }

    /// Ends a handle. A null one is no error.
    pub(crate) fn free(&self, id: u64) -> Result<(), Failure> {
        if id == 0 { Ok(()) } else { self.take(id).map(drop) }
    }

    /// Ends a handle and returns its object.
    pub(crate) fn take(&self, id: u64) -> Result<Arc<T>, Failure> {
        // The object is dropped by the caller, without the lock.
        let found = self.lock().live.remove(&id);
        found.inspect(|_| _ = LIVE.fetch_sub(1, Ordering::Relaxed)).ok_or_else(|| self.dead(id))
    }

    fn name(&self) -> &'static str {
        KINDS[self.kind as usize]
    }

    fn dead(&self, id: u64) -> Failure {
        let wanted = self.name();
        Failure::handle(match KINDS.get((id >> KIND_SHIFT) as usize).filter(|name| !name.is_empty()) {
            _ if id == 0 => format!("the {wanted}'s handle is null"),
            Some(other) if id >> KIND_SHIFT != self.kind => format!("the {wanted}'s handle is that of a {other}"),
            _ => format!("the {wanted}'s handle was freed, or is none"),
        })
    }
}

/// An object that one call at a time may change; nothing once it is freed.
pub(crate) type Exclusive<T> = Mutex<Option<T>>;

impl<T> Table<Exclusive<T>> {
    /// Calls `work` with the object of a handle, unless another call has it.
    pub(crate) fn with<R>(&self, id: u64, work: impl FnOnce(&mut T) -> Result<R, Failure>) -> Result<R, Failure> {
        let object = self.get(id)?;
        work(self.hold(&object)?.as_mut().ok_or_else(|| self.freed())?)
    }

    /// Ends a handle and drops its object, unless another call has it. A null one is no error.
    pub(crate) fn end(&self, id: u64) -> Result<(), Failure> {
        if id == 0 {
            return Ok(());
        }
        let object = self.get(id)?;
        let taken = self.hold(&object)?.take().ok_or_else(|| self.freed())?;
        self.free(id)?;
        drop(taken);
        Ok(())
    }

    fn hold<'a>(&self, object: &'a Exclusive<T>) -> Result<MutexGuard<'a, Option<T>>, Failure> {
        match object.try_lock() {
            Ok(held) => Ok(held),
            // A panic was told when it happened, and the object still holds what it promises.
            Err(TryLockError::Poisoned(held)) => Ok(held.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Failure::busy(format!("another call uses the {}", self.name()))),
        }
    }

    fn freed(&self) -> Failure {
        Failure::handle(format!("the {} is being freed", self.name()))
    }
}
