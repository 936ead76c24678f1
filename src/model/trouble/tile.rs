//! Tiles and edges that needed more than the normal path when a frame was made.

use crate::model::{EdgeId, PartId};
use std::fmt;

/// Why a tile or an edge needed more than the normal path when a frame was made.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TileTrouble {
    /// The boundary of a tile crosses or overlaps itself. Each point is covered as often as its winding number says.
    Crosses {
        /// Number of segments that were split at crossings.
        split: u32,
    },
    /// The face has no area at this tolerance.
    Empty,
    /// A tile could not be triangulated; its boundary was filled in space.
    Filled {
        /// Message of the panic or the trim stage.
        why: String,
    },
    /// A tile has no triangles. A bug in this crate.
    Failed {
        /// Message of the panic.
        why: String,
    },
    /// An edge has no polyline. A bug in this crate.
    NoPolyline {
        /// The part.
        part: PartId,
        /// The edge within the part.
        edge: EdgeId,
        /// Message of the panic.
        why: String,
    },
    /// More than a ten-thousandth of a face has a winding number other than 1.
    Rewound {
        /// That area, mm².
        rewound_mm2: f64,
        /// The face's area, mm².
        area_mm2: f64,
    },
    /// A face has no triangles, and no stage said why. A bug in this crate.
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

impl fmt::Display for TileTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Crosses { split } => {
                write!(
                    f,
                    "the boundary crosses or overlaps itself ({split} segments split); areas are covered by winding \
                     number"
                )
            }
            Self::Empty => write!(f, "nothing is left of the face at this tolerance"),
            Self::Filled { why } => write!(f, "not triangulated; its boundary is filled in space: {why}"),
            Self::Failed { why } => write!(f, "no triangles: {why}"),
            Self::NoPolyline { part, edge, why } => {
                write!(f, "no polyline for edge {} of part {}: {why}", edge.0, part.0)
            }
            Self::Rewound { rewound_mm2, area_mm2 } => {
                write!(f, "{rewound_mm2:.3e} mm² of its {area_mm2:.3e} mm² have a winding number other than 1")
            }
            Self::Unexplained => write!(f, "no triangles, and no stage said why"),
        }
    }
}
