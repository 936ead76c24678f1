//! Sewing: edges of different faces that lie together.

use std::fmt;

/// Outcome of sewing edges of different faces that lie together.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BorderTrouble {
    /// Edges of a solid's shell within its tolerance were merged.
    Sewn {
        /// How many pairs.
        pairs: usize,
        /// Largest distance between merged edges, millimetres.
        width_mm: f64,
        /// The tolerance, millimetres.
        tolerance_mm: f64,
    },
    /// Edges on both sides of a face lie within the tolerance; they were not merged.
    ThinFace {
        /// The tolerance, millimetres.
        tolerance_mm: f64,
    },
    /// Too many edges lie together; some pairs were not compared.
    NotCompared {
        /// How many pairs.
        pairs: usize,
        /// Maximum number of partners that each edge is compared with.
        limit: usize,
    },
    /// Borders of faces without topology were merged into shared edges.
    Joined {
        /// How many pairs.
        pairs: usize,
        /// Largest distance between merged borders, millimetres.
        width_mm: f64,
    },
}

codes!(BorderTrouble {
    Self::Sewn { .. } => "edges-sewn",
    Self::ThinFace { .. } => "face-thinner-than-tolerance",
    Self::NotCompared { .. } => "edges-not-compared",
    Self::Joined { .. } => "borders-joined"
});

impl fmt::Display for BorderTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Sewn { pairs, width_mm, tolerance_mm } => write!(
                f,
                "{pairs} pairs of edges of its shell, up to {width_mm:.3e} mm apart, were merged (tolerance \
                 {tolerance_mm:.1e} mm)"
            ),
            Self::ThinFace { tolerance_mm } => {
                write!(f, "edges on both sides of it, within the tolerance of {tolerance_mm:.1e} mm, were not merged")
            }
            Self::NotCompared { pairs, limit } => {
                write!(f, "{pairs} pairs of edges of its shell were not compared: more than {limit} lie together")
            }
            Self::Joined { pairs, width_mm } => write!(
                f,
                "{pairs} pairs of borders of faces without topology, up to {width_mm:.3e} mm apart, were merged"
            ),
        }
    }
}
