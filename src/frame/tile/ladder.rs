//! How tiles came about -> the rung that each face needed: nothing that went off the normal path goes uncounted.

use crate::frame::trim::output::{TrimOutcome, TrimStats};
use std::fmt;

/// How far down the ladder of fallbacks a tile or face went; the later, the less of what was stated is left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rung {
    /// Every cell was triangulated by itself.
    #[default]
    Normal,
    /// Some cells were triangulated together. As exact as the normal path.
    MergedCells,
    /// A whole tile was triangulated at once. As exact as the normal path.
    WholeTile,
    /// Loops cross or overlap, or left gaps: each point is covered as often as they wind around it, and triangles that only
    /// close join the boundary to the neighbouring faces.
    Repaired,
    /// The boundary is filled in space, because the surface or its parameters could not be used. A warning says why.
    Filled,
    /// The face has no area, or its boundary cancels at this tolerance: there is nothing to mesh, and nothing is lost.
    NoArea,
    /// A tile, or the whole face, yielded no triangles. A diagnostic says why.
    Lost,
}

impl Rung {
    /// All of them, in order.
    pub const ALL: [Self; 7] =
        [Self::Normal, Self::MergedCells, Self::WholeTile, Self::Repaired, Self::Filled, Self::NoArea, Self::Lost];

    /// The rung of a tile that the trim stage made.
    pub(crate) fn of(outcome: TrimOutcome, stats: &TrimStats) -> Self {
        match outcome {
            TrimOutcome::Repaired { .. } => Self::Repaired,
            _ if stats.whole_tile => Self::WholeTile,
            TrimOutcome::Merged | TrimOutcome::Cdt => Self::MergedCells,
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

/// How many faces ended on each rung.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ladder {
    counts: [u64; Rung::ALL.len()],
}

impl Ladder {
    /// Counts faces that ended on `rung`.
    pub fn add(&mut self, rung: Rung, faces: u64) {
        self.counts[rung as usize] += faces;
    }

    /// How many faces ended on `rung`.
    #[must_use]
    pub fn count(&self, rung: Rung) -> u64 {
        self.counts[rung as usize]
    }
}

impl fmt::Display for Ladder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, rung) in Rung::ALL.into_iter().enumerate() {
            write!(f, "{}{} {rung}", if k == 0 { "" } else { ", " }, self.count(rung))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rungs_follow_what_the_trim_stage_did() {
        let whole = TrimStats { whole_tile: true, ..TrimStats::default() };
        let by_cells = TrimStats::default();
        let repaired = TrimOutcome::Repaired { split: 1 };
        for (outcome, stats, rung) in [
            (TrimOutcome::Certified, &by_cells, Rung::Normal),
            (TrimOutcome::Merged, &by_cells, Rung::MergedCells),
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
