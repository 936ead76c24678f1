//! What is wrong with a face, or was done to it.

use super::face_error::FaceError;
use super::trim::TrimTrouble;
use glam::DVec2;
use std::fmt;

/// What is wrong with a face, or was done to it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum FaceTrouble {
    /// It has no tiles: an error, or a note where nothing is lost, because it has no area or the trims keep nothing of it.
    Unusable(FaceError),
    /// It could not be used as stated; its loops are filled in space.
    Filled {
        /// Why.
        cause: FaceError,
        /// The area that its loops enclose in the plane that fits them best, mm².
        area_mm2: f64,
    },
    /// What was done to a free trimming curve of it.
    Trim(TrimTrouble),
    /// Edges that a wire runs both ways were left out.
    BothWays,
    /// A loop is given twice; it was taken once.
    LoopTwice,
    /// The image of a loop on the surface misses its start.
    LoopMissesStart {
        /// By how much in space, millimetres.
        gap_mm: f64,
    },
    /// Images of edges crossed where the edges do not; they were moved apart.
    ImagesMoved {
        /// How far, millimetres.
        by_mm: f64,
    },
    /// The boundary crosses itself; lobes wound around backwards were turned.
    LobesTurned {
        /// How many.
        lobes: usize,
        /// Their area, mm².
        area_mm2: f64,
    },
    /// No loop bounds it on one side; it ends where its surface does.
    EndsWithSurface {
        /// The direction across that side: 0 for u, 1 for v.
        axis: usize,
        /// Where it ends, in the surface's parameter.
        at: f64,
    },
    /// It could not be cut as wanted; it has fewer tiles.
    FewerTiles {
        /// Where the wanted cuts failed, (u, v).
        at: DVec2,
    },
    /// The boundary crosses or overlaps itself; each point is covered as often as the boundary winds around it.
    Crosses,
    /// The same, in too many places to find them all.
    Scribble,
    /// Edges lie off the surface; the mesh follows the edges there.
    EdgesOffSurface {
        /// Largest distance, millimetres.
        gap_mm: f64,
    },
    /// A loop runs as the file states it, because the shell is closed that way only.
    LoopAsStated,
    /// The loops of its tiles do not sum to its own, and were closed.
    TilesClosed {
        /// Loops that were added.
        loops: usize,
        /// Straight edges that were added.
        joints: usize,
        /// Length of the longest of them, millimetres.
        longest_mm: f64,
    },
    /// Ends of edges that lie apart were joined.
    EndsJoined {
        /// Straight edges that were added.
        joints: usize,
        /// Length of the longest of them, millimetres.
        longest_mm: f64,
    },
    /// The loops of its tiles cannot be closed; its own are filled in space.
    TilesFilled,
    /// The loops of its tiles cannot be closed, and it has none of its own: it is lost.
    TilesLost,
}

codes!(FaceTrouble {
    Self::BothWays => "edges-run-both-ways",
    Self::LoopTwice => "loop-given-twice",
    Self::LoopMissesStart { .. } => "loop-misses-start",
    Self::ImagesMoved { .. } => "edge-images-crossed",
    Self::LobesTurned { .. } => "loop-lobes-turned",
    Self::EndsWithSurface { .. } => "face-ends-with-surface",
    Self::FewerTiles { .. } => "face-fewer-tiles",
    Self::Crosses => "loop-crosses-itself",
    Self::Scribble => "loop-near-itself",
    Self::EdgesOffSurface { .. } => "edges-off-surface",
    Self::LoopAsStated => "loop-as-stated",
    Self::TilesClosed { .. } => "tile-loops-closed",
    Self::EndsJoined { .. } => "edge-ends-joined",
    Self::TilesFilled => "tile-loops-filled",
    Self::TilesLost => "tile-loops-lost";
    FaceError in Self::Unusable(error) | Self::Filled { cause: error, .. } => error,
    TrimTrouble in Self::Trim(trim) => trim
});

impl fmt::Display for FaceTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unusable(error) => error.fmt(f),
            Self::Filled { cause, area_mm2 } => {
                write!(f, "{cause}; its loops are filled in space, with about {area_mm2:.3e} mm²")
            }
            Self::Trim(trim) => trim.fmt(f),
            Self::BothWays => write!(f, "edges that a wire runs both ways were left out: they bound nothing"),
            Self::LoopTwice => write!(f, "a loop is given twice; it was taken once"),
            Self::LoopMissesStart { gap_mm } => write!(f, "the image of a loop misses its start by {gap_mm:.3e} mm"),
            Self::ImagesMoved { by_mm } => {
                write!(f, "images of edges crossed where the edges do not; they were moved apart, by {by_mm:.3e} mm")
            }
            Self::LobesTurned { lobes, area_mm2 } => {
                let noun = if *lobes == 1 { "lobe" } else { "lobes" };
                write!(
                    f,
                    "the boundary crosses itself; {lobes} {noun} of about {area_mm2:.3e} mm², wound around backwards, turned"
                )
            }
            Self::EndsWithSurface { axis, at } => {
                write!(f, "no loop bounds the face at {} = {at:.6}; it ends where its surface does", ['u', 'v'][*axis])
            }
            Self::FewerTiles { at } => {
                write!(f, "the boundary cannot be cut around (u, v) = ({:.6}, {:.6}); kept as fewer tiles", at.x, at.y)
            }
            Self::Crosses => write!(f, "the boundary crosses or overlaps itself; it is covered as often as it winds"),
            Self::Scribble => write!(
                f,
                "the boundary comes near to itself in too many places to find them all; it is covered as often as it winds"
            ),
            Self::EdgesOffSurface { gap_mm } => {
                write!(f, "edges lie up to {gap_mm:.3e} mm off the surface; the mesh follows the edges there")
            }
            Self::LoopAsStated => {
                write!(f, "a loop runs as the file states it; turned as it lies, the shell would be open there")
            }
            Self::TilesClosed { loops, joints, longest_mm } => write!(
                f,
                "its tiles' loops do not sum to its own; {loops} loops and {joints} straight edges of up to \
                 {longest_mm:.3e} mm close them"
            ),
            Self::EndsJoined { joints, longest_mm } => write!(
                f,
                "ends of edges that lie up to {longest_mm:.3e} mm apart are joined by {joints} straight edges"
            ),
            Self::TilesFilled => write!(f, "its tiles' loops cannot be closed; its own are filled in space"),
            Self::TilesLost => write!(f, "its tiles' loops cannot be closed, and it has none of its own"),
        }
    }
}

impl From<TrimTrouble> for FaceTrouble {
    fn from(trim: TrimTrouble) -> Self {
        Self::Trim(trim)
    }
}
