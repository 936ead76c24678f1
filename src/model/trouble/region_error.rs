//! Why the loops of a face enclose no region.

use crate::model::EdgeId;
use std::fmt;

/// Why the loops of a face enclose no region.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RegionError {
    /// The face has no boundary in a direction in which its surface is unbounded.
    Unbounded {
        /// The direction: 0 for u, 1 for v.
        axis: usize,
    },
    /// A loop winds around both directions.
    Winding {
        /// Winding numbers around u and around v.
        winding: [i32; 2],
    },
    /// Loops wind around the surface without a counterpart on the other side.
    OneSided {
        /// How many loops wind around it.
        loops: usize,
    },
    /// A point or parameter is infinite or NaN.
    NotFinite,
    /// A loop has no edges.
    EmptyLoop,
    /// The parameter range of an edge is empty or NaN.
    EmptyEdge {
        /// The edge.
        edge: EdgeId,
        /// Its range.
        range: (f64, f64),
    },
    /// A loop covers more periods of the surface than any real one.
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

impl fmt::Display for RegionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unbounded { axis } => {
                write!(f, "no boundary in direction {}, in which the surface is unbounded", ['u', 'v'][*axis])
            }
            Self::Winding { winding: [u, v] } => write!(f, "a loop winds {u} times around u and {v} times around v"),
            Self::OneSided { loops } => write!(f, "{loops} loops wind around the surface and enclose no region"),
            Self::NotFinite => write!(f, "the boundary has no finite pcurves"),
            Self::EmptyLoop => write!(f, "a loop has no edges"),
            Self::EmptyEdge { edge, range } => {
                write!(f, "the range of edge {} is empty: {} to {}", edge.0, range.0, range.1)
            }
            Self::Runaway { axis, periods } => {
                write!(f, "a loop covers {periods:.3e} periods of {}", ['u', 'v'][*axis])
            }
        }
    }
}
