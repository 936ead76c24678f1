//! What became of a tile: its triangles, the rung that they needed, and what went wrong.

use super::ladder::Rung;
use crate::mesh::TileMesh;
use crate::model::{FaceId, TileTrouble};
use glam::DVec3;
use std::fmt;

/// How a tile fell short of the normal path.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Degradation {
    /// The trim loops cross themselves or each other: each point is covered as often as they wind around it.
    NotSimple {
        /// Boundary segments split at crossings; the triangles that only close join them to the neighbouring faces.
        split: u32,
        /// The first crossing, in the part's coordinates, where segments had to be split.
        place: Option<DVec3>,
    },
    /// The boundary cancels at this tolerance: nothing has to be filled. Where the face has other tiles, these close over it.
    Empty,
    /// The tile could not be triangulated: its boundary is filled in space.
    Filled(String),
    /// Not even the boundary is known: there are no triangles. A defect of this crate.
    Failed(String),
}

impl fmt::Display for Degradation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.trouble().fmt(f)
    }
}

impl Degradation {
    /// The same as a diagnostic has it.
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

/// A tile's triangles and how they came about.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct TileOutcome {
    /// The face.
    pub face: FaceId,
    /// The triangles.
    pub mesh: TileMesh,
    /// How far down the ladder of fallbacks it went; [`Rung::Repaired`] at least where prepare repaired the face.
    pub rung: Rung,
    /// What went wrong, if anything did.
    pub degradation: Option<Degradation>,
    /// Triangles that only close the boundary; where the loops are not simple, also those that have no area.
    pub slivers: u32,
    /// Area that the boundary winds around otherwise than once, mm².
    pub rewound: f64,
}

impl TileOutcome {
    /// A tile of which nothing could be made.
    #[must_use]
    pub fn lost(face: FaceId, why: String) -> Self {
        let degradation = Some(Degradation::Failed(why));
        Self { face, mesh: TileMesh::default(), rung: Rung::Lost, degradation, slivers: 0, rewound: 0.0 }
    }
}
