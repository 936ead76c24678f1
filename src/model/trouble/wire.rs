//! What was done to wires that do not close.

use std::fmt;

/// What was done to a wire that does not close, or to an edge that misses its vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum WireTrouble {
    /// Its edges close in another order, and were taken in that.
    Reordered {
        /// How many edges it has.
        edges: usize,
        /// How many of them were turned.
        turned: usize,
    },
    /// Gaps were closed by moving vertices: a note within the part's tolerance, a warning beyond.
    VerticesMoved {
        /// The widest, millimetres.
        width_mm: f64,
        /// The part's tolerance, millimetres.
        tolerance_mm: f64,
    },
    /// Gaps were closed straight in (u,v).
    Bridged {
        /// The widest, millimetres.
        width_mm: f64,
        /// How many gaps the face has.
        gaps: usize,
    },
    /// Edges across gaps have no counterpart in another face, and were filled.
    BridgesFilled {
        /// How many edges.
        edges: usize,
    },
    /// An edge ends off its vertex; the mesh goes to the vertex.
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
                write!(f, "the {edges} edges of a wire close in another order")?;
                if turned > 0 {
                    write!(f, ", {turned} of them turned")?;
                }
                write!(f, "; they were taken in that")
            }
            Self::VerticesMoved { width_mm, tolerance_mm } => {
                let side = if width_mm <= tolerance_mm { "within" } else { "beyond" };
                write!(
                    f,
                    "gaps of up to {width_mm:.3e} mm in its wires were closed by moving vertices, {side} the tolerance of \
                     {tolerance_mm:.1e} mm"
                )
            }
            Self::Bridged { width_mm, gaps } => {
                write!(f, "a wire leaves a gap of {width_mm:.3e} mm")?;
                if gaps > 1 {
                    write!(f, ", the widest of {gaps}")?;
                }
                write!(f, "; it was closed straight in (u,v)")
            }
            Self::BridgesFilled { edges } => {
                write!(f, "{edges} edges across gaps of wires have no counterpart and were filled")
            }
            Self::EdgeOffVertex { gap_mm } => {
                write!(f, "an edge ends {gap_mm:.3e} mm off its vertex; the mesh goes to the vertex")
            }
        }
    }
}
