//! The result of tessellating a tile: its triangles, their rung of the fallback ladder, and what went wrong.

use crate::frame::trim::output::{TrimOutcome, TrimStats};
use crate::mesh::TileMesh;
use crate::model::{FaceId, TileTrouble};
use glam::DVec3;
use std::fmt;

/// The fallback that a tile or face needed. Later rungs preserve less of the file's geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Rung {
    /// Every cell was triangulated by itself.
    #[default]
    Normal,
    /// Some cells were triangulated together. As exact as the normal path.
    MergedCells,
    /// A whole tile was triangulated at once. As exact as the normal path.
    WholeTile,
    /// Loops cross or overlap, or had gaps. Each point is covered as often as the loops wind around it; triangles that
    /// only close join the boundary to the neighbouring faces.
    Repaired,
    /// The boundary is filled in space, because the surface or its parameters could not be used. A warning says why.
    Filled,
    /// The face has no area, or its boundary cancels at this tolerance. There is nothing to mesh.
    NoArea,
    /// A tile, or the whole face, has no triangles. A diagnostic says why.
    Lost,
}

impl Rung {
    /// All rungs, in order.
    pub const ALL: &'static [Self] =
        &[Self::Normal, Self::MergedCells, Self::WholeTile, Self::Repaired, Self::Filled, Self::NoArea, Self::Lost];

    /// The rung of a tile made by the trim stage.
    pub(crate) fn of(outcome: TrimOutcome, stats: &TrimStats) -> Self {
        match outcome {
            TrimOutcome::Repaired { .. } => Self::Repaired,
            _ if stats.whole_tile => Self::WholeTile,
            TrimOutcome::Cdt => Self::MergedCells,
            TrimOutcome::Certified => Self::Normal,
        }
    }
}

impl fmt::Display for Rung {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Normal => "normal",
            Self::MergedCells => "cells merged",
            Self::WholeTile => "whole tile",
            Self::Repaired => "repaired",
            Self::Filled => "filled",
            Self::NoArea => "no area",
            Self::Lost => "lost",
        })
    }
}

/// Number of faces per rung.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ladder {
    counts: [u64; Rung::ALL.len()],
}

impl Ladder {
    /// Adds `faces` to the count of `rung`.
    pub fn add(&mut self, rung: Rung, faces: u64) {
        self.counts[rung as usize] += faces;
    }

    /// Number of faces on `rung`.
    #[must_use]
    pub fn count(&self, rung: Rung) -> u64 {
        self.counts[rung as usize]
    }
}

impl fmt::Display for Ladder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, rung) in Rung::ALL.iter().enumerate() {
            write!(f, "{}{} {rung}", if k == 0 { "" } else { ", " }, self.count(*rung))?;
        }
        Ok(())
    }
}

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
        /// The tile's chord tolerance, mm.
        chord: f64,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rungs_follow_from_trim_outcomes() {
        let whole = TrimStats { whole_tile: true, ..TrimStats::default() };
        let by_cells = TrimStats::default();
        let repaired = TrimOutcome::Repaired { split: 1 };
        for (outcome, stats, rung) in [
            (TrimOutcome::Certified, &by_cells, Rung::Normal),
            (TrimOutcome::Cdt, &by_cells, Rung::MergedCells),
            (TrimOutcome::Cdt, &whole, Rung::WholeTile),
            (repaired, &whole, Rung::Repaired),
        ] {
            assert_eq!(Rung::of(outcome, stats), rung, "{outcome:?}");
        }
        let mut ladder = Ladder::default();
        ladder.add(Rung::Repaired, 2);
        assert_eq!(
            ladder.to_string(),
            "0 normal, 0 cells merged, 0 whole tile, 2 repaired, 0 filled, 0 no area, 0 lost"
        );
    }
}
