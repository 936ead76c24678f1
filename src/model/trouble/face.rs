//! Why faces and tiles cannot be meshed as stated, and how faces and their free trimming curves were repaired.

use super::step::StepCause;
use crate::model::{EdgeId, PartId, SurfaceError, TrimError};
use glam::{DVec2, DVec3};

/// Why the loops of a face enclose no region.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RegionError {
    /// The face has no boundary in a direction in which its surface is unbounded.
    #[error("no boundary in direction {}, in which the surface is unbounded", ['u', 'v'][*.axis])]
    Unbounded {
        /// The direction: 0 for u, 1 for v.
        axis: usize,
    },
    /// A loop winds around both directions.
    #[error("a loop winds {} times around u and {} times around v", .winding[0], .winding[1])]
    Winding {
        /// Winding numbers around u and around v.
        winding: [i32; 2],
    },
    /// Loops wind around the surface without a counterpart on the other side.
    #[error("{loops} loops wind around the surface and enclose no region")]
    OneSided {
        /// How many loops wind around it.
        loops: usize,
    },
    /// A point or parameter is infinite or NaN.
    #[error("the boundary has no finite pcurves")]
    NotFinite,
    /// A loop has no edges.
    #[error("a loop has no edges")]
    EmptyLoop,
    /// The parameter range of an edge is empty or NaN.
    #[error("the range of edge {} is empty: {} to {}", .edge.0, .range.0, .range.1)]
    EmptyEdge {
        /// The edge.
        edge: EdgeId,
        /// Its range.
        range: (f64, f64),
    },
    /// A loop covers more periods of the surface than any real one.
    #[error("a loop covers {periods:.3e} periods of {}", ['u', 'v'][*.axis])]
    Runaway {
        /// The direction: 0 for u, 1 for v.
        axis: usize,
        /// Periods that it covers.
        periods: f64,
    },
}

codes!(RegionError {
    Self::Unbounded { .. } => "face-unbounded",
    Self::Winding { .. } => "loop-winds-around-both",
    Self::OneSided { .. } => "loops-enclose-nothing",
    Self::NotFinite => "face-not-finite",
    Self::EmptyLoop => "loop-without-edges",
    Self::EmptyEdge { .. } => "edge-range-empty",
    Self::Runaway { .. } => "loop-runs-away"
});

/// Why a face cannot be meshed as stated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FaceError {
    /// The surface is invalid.
    #[error(transparent)]
    Surface(SurfaceError),
    /// The surface was not read.
    #[error("the surface was not read: {0}")]
    Refused(StepCause),
    /// The loops enclose no region.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// The region cannot be cut into tiles: the winding numbers of its loops do not add up there, whatever the cuts.
    #[error("the face cannot be cut into tiles at (u, v) = ({:.6}, {:.6})", .at.x, .at.y)]
    Tangled {
        /// Where, (u, v).
        at: DVec2,
        /// Where in space, millimetres.
        place: DVec3,
    },
    /// The edges are nowhere near the surface.
    #[error("edges lie {gap_mm:.3e} mm off the surface; the face is {extent_mm:.3e} mm across")]
    OffSurface {
        /// Largest distance between edges and surface, millimetres.
        gap_mm: f64,
        /// Size of the face, millimetres.
        extent_mm: f64,
    },
    /// No lobe of the boundary runs backwards.
    #[error("no lobe of the boundary runs backwards")]
    NoLobes,
    /// A bug in this crate.
    #[error("internal error: {0}")]
    Internal(String),
    /// A free trimming curve is invalid.
    #[error("free trimming curve {curve}: {error}")]
    Trim {
        /// Which of the face's curves.
        curve: usize,
        /// Why.
        error: TrimError,
    },
    /// Free trims have no domain: the surface has no extent, or is unbounded where the curves have no extent.
    #[error(
        "free trims need a surface or curves with an extent; these extend from ({}, {}) to ({}, {}) in (u, v)",
        .low.x, .low.y, .high.x, .high.y
    )]
    NoDomain {
        /// Lower corner of their box, (u, v).
        low: DVec2,
        /// Upper corner of their box, (u, v).
        high: DVec2,
    },
    /// Free trims keep an unbounded part of the surface.
    #[error("the trimming curves keep a part that is unbounded in {}, and so is the surface", ['u', 'v'][*.axis])]
    Unbounded {
        /// The direction: 0 for u, 1 for v.
        axis: usize,
    },
    /// Free trimming curves are too close to each other to be separated.
    #[error("the trimming curves cannot be separated around (u, v) = ({:.6}, {:.6})", .at.x, .at.y)]
    TrimsTangled {
        /// Where, (u, v).
        at: DVec2,
        /// Where in space, millimetres.
        place: DVec3,
    },
    /// Free trims keep nothing of the face.
    #[error("the trimming curves keep nothing of the face")]
    NothingKept,
    /// The surface is a point or a curve.
    #[error("the surface has no area: it is a point or a curve within a box of {size_mm:e} mm")]
    NoArea {
        /// Size of the box around it, millimetres.
        size_mm: f64,
    },
    /// The surface is smaller than the spacing of numbers at its coordinates.
    #[error("the surface is {size_mm:e} mm wide, below the spacing of numbers at coordinates of {coordinates_mm:e} mm")]
    Unresolved {
        /// Its width, millimetres.
        size_mm: f64,
        /// Largest coordinate, millimetres.
        coordinates_mm: f64,
    },
    /// Products of its coordinates overflow.
    #[error("coordinates of {coordinates_mm:e} mm are too large: their products overflow")]
    TooLarge {
        /// Largest coordinate, millimetres.
        coordinates_mm: f64,
    },
    /// The region has no extent in one direction.
    #[error("the region is only {extent:e} wide in {}", ['u', 'v'][*.axis])]
    Thin {
        /// The direction: 0 for u, 1 for v.
        axis: usize,
        /// The extent, in the surface's parameter.
        extent: f64,
    },
}

