//! Repairs of free trimming curves.

use std::fmt;

/// Repair of a free trimming curve, or something notable about it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum TrimTrouble {
    /// The curve leaves the surface's domain and was clipped at its border.
    Clipped {
        /// Which of the face's curves.
        curve: usize,
    },
    /// An open curve starts or ends inside the domain and was extended straight to the border.
    Extended {
        /// Which of the face's curves.
        curve: usize,
        /// Whether its end was extended, not its start.
        at_end: bool,
        /// Distance from the border, as a share of the domain.
        missing: f64,
    },
    /// The curve crosses or touches itself.
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

impl fmt::Display for TrimTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Clipped { curve } => write!(f, "trimming curve {curve} leaves the domain and was clipped"),
            Self::Extended { curve, at_end, missing } => {
                let stops = if *at_end { "ends" } else { "starts" };
                write!(
                    f,
                    "open trimming curve {curve} {stops} {missing:.3e} of the domain away from its border; it was \
                     extended straight to the border"
                )
            }
            Self::CrossesItself { curve } => write!(f, "trimming curve {curve} crosses or touches itself"),
        }
    }
}
