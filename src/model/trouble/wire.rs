//! Repairs of wires that do not close.

use std::fmt;

/// Repair of a wire that does not close, or of an edge that misses its vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum WireTrouble {
    /// The edges of a wire close only in another order and were reordered.
    Reordered {
        /// How many edges it has.
        edges: usize,
        /// How many of them were reversed.
        turned: usize,
    },
    /// Gaps were closed by moving vertices. A note within the part's tolerance, a warning beyond.
    VerticesMoved {
        /// The widest gap, millimetres.
        width_mm: f64,
        /// The part's tolerance, millimetres.
        tolerance_mm: f64,
    },
    /// Gaps were bridged by straight lines in (u,v).
    Bridged {
        /// The widest gap, millimetres.
        width_mm: f64,
        /// How many gaps the face has.
        gaps: usize,
    },
    /// Edges across gaps have no counterpart in another face; the gaps were filled.
    BridgesFilled {
        /// How many edges.
        edges: usize,
    },
    /// An edge misses its vertex; the mesh uses the vertex.
    EdgeOffVertex {
        /// By how much, millimetres.
        gap_mm: f64,
    },
}

codes!(WireTrouble {
    Self::Reordered { .. } => "wire-out-of-order",
    Self::VerticesMoved { .. } => "wire-gaps-closed",
    Self::Bridged { .. } => "wire-gap-bridged",
    Self::BridgesFilled { .. } => "wire-gaps-filled",
    Self::EdgeOffVertex { .. } => "edge-misses-vertex"
});

impl fmt::Display for WireTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Reordered { edges, turned } => {
                write!(f, "the {edges} edges of a wire close only in another order")?;
                if turned > 0 {
                    write!(f, ", {turned} of them reversed")?;
                }
                write!(f, "; they were reordered")
            }
            Self::VerticesMoved { width_mm, tolerance_mm } => {
                let side = if width_mm <= tolerance_mm { "within" } else { "beyond" };
                write!(
                    f,
                    "gaps of up to {width_mm:.3e} mm in its wires were closed by moving vertices, {side} the tolerance \
                     of {tolerance_mm:.1e} mm"
                )
            }
            Self::Bridged { width_mm, gaps } => {
                write!(f, "a wire has a gap of {width_mm:.3e} mm")?;
                if gaps > 1 {
                    write!(f, ", the widest of {gaps}")?;
                }
                write!(f, "; it was bridged by a straight line in (u,v)")
            }
            Self::BridgesFilled { edges } => {
                write!(f, "{edges} edges across gaps of wires have no counterpart and were filled")
            }
            Self::EdgeOffVertex { gap_mm } => {
                write!(f, "an edge misses its vertex by {gap_mm:.3e} mm; the mesh uses the vertex")
            }
        }
    }
}
