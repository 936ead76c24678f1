//! Sewing: edges of different faces that lie together.

/// Outcome of sewing edges of different faces that lie together.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BorderTrouble {
    /// Edges of a shell within its tolerance were merged.
    #[error(
        "{pairs} pairs of edges of its shell, up to {width_mm:.3e} mm apart, were merged (tolerance {tolerance_mm:.1e} \
         mm)"
    )]
    Sewn {
        /// How many pairs.
        pairs: usize,
        /// Largest distance between merged edges, millimetres.
        width_mm: f64,
        /// The tolerance, millimetres.
        tolerance_mm: f64,
    },
    /// Edges on both sides of a face lie within the tolerance; they were not merged.
    #[error("edges on both sides of it, within the tolerance of {tolerance_mm:.1e} mm, were not merged")]
    ThinFace {
        /// The tolerance, millimetres.
        tolerance_mm: f64,
    },
    /// Too many edges lie together; some pairs were not compared.
    #[error("{pairs} pairs of edges of its shell were not compared: more than {limit} lie together")]
    NotCompared {
        /// How many pairs.
        pairs: usize,
        /// Maximum number of partners that each edge is compared with.
        limit: usize,
    },
    /// Borders of faces without topology were merged into shared edges.
    #[error("{pairs} pairs of borders of faces without topology, up to {width_mm:.3e} mm apart, were merged")]
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
