//! Why the loops of a face enclose no region.

use crate::model::EdgeId;

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
