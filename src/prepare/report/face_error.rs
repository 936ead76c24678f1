//! Why a face cannot be used, in words with numbers.

use super::refusals::{NoRegion, RegionError, Tangled};
use crate::model::{SurfaceError, TrimError};
use glam::{DVec2, DVec3};
use std::fmt;

/// Why a face cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum FaceError {
    /// The surface is none.
    Surface(SurfaceError),
    /// The surface was not read, for this reason.
    Refused(String),
    /// No region.
    Region(RegionError),
    /// Where the region must be cut open the windings of the loops do not add up, whatever the cuts.
    Tangled { refused: Tangled, place: DVec3 },
    /// The boundary is nowhere near the surface.
    OffSurface { gap: f64, extent: f64 },
    /// No loop has a lobe that runs backwards.
    NoLobes,
    /// Something that cannot happen did.
    Internal(String),
    /// A free trimming curve is none.
    Trim { curve: usize, error: TrimError },
    /// Free trims on a surface without extent, or whose curves have none where the surface does not end.
    NoDomain { low: DVec2, high: DVec2 },
    /// Free trims keep a part of a surface that does not end in direction 0 (u) or 1 (v).
    Unbounded { axis: usize },
    /// Free trims that cannot be told apart.
    Untold { error: NoRegion, place: DVec3 },
    /// The trims keep nothing of the face.
    NothingKept,
    /// The surface is a point or a curve.
    NoArea { size: f64 },
    /// The surface is smaller than the spacing of numbers where it is.
    Unresolved { size: f64, coordinates: f64 },
    /// Products of its coordinates are no numbers.
    TooLarge { coordinates: f64 },
    /// The region has no extent in direction 0 (u) or 1 (v).
    Thin { axis: usize, extent: f64 },
}

impl fmt::Display for FaceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Surface(e) => e.fmt(f),
            Self::Refused(reason) => write!(f, "the surface was not read: {reason}"),
            Self::Region(e) => e.fmt(f),
            Self::Tangled { refused, .. } => refused.fmt(f),
            Self::OffSurface { gap, extent } => {
                write!(f, "edges lie {gap:.3e} mm off the surface of a face of {extent:.3e} mm")
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
            Self::Untold { error, .. } => error.fmt(f),
            Self::NothingKept => write!(f, "the trimming curves keep nothing of the face"),
            Self::NoArea { size } => {
                write!(f, "the surface has no area: it is a point or a curve within a box of {size:e} mm")
            }
            Self::Unresolved { size, coordinates } => {
                write!(
                    f,
                    "the surface is {size:e} mm wide, which numbers cannot tell apart at coordinates of {coordinates:e} mm"
                )
            }
            Self::TooLarge { coordinates } => {
                write!(f, "coordinates of {coordinates:e} mm are too large to calculate with")
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
    pub(crate) fn place(&self) -> Option<DVec3> {
        match self {
            Self::Tangled { place, .. } | Self::Untold { place, .. } => Some(*place),
            _ => None,
        }
    }
}

impl From<RegionError> for FaceError {
    fn from(e: RegionError) -> Self {
        Self::Region(e)
    }
}
