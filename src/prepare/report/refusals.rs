//! Why loops or trims keep nothing that could be cut into tiles, with numbers.

use glam::DVec2;
use std::fmt;

/// Why a face has no region.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum RegionError {
    /// No boundary, and the surface has no end.
    Unbounded { axis: u8 },
    /// A loop winds around both directions.
    Winding { winding: [i32; 2] },
    /// A boundary that goes round has no counterpart on its other side.
    OneSided { loops: usize },
    /// A point or parameter is not finite.
    NotFinite,
    /// A loop without edges.
    EmptyLoop,
    /// An edge whose parameter range is empty or no number.
    EmptyEdge { edge: u32, range: (f64, f64) },
    /// A boundary's image runs over more periods than any real one.
    Runaway { axis: u8, periods: f64 },
}

impl fmt::Display for RegionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unbounded { axis } => {
                write!(
                    f,
                    "no boundary in direction {}, and the surface has no end there",
                    ['u', 'v'][usize::from(*axis)]
                )
            }
            Self::Winding { winding: [u, v] } => write!(f, "a loop winds {u} times around u and {v} times around v"),
            Self::OneSided { loops } => write!(f, "{loops} loops go round the surface and do not enclose a region"),
            Self::EmptyLoop => write!(f, "a loop has no edges"),
            Self::EmptyEdge { edge, range } => {
                write!(f, "edge {edge} runs from parameter {} to {}", range.0, range.1)
            }
            Self::Runaway { axis, periods } => {
                write!(f, "the boundary runs over {periods:.3e} periods of {}", ['u', 'v'][usize::from(*axis)])
            }
            Self::NotFinite => write!(f, "the boundary has no finite image on the surface"),
        }
    }
}

/// The windings along the lines of a tile do not add up: the loops cross a line unseen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tangled {
    /// The tile's middle.
    pub(crate) at: DVec2,
}

impl fmt::Display for Tangled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the boundary cannot be cut around (u, v) = ({:.6}, {:.6})", self.at.x, self.at.y)
    }
}

/// The arcs that bound the region do not close to loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoRegion {
    /// Where.
    pub at: DVec2,
}

impl fmt::Display for NoRegion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the trimming curves cannot be told apart around (u, v) = ({:.6}, {:.6})", self.at.x, self.at.y)
    }
}

impl std::error::Error for NoRegion {}
