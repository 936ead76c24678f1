//! Why the loops of a face bound no region.

use crate::model::EdgeId;
use std::fmt;

/// Why a face has no region.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RegionError {
    /// No boundary, and the surface has no end.
    Unbounded {
        /// The direction: 0 for u, 1 for v.
        axis: usize,
    },
    /// A loop winds around both directions.
    Winding {
        /// How often, around u and around v.
        winding: [i32; 2],
    },
    /// A boundary that goes round has no counterpart on its other side.
    OneSided {
        /// How many loops go round.
        loops: usize,
    },
    /// A point or parameter is infinite or NaN.
    NotFinite,
    /// A loop without edges.
    EmptyLoop,
    /// An edge whose parameter range is empty or NaN.
    EmptyEdge {
        /// The edge.
        edge: EdgeId,
        /// Its range.
        range: (f64, f64),
    },
    /// A boundary's image runs over more periods than any real one.
    Runaway {
        /// The direction: 0 for u, 1 for v.
        axis: usize,
        /// Periods of the surface that it runs over.
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

impl fmt::Display for RegionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unbounded { axis } => {
                write!(f, "no boundary in direction {}, and the surface has no end there", ['u', 'v'][*axis])
            }
            Self::Winding { winding: [u, v] } => write!(f, "a loop winds {u} times around u and {v} times around v"),
            Self::OneSided { loops } => write!(f, "{loops} loops go round the surface and do not enclose a region"),
            Self::NotFinite => write!(f, "the boundary has no finite image on the surface"),
            Self::EmptyLoop => write!(f, "a loop has no edges"),
            Self::EmptyEdge { edge, range } => {
                write!(f, "edge {} runs from parameter {} to {}", edge.0, range.0, range.1)
            }
            Self::Runaway { axis, periods } => {
                write!(f, "the boundary runs over {periods:.3e} periods of {}", ['u', 'v'][*axis])
            }
        }
    }
}
