//! Limits on the cost of preparing a model, checked face by face during the work.

use super::kept::KeptFace;
use super::memory;
use super::prepared::PartCost;
use crate::control::{Call, Counter, Stage};
use crate::model::Model;
use crate::prepare::report::room::Room;
use crate::prepare::tiles::draft::FaceDraft;
use crate::prepare::tiles::extent::patches_of;
use std::sync::atomic::{AtomicU64, Ordering};

/// Upper limits for [`prepare`](crate::prepare::prepare()).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PrepareLimits {
    /// Bézier patches of all faces together.
    pub patches: u64,
    /// Memory of the model and of its patches, derivative bounds, tiles and edges, bytes, estimated from counts.
    pub bytes: u64,
}

impl PrepareLimits {
    /// 16 million patches, 16 GiB. The largest real files have thousands of patches.
    pub const DEFAULT: Self = Self { patches: 1 << 24, bytes: 16 << 30 };
}

options! {
    PrepareLimits:
    with_patches(patches: u64);
    with_bytes(bytes: u64);
}

/// The model exceeds [`PrepareLimits`], or an option is out of range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// [`PrepareOptions::border_tolerance`](crate::prepare::PrepareOptions::border_tolerance) is out of range.
    #[error("the border tolerance is {asked}, not from 0 to 1 (PrepareOptions::border_tolerance)")]
    BorderTolerance {
        /// Its value.
        asked: f64,
    },
    /// More patches than [`PrepareLimits::patches`].
    #[error("the model needs up to {needed} Bézier patches, the limit is {limit} (PrepareLimits::patches)")]
    TooManyPatches {
        /// The limit.
        limit: u64,
        /// Knot spans of all surfaces: the patches needed if every face used all of its surface.
        needed: u64,
    },
    /// More memory than [`PrepareLimits::bytes`].
    #[error(
        "preparing the model (up to {patches} Bézier patches) needs more memory than the limit of {limit} bytes \
         (PrepareLimits::bytes)"
    )]
    TooMuchMemory {
        /// The limit, bytes.
        limit: u64,
        /// Knot spans of all surfaces.
        patches: u64,
    },
    /// The work was [cancelled](crate::control::Control::cancel).
    #[error("preparing was cancelled")]
    Cancelled,
}

/// Adds what the allocator rounds up and has not given back to the system yet: half as much.
fn with_slack(bytes: usize) -> usize {
    bytes.saturating_add(bytes / 2)
}

impl PartCost {
    /// What a face adds to its part, and the draft of it that is kept.
    pub(crate) fn of(draft: &FaceDraft, kept: Option<&KeptFace>) -> Self {
        let (u, v) = draft.surface.patches.counts();
        let bytes = memory::of_draft(draft) + kept.map_or(0, |kept| memory::of_kept(&kept.draft));
        Self { patches: u as u64 * v as u64, bytes: with_slack(bytes) }
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self { patches: self.patches + other.patches, bytes: self.bytes.saturating_add(other.bytes) }
    }
}

/// Patches and bytes spent so far by all threads, and whether to go on.
pub(crate) struct PrepareBudget<'a> {
    limits: PrepareLimits,
    patches: AtomicU64,
    pub(crate) call: Call<'a>,
    /// Faces drafted.
    drafted: Counter,
    pub(crate) room: Room,
}

impl<'a> PrepareBudget<'a> {
    /// For `faces` faces to prepare.
    pub(crate) fn new(limits: PrepareLimits, faces: u64, call: Call<'a>) -> Self {
        let drafted = Counter::start(call.control, Stage::Prepare, faces);
        Self { limits, patches: AtomicU64::new(0), call, drafted, room: Room::new(limits.bytes) }
    }

    /// Adds the cost of a model, which is held until all of it is prepared.
    pub(crate) fn hold(&self, model: &Model) {
        self.room.spend(with_slack(memory::of_model(model)));
    }

    /// Adds the cost of a face, or of a part that is taken over.
    pub(crate) fn spend(&self, cost: PartCost) {
        self.patches.fetch_add(cost.patches, Ordering::Relaxed);
        self.room.spend(cost.bytes);
    }

    /// Counts a face that was drafted, or cannot be.
    pub(crate) fn advance(&self) {
        self.drafted.advance();
    }

    /// Whether a limit is exceeded, or the work is cancelled. The remaining faces can then be skipped.
    pub(crate) fn exceeded(&self) -> bool {
        self.call.is_cancelled() || self.patches.load(Ordering::Relaxed) > self.limits.patches || self.room.exceeded()
    }

    /// The error for `model` once a limit is exceeded or the work is cancelled.
    pub(crate) fn error(&self, model: &Model) -> PrepareError {
        if self.call.is_cancelled() {
            return PrepareError::Cancelled;
        }
        let faces = model.parts.iter().flat_map(|part| &part.faces).filter(|face| !face.lost && face.refused.is_none());
        let needed = faces.map(|face| patches_of(&face.surface) as u64).sum();
        if self.patches.load(Ordering::Relaxed) > self.limits.patches {
            return PrepareError::TooManyPatches { limit: self.limits.patches, needed };
        }
        PrepareError::TooMuchMemory { limit: self.limits.bytes, patches: needed }
    }
}
