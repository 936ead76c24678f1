//! The result of tessellating a tile: its triangles, their rung, and what went wrong.

use super::ladder::Rung;
use crate::mesh::TileMesh;
use crate::model::{FaceId, TileTrouble};
use glam::DVec3;
use std::fmt;

/// Why a tile is not an exact triangulation of a region with simple loops.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Degradation {
    /// The trim loops cross themselves or each other. Each point is covered as often as they wind around it.
    NotSimple {
        /// Boundary segments split at crossings. Triangles that only close join them to the neighbouring faces.
        split: u32,
        /// How far points that the loops wind around, but not exactly once, may be from the outline of these, mm.
        depth: f64,
        /// The first crossing in the part's coordinates, if segments had to be split.
        place: Option<DVec3>,
    },
    /// The boundary cancels at this tolerance, and there are no triangles. The face's other tiles close over the gap.
    Empty,
    /// The tile could not be triangulated, for this reason. Its boundary is filled in space.
    Filled(String),
    /// The boundary could not be filled either, for this reason. There are no triangles. A defect of this crate.
    Failed(String),
}

impl fmt::Display for Degradation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.trouble().fmt(f)
    }
}

impl Degradation {
    /// The diagnostic for it.
    #[must_use]
    pub fn trouble(&self) -> TileTrouble {
        match self {
            Self::NotSimple { split, .. } => TileTrouble::Crosses { split: *split },
            Self::Empty => TileTrouble::Empty,
            Self::Filled(why) => TileTrouble::Filled { why: why.clone() },
            Self::Failed(why) => TileTrouble::Failed { why: why.clone() },
        }
    }
}

/// A tile's triangles, their rung, and what went wrong.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct TileOutcome {
    /// The face.
    pub face: FaceId,
    /// The triangles.
    pub mesh: TileMesh,
    /// The fallback that it needed. At least [`Rung::Repaired`] if `prepare` repaired the face.
    pub rung: Rung,
    /// What went wrong, if anything.
    pub degradation: Option<Degradation>,
    /// Triangles that only close the boundary. If the loops are not simple, also triangles without area.
    pub slivers: u32,
    /// Area that the boundary winds around, but not exactly once, mm².
    pub rewound: f64,
}

impl TileOutcome {
    /// A tile without triangles, for the reason `why`.
    #[must_use]
    pub fn lost(face: FaceId, why: String) -> Self {
        let degradation = Some(Degradation::Failed(why));
        Self { face, mesh: TileMesh::default(), rung: Rung::Lost, degradation, slivers: 0, rewound: 0.0 }
    }
}
