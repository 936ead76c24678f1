//! Repairs of free trimming curves.

/// Repair of a free trimming curve, or something notable about it.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrimTrouble {
    /// The curve leaves the surface's domain and was clipped at its border.
    #[error("trimming curve {curve} leaves the domain and was clipped")]
    Clipped {
        /// Which of the face's curves.
        curve: usize,
    },
    /// An open curve starts or ends inside the domain and was extended straight to the border.
    #[error(
        "open trimming curve {curve} {} {missing:.3e} of the domain away from its border; it was extended straight to \
         the border",
        if *.at_end { "ends" } else { "starts" }
    )]
    Extended {
        /// Which of the face's curves.
        curve: usize,
        /// Whether its end was extended, not its start.
        at_end: bool,
        /// Distance from the border, as a share of the domain.
        missing: f64,
    },
    /// The curve crosses or touches itself.
    #[error("trimming curve {curve} crosses or touches itself")]
    CrossesItself {
        /// Which of the face's curves.
        curve: usize,
    },
}

codes!(TrimTrouble {
    Self::Clipped { .. } => "trim-clipped",
    Self::Extended { .. } => "trim-extended",
    Self::CrossesItself { .. } => "trim-crosses-itself"
});
