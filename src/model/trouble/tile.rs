//! What fell short of the normal path while a frame was made.

use crate::model::{EdgeId, PartId};
use std::fmt;

/// What fell short of the normal path while a frame was made.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TileTrouble {
    /// The boundary of a tile crosses or overlaps itself; each point is covered as often as the boundary winds around it.
    Crosses {
        /// Segments split at crossings.
        split: u32,
    },
    /// Nothing is left of the face at this tolerance.
    Empty,
    /// A tile could not be triangulated: its boundary is filled in space.
    Filled {
        /// What the panic or the trim stage said.
        why: String,
    },
    /// A tile has no triangles. A defect of this crate.
    Failed {
        /// What the panic said.
        why: String,
    },
    /// An edge has no polyline. A defect of this crate.
    NoPolyline {
        /// The part.
        part: PartId,
        /// The edge within the part.
        edge: EdgeId,
        /// What the panic said.
        why: String,
    },
    /// More than a ten-thousandth of a face is wound around other than once.
    Rewound {
        /// That area, mm².
        rewound_mm2: f64,
        /// The face's area, mm².
        area_mm2: f64,
    },
    /// A face has no triangles, and no stage said why. A defect of this crate.
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
                    "the boundary crosses or overlaps itself ({split} segments split); covered as often as it winds"
                )
            }
            Self::Empty => write!(f, "nothing is left of the face at this tolerance"),
            Self::Filled { why } => write!(f, "filled in space, not triangulated: {why}"),
            Self::Failed { why } => write!(f, "no triangles: {why}"),
            Self::NoPolyline { part, edge, why } => {
                write!(f, "no polyline for edge {} of part {}: {why}", edge.0, part.0)
            }
            Self::Rewound { rewound_mm2, area_mm2 } => {
                write!(f, "{rewound_mm2:.3e} mm² of its {area_mm2:.3e} mm² are wound other than once")
            }
            Self::Unexplained => write!(f, "no triangles, and no stage said why"),
        }
    }
}
