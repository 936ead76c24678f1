//! What is found about a face, the reasons why it cannot be used, panics among them, and the memory that prepare may
//! still take.

use crate::model::{DiagnosticKind, EdgeId, FaceError, Part};
use glam::{DVec2, DVec3};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// A finding about a face, and where it applies.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Finding {
    pub(crate) edge: Option<EdgeId>,
    pub(crate) place: Option<DVec3>,
    pub(crate) what: DiagnosticKind,
}

impl Finding {
    pub(crate) fn new(place: Option<DVec3>, what: impl Into<DiagnosticKind>) -> Self {
        Self { edge: None, place, what: what.into() }
    }

    /// A finding about an edge, at its start.
    pub(crate) fn at_edge(part: &Part, edge: u32, what: impl Into<DiagnosticKind>) -> Self {
        let start = part.vertices.get(part.edges[edge as usize].start.index());
        Self { edge: Some(EdgeId(edge)), ..Self::new(start.copied(), what) }
    }
}

/// The winding numbers along the lines of a tile are inconsistent: a crossing of a loop with a line was missed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tangled {
    /// The tile's middle.
    pub(crate) at: DVec2,
}

/// The arcs that bound the region do not close to loops.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the trimming curves cannot be told apart around (u, v) = ({:.6}, {:.6})", .at.x, .at.y)]
pub struct NoRegion {
    /// Where, in (u,v).
    pub at: DVec2,
}

/// Runs `draft` and turns a panic into [`FaceError::Internal`], so that a bug in this crate costs no other face.
pub(crate) fn guarded<T>(draft: impl FnOnce() -> Result<T, FaceError>) -> Result<T, FaceError> {
    catch_unwind(AssertUnwindSafe(draft)).unwrap_or_else(|panic| Err(FaceError::Internal(panic_message(&*panic))))
}

/// The message of a panic, or a placeholder if the payload is not text.
pub(crate) fn panic_message(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("a panic without a text").to_owned()
}

/// Memory spent so far by all threads, and its limit, bytes.
pub(crate) struct Room {
    limit: u64,
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

    /// Call before allocating `bytes` more.
    ///
    /// # Errors
    /// If there is no room for them. The whole call then fails, as if the limit were exceeded, and discards this error.
    pub(crate) fn ask(&self, bytes: usize) -> Result<(), FaceError> {
        if self.spent.load(Ordering::Relaxed).saturating_add(bytes as u64) <= self.limit {
            return Ok(());
        }
        self.refused.store(true, Ordering::Relaxed);
        Err(FaceError::Internal("more memory than the limit".to_owned()))
    }

    /// Whether the limit is exceeded, or would have been.
    pub(crate) fn exceeded(&self) -> bool {
        self.refused.load(Ordering::Relaxed) || self.spent.load(Ordering::Relaxed) > self.limit
    }
}