codes!(FaceError {
    Self::Surface(_) => "face-surface-unsound",
    Self::Refused(_) => "face-surface-not-read",
    Self::Tangled { .. } => "face-not-cut",
    Self::OffSurface { .. } => "face-off-surface",
    Self::NoLobes => "face-without-lobes",
    Self::Internal(_) => "face-internal-error",
    Self::Trim { .. } => "trim-unsound",
    Self::NoDomain { .. } => "trims-without-extent",
    Self::Unbounded { .. } => "trims-unbounded",
    Self::TrimsTangled { .. } => "trims-tangled",
    Self::NothingKept => "trims-keep-nothing",
    Self::NoArea { .. } => "face-without-area",
    Self::Unresolved { .. } => "face-below-resolution",
    Self::TooLarge { .. } => "face-too-large",
    Self::Thin { .. } => "face-thin";
    RegionError in Self::Region(error) => error
});

impl FaceError {
    /// Whether the cause may be that seams are treated as boundaries.
    pub(crate) fn may_be_seams(&self) -> bool {
        matches!(self, Self::Region(_) | Self::Tangled { .. })
    }

    /// The place in space, millimetres, if the error has one.
    #[must_use]
    pub fn place(&self) -> Option<DVec3> {
        match self {
            Self::Tangled { place, .. } | Self::TrimsTangled { place, .. } => Some(*place),
            _ => None,
        }
    }
}

/// Repair of a free trimming curve, or something notable about it.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrimTrouble {
    /// The curve leaves the surface's domain and was clipped at its border.
    #[error("trimming curve {curve} leaves the domain and was clipped")]
    Clipped {
        /// Which of the face's curves.
        curve: usize,
    },
    /// An open curve starts or ends inside the domain and was extended straight to the border.
    #[error(
        "open trimming curve {curve} {} {missing:.3e} of the domain away from its border; it was extended straight to \
         the border",
        if *.at_end { "ends" } else { "starts" }
    )]
    Extended {
        /// Which of the face's curves.
        curve: usize,
        /// Whether its end was extended, not its start.
        at_end: bool,
        /// Distance from the border, as a share of the domain.
        missing: f64,
    },
    /// The curve crosses or touches itself.
    #[error("trimming curve {curve} crosses or touches itself")]
    CrossesItself {
        /// Which of the face's curves.
        curve: usize,
    },
}

codes!(TrimTrouble {
    Self::Clipped { .. } => "trim-clipped",
    Self::Extended { .. } => "trim-extended",
    Self::CrossesItself { .. } => "trim-crosses-itself"
});

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

/// Why a tile or an edge needed more than the normal path when a frame was made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TileTrouble {
    /// The boundary of a tile crosses or overlaps itself. Each point is covered as often as its winding number says.
    #[error("the boundary crosses or overlaps itself ({split} segments split); areas are covered by winding number")]
    Crosses {
        /// Number of segments that were split at crossings.
        split: u32,
    },
    /// The face has no area at this tolerance.
    #[error("nothing is left of the face at this tolerance")]
    Empty,
    /// A tile could not be triangulated; its boundary was filled in space.
    #[error("not triangulated; its boundary is filled in space: {why}")]
    Filled {
        /// Message of the panic or the trim stage.
        why: String,
    },
    /// A tile has no triangles. A bug in this crate.
    #[error("no triangles: {why}")]
    Failed {
        /// Message of the panic.
        why: String,
    },
    /// An edge has no polyline. A bug in this crate.
    #[error("no polyline for edge {} of part {}: {why}", .edge.0, .part.0)]
    NoPolyline {
        /// The part.
        part: PartId,
        /// The edge within the part.
        edge: EdgeId,
        /// Message of the panic.
        why: String,
    },
    /// More than a ten-thousandth of a face has a winding number other than 1.
    #[error("{rewound_mm2:.3e} mm² of its {area_mm2:.3e} mm² have a winding number other than 1")]
    Rewound {
        /// That area, mm².
        rewound_mm2: f64,
        /// The face's area, mm².
        area_mm2: f64,
    },
    /// A face has no triangles, and no stage said why. A bug in this crate.
    #[error("no triangles, and no stage said why")]
    Unexplained,
}

codes!(TileTrouble {
    Self::Crosses { .. } => "tile-crosses-itself",
    Self::Empty => "tile-empty",
    Self::Filled { .. } => "tile-filled",
    Self::Failed { .. } => "tile-failed",
    Self::NoPolyline { .. } => "edge-without-polyline",
    Self::Rewound { .. } => "face-wound-again",
    Self::Unexplained => "face-unexplained"
});
