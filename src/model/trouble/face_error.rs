//! Why a face cannot be used as stated.

use super::region_error::RegionError;
use super::step::StepCause;
use crate::model::{SurfaceError, TrimError};
use glam::{DVec2, DVec3};
use std::fmt;

/// Why a face cannot be used as stated.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum FaceError {
    /// The surface is unsound.
    Surface(SurfaceError),
    /// The surface was not read, for this reason.
    Refused(StepCause),
    /// The loops bound no region.
    Region(RegionError),
    /// Where the region must be cut the winding numbers of the loops do not add up, whatever the cuts.
    Tangled {
        /// Where, (u, v).
        at: DVec2,
        /// Where in space, millimetres.
        place: DVec3,
    },
    /// The boundary is nowhere near the surface.
    OffSurface {
        /// Largest distance between edges and surface, millimetres.
        gap_mm: f64,
        /// Size of the face, millimetres.
        extent_mm: f64,
    },
    /// No loop has a lobe that runs backwards.
    NoLobes,
    /// A defect of this crate.
    Internal(String),
    /// A free trimming curve is unsound.
    Trim {
        /// Which of the face's curves.
        curve: usize,
        /// Why.
        error: TrimError,
    },
    /// Free trims on a surface without extent, or whose curves have none where the surface does not end.
    NoDomain {
        /// Lower corner of what they reach, (u, v).
        low: DVec2,
        /// Upper corner.
        high: DVec2,
    },
    /// Free trims keep a part of the surface that does not end.
    Unbounded {
        /// The direction: 0 for u, 1 for v.
        axis: usize,
    },
    /// Free trims cannot be told apart.
    TrimsTangled {
        /// Where, (u, v).
        at: DVec2,
        /// Where in space, millimetres.
        place: DVec3,
    },
    /// The trims keep nothing of the face.
    NothingKept,
    /// The surface is a point or a curve.
    NoArea {
        /// Size of the box around it, millimetres.
        size_mm: f64,
    },
    /// The surface is smaller than the spacing of numbers where it is.
    Unresolved {
        /// Its width, millimetres.
        size_mm: f64,
        /// Largest coordinate, millimetres.
        coordinates_mm: f64,
    },
    /// Products of its coordinates overflow.
    TooLarge {
        /// Largest coordinate, millimetres.
        coordinates_mm: f64,
    },
    /// The region has no extent in one direction.
    Thin {
        /// The direction: 0 for u, 1 for v.
        axis: usize,
        /// The extent, in the surface's parameter.
        extent: f64,
    },
}

codes!(FaceError {
    Self::Surface(_) => "face-surface-unsound",
    Self::Refused(_) => "face-surface-not-read",
    Self::Tangled { .. } => "face-not-cut",
    Self::OffSurface { .. } => "face-off-surface",
    Self::NoLobes => "face-without-lobes",
    Self::Internal(_) => "face-internal-error",
    Self::Trim { .. } => "trim-unsound",
    Self::NoDomain { .. } => "trims-without-extent",
    Self::Unbounded { .. } => "trims-unbounded",
    Self::TrimsTangled { .. } => "trims-tangled",
    Self::NothingKept => "trims-keep-nothing",
    Self::NoArea { .. } => "face-without-area",
    Self::Unresolved { .. } => "face-below-resolution",
    Self::TooLarge { .. } => "face-too-large",
    Self::Thin { .. } => "face-thin";
    RegionError in Self::Region(error) => error
});

impl fmt::Display for FaceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Surface(e) => e.fmt(f),
            Self::Refused(cause) => write!(f, "the surface was not read: {cause}"),
            Self::Region(e) => e.fmt(f),
            Self::Tangled { at, .. } => {
                write!(f, "the boundary cannot be cut around (u, v) = ({:.6}, {:.6})", at.x, at.y)
            }
            Self::OffSurface { gap_mm, extent_mm } => {
                write!(f, "edges lie {gap_mm:.3e} mm off the surface of a face of {extent_mm:.3e} mm")
            }
            Self::NoLobes => write!(f, "no lobe of the boundary runs backwards"),
            Self::Internal(what) => write!(f, "internal error: {what}"),
            Self::Trim { curve, error } => write!(f, "free trimming curve {curve}: {error}"),
            Self::NoDomain { low, high } => write!(
                f,
                "free trims need a surface or curves with an extent; these reach from ({}, {}) to ({}, {}) in (u, v)",
                low.x, low.y, high.x, high.y
            ),
            Self::Unbounded { axis } => write!(
                f,
                "the trimming curves keep a part that does not end in {}, and neither does the surface",
                ['u', 'v'][*axis]
            ),
            Self::TrimsTangled { at, .. } => {
                write!(f, "the trimming curves cannot be told apart around (u, v) = ({:.6}, {:.6})", at.x, at.y)
            }
            Self::NothingKept => write!(f, "the trimming curves keep nothing of the face"),
            Self::NoArea { size_mm } => {
                write!(f, "the surface has no area: it is a point or a curve within a box of {size_mm:e} mm")
            }
            Self::Unresolved { size_mm, coordinates_mm } => write!(
                f,
                "the surface is {size_mm:e} mm wide, which numbers cannot tell apart at coordinates of {coordinates_mm:e} mm"
            ),
            Self::TooLarge { coordinates_mm } => {
                write!(f, "coordinates of {coordinates_mm:e} mm are too large to calculate with")
            }
            Self::Thin { axis, extent } => {
                write!(f, "the kept region is only {extent:e} wide in {}", ['u', 'v'][*axis])
            }
        }
    }
}

impl FaceError {
    /// Whether seams that are taken for boundaries may be the cause.
    pub(crate) fn may_be_seams(&self) -> bool {
        matches!(self, Self::Region(_) | Self::Tangled { .. })
    }

    /// Where, if it is anywhere more than elsewhere on the face.
    #[must_use]
    pub fn place(&self) -> Option<DVec3> {
        match self {
            Self::Tangled { place, .. } | Self::TrimsTangled { place, .. } => Some(*place),
            _ => None,
        }
    }
}

impl From<RegionError> for FaceError {
    fn from(e: RegionError) -> Self {
        Self::Region(e)
    }
}
