//! Limits on the cost of preparing a model, checked face by face during the work.

use super::prepared::Tile;
use crate::model::{Model, Surface};
use crate::prepare::surface::tables::{BoundingBox, BoxBounds};
use crate::prepare::tiles::draft::FaceDraft;
use glam::DVec4;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

/// Upper limits for [`prepare`](crate::prepare::prepare()).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PrepareLimits {
    /// Bézier patches of all faces together.
    pub patches: u64,
    /// Memory of patches, derivative bounds and tiles in bytes, estimated from their counts.
    pub bytes: u64,
}

impl PrepareLimits {
    /// 16 million patches, 16 GiB. The largest real files have thousands of patches.
    pub const DEFAULT: Self = Self { patches: 1 << 24, bytes: 16 << 30 };

    /// Sets [`patches`](Self::patches).
    #[must_use]
    pub const fn with_patches(mut self, patches: u64) -> Self {
        self.patches = patches;
        self
    }

    /// Sets [`bytes`](Self::bytes).
    #[must_use]
    pub const fn with_bytes(mut self, bytes: u64) -> Self {
        self.bytes = bytes;
        self
    }
}

impl Default for PrepareLimits {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The model exceeds [`PrepareLimits`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PrepareError {
    /// More patches than [`PrepareLimits::patches`].
    TooManyPatches {
        /// The limit.
        limit: u64,
        /// Knot spans of all surfaces: the patches needed if every face used all of its surface.
        needed: u64,
    },
    /// More memory than [`PrepareLimits::bytes`].
    TooMuchMemory {
        /// The limit, bytes.
        limit: u64,
        /// Knot spans of all surfaces.
        patches: u64,
    },
}

impl fmt::Display for PrepareError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooManyPatches { limit, needed } => write!(
                f,
                "the model needs up to {needed} Bézier patches, the limit is {limit} (PrepareLimits::patches)"
            ),
            Self::TooMuchMemory { limit, patches } => write!(
                f,
                "preparing the model (up to {patches} Bézier patches) needs more memory than the limit of {limit} \
                 bytes (PrepareLimits::bytes)"
            ),
        }
    }
}

impl std::error::Error for PrepareError {}

/// Memory of a tile besides its patches, in bytes: loops, pcurves and their topology.
const BYTES_PER_TILE: u64 = 4096;

/// Patches and bytes spent so far by all threads.
pub(crate) struct PrepareBudget {
    limits: PrepareLimits,
    patches: AtomicU64,
    bytes: AtomicU64,
}

impl PrepareBudget {
    pub(crate) fn new(limits: PrepareLimits) -> Self {
        Self { limits, patches: AtomicU64::new(0), bytes: AtomicU64::new(0) }
    }

    /// Adds the cost of a face.
    pub(crate) fn spend(&self, draft: &FaceDraft) {
        let (u, v) = draft.patches.counts();
        let table = draft.bounds.cells.len() * size_of::<(BoxBounds, BoundingBox)>();
        let bytes = draft.patches.control.len() * size_of::<DVec4>() + table;
        let tiles = draft.tiles.len() as u64 * (BYTES_PER_TILE + size_of::<Tile>() as u64);
        self.patches.fetch_add(u as u64 * v as u64, Ordering::Relaxed);
        self.bytes.fetch_add(bytes as u64 + tiles, Ordering::Relaxed);
    }

    /// Whether a limit is exceeded. The remaining faces can then be skipped.
    pub(crate) fn exceeded(&self) -> bool {
        self.patches.load(Ordering::Relaxed) > self.limits.patches
            || self.bytes.load(Ordering::Relaxed) > self.limits.bytes
    }

    /// The error for `model` once a limit is exceeded.
    pub(crate) fn error(&self, model: &Model) -> PrepareError {
        let faces = model.parts.iter().flat_map(|part| &part.faces).filter(|face| !face.lost && face.refused.is_none());
        let needed = faces.map(|face| spans_of(&face.surface)).sum();
        if self.patches.load(Ordering::Relaxed) > self.limits.patches {
            return PrepareError::TooManyPatches { limit: self.limits.patches, needed };
        }
        PrepareError::TooMuchMemory { limit: self.limits.bytes, patches: needed }
    }
}

/// Knot spans of a whole surface; each quarter turn counts as one.
fn spans_of(surface: &Surface) -> u64 {
    let spans = |knots: &[f64]| knots.windows(2).filter(|pair| pair[0] < pair[1]).count() as u64;
    match surface {
        Surface::Plane { .. } => 1,
        Surface::Cylinder { .. } | Surface::Cone { .. } => 4,
        Surface::Sphere { .. } => 8,
        Surface::Torus { .. } => 16,
        Surface::Extrusion { curve, .. } => spans(&curve.knots),
        Surface::Revolution { curve, .. } => 4 * spans(&curve.knots),
        Surface::Nurbs(net) => spans(&net.knots_u) * spans(&net.knots_v),
    }
}
