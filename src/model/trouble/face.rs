//! Defects and repairs of faces.

use super::face_error::FaceError;
use super::trim::TrimTrouble;
use glam::DVec2;

/// Defect or repair of a face.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FaceTrouble {
    /// The face has no tiles. An error, or a note if nothing is lost: it has no area, or the trims keep nothing of it.
    #[error(transparent)]
    Unusable(FaceError),
    /// The face could not be meshed as stated; its loops are filled in space.
    #[error("{cause}; its loops are filled in space, with about {area_mm2:.3e} mm²")]
    Filled {
        /// Why.
        cause: FaceError,
        /// The area that its loops enclose in their best-fit plane, mm².
        area_mm2: f64,
    },
    /// A repair of a free trimming curve.
    #[error(transparent)]
    Trim(TrimTrouble),
    /// The face uses edges in both directions; they were left out.
    #[error("edges that run both ways were left out: they bound nothing")]
    BothWays,
    /// A loop is given twice and was used once.
    #[error("a loop is given twice and was used once")]
    LoopTwice,
    /// The pcurves of a loop do not close, or one leaps from one sheet of the surface to another.
    #[error("the pcurves of a loop miss its start, or leap, by {gap_mm:.3e} mm")]
    LoopMissesStart {
        /// Width of the gap or leap in space, millimetres.
        gap_mm: f64,
    },
    /// Pcurves crossed where their edges do not; they were moved apart.
    #[error("pcurves crossed where their edges do not; they were moved apart by {by_mm:.3e} mm")]
    ImagesMoved {
        /// Largest displacement, millimetres.
        by_mm: f64,
    },
    /// The boundary crosses itself; lobes with negative winding numbers were reversed.
    #[error(
        "the boundary crosses itself; reversed {lobes} {} of about {area_mm2:.3e} mm² that ran backwards",
        if *.lobes == 1 { "lobe" } else { "lobes" }
    )]
    LobesTurned {
        /// How many.
        lobes: usize,
        /// Their area, mm².
        area_mm2: f64,
    },
    /// No loop bounds the face on one side; it ends at the border of its surface.
    #[error("no loop bounds the face at {} = {at:.6}; it ends with its surface", ['u', 'v'][*.axis])]
    EndsWithSurface {
        /// The direction across that side: 0 for u, 1 for v.
        axis: usize,
        /// Where it ends, in the surface's parameter.
        at: f64,
    },
    /// The face could not be cut as planned; it has fewer tiles.
    #[error("the face cannot be cut at (u, v) = ({:.6}, {:.6}); it has fewer tiles", .at.x, .at.y)]
    FewerTiles {
        /// Where the planned cuts failed, (u, v).
        at: DVec2,
    },
    /// The boundary crosses or overlaps itself. Each point is covered as often as its winding number says.
    #[error("the boundary crosses or overlaps itself; areas are covered by winding number")]
    Crosses,
    /// Like [`Crosses`](FaceTrouble::Crosses), in too many places to find them all.
    #[error(
        "the boundary comes near to itself in too many places to find them all; areas are covered by winding number"
    )]
    Scribble,
    /// Edges lie off the surface; the mesh follows the edges.
    #[error("edges lie up to {gap_mm:.3e} mm off the surface; the mesh follows the edges")]
    EdgesOffSurface {
        /// Largest distance, millimetres.
        gap_mm: f64,
    },
    /// A loop keeps the direction that the file states, because only then is the shell closed.
    #[error("a loop keeps the file's direction: reversed to suit its region, it would open the shell")]
    LoopAsStated,
    /// The loops of the face's tiles do not sum to its own and were closed.
    #[error(
        "the loops of its tiles do not sum to its own; {loops} loops and {joints} straight edges of up to \
         {longest_mm:.3e} mm close them"
    )]
    TilesClosed {
        /// Number of added loops.
        loops: usize,
        /// Number of added straight edges.
        joints: usize,
        /// Length of the longest added edge, millimetres.
        longest_mm: f64,
    },
    /// Gaps between ends of edges were closed by straight edges.
    #[error("gaps of up to {longest_mm:.3e} mm between ends of edges are closed by {joints} straight edges")]
    EndsJoined {
        /// Number of added straight edges.
        joints: usize,
        /// Length of the longest added edge, millimetres.
        longest_mm: f64,
    },
    /// The loops of the face's tiles cannot be closed; its own loops are filled in space.
    #[error("the loops of its tiles cannot be closed; its own are filled in space")]
    TilesFilled,
    /// The loops of the face's tiles cannot be closed, and it has no loops of its own: it is lost.
    #[error("the loops of its tiles cannot be closed, and it has none of its own")]
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
