//! Tiles and edges that needed more than the normal path when a frame was made.

use crate::model::{EdgeId, PartId};

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
