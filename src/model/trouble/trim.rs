//! What was done to free trimming curves that do not bound a region as stated.

use std::fmt;

/// What was done to a free trimming curve.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum TrimTrouble {
    /// It leaves the surface's domain and was clipped there.
    Clipped {
        /// Which of the face's curves.
        curve: usize,
    },
    /// It is open, starts or ends inside the domain, and was extended straight to the border.
    Extended {
        /// Which of the face's curves.
        curve: usize,
        /// Whether at its end, not at its start.
        at_end: bool,
        /// How far from the border it stops, as a share of the domain.
        missing: f64,
    },
    /// It crosses or touches itself.
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
            Self::Clipped { curve } => write!(f, "trimming curve {curve} leaves the domain; it was clipped there"),
            Self::Extended { curve, at_end, missing } => {
                let stops = if *at_end { "ends" } else { "starts" };
                write!(
                    f,
                    "open trimming curve {curve} {stops} {missing:.3e} of the domain inside its border; it was extended \
                     straight to it"
                )
            }
            Self::CrossesItself { curve } => write!(f, "trimming curve {curve} crosses or touches itself"),
        }
    }
}
