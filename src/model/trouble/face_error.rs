//! Why a face cannot be meshed as stated.

use super::region_error::RegionError;
use super::step::StepCause;
use crate::model::{SurfaceError, TrimError};
use glam::{DVec2, DVec3};
use std::fmt;

/// Why a face cannot be meshed as stated.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum FaceError {
    /// The surface is invalid.
    Surface(SurfaceError),
    /// The surface was not read.
    Refused(StepCause),
    /// The loops enclose no region.
    Region(RegionError),
    /// The region cannot be cut into tiles: the winding numbers of its loops do not add up there, whatever the cuts.
    Tangled {
        /// Where, (u, v).
        at: DVec2,
        /// Where in space, millimetres.
        place: DVec3,
    },
    /// The edges are nowhere near the surface.
    OffSurface {
        /// Largest distance between edges and surface, millimetres.
        gap_mm: f64,
        /// Size of the face, millimetres.
        extent_mm: f64,
    },
    /// No lobe of the boundary runs backwards.
    NoLobes,
    /// A bug in this crate.
    Internal(String),
    /// A free trimming curve is invalid.
    Trim {
        /// Which of the face's curves.
        curve: usize,
        /// Why.
        error: TrimError,
    },
    /// Free trims have no domain: the surface has no extent, or is unbounded where the curves have no extent.
    NoDomain {
        /// Lower corner of their box, (u, v).
        low: DVec2,
        /// Upper corner of their box, (u, v).
        high: DVec2,
    },
    /// Free trims keep an unbounded part of the surface.
    Unbounded {
        /// The direction: 0 for u, 1 for v.
        axis: usize,
    },
    /// Free trimming curves are too close to each other to be separated.
    TrimsTangled {
        /// Where, (u, v).
        at: DVec2,
        /// Where in space, millimetres.
        place: DVec3,
    },
    /// Free trims keep nothing of the face.
    NothingKept,
    /// The surface is a point or a curve.
    NoArea {
        /// Size of the box around it, millimetres.
        size_mm: f64,
    },
    /// The surface is smaller than the spacing of numbers at its coordinates.
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
                write!(f, "the face cannot be cut into tiles at (u, v) = ({:.6}, {:.6})", at.x, at.y)
            }
            Self::OffSurface { gap_mm, extent_mm } => {
                write!(f, "edges lie {gap_mm:.3e} mm off the surface; the face is {extent_mm:.3e} mm across")
            }
            Self::NoLobes => write!(f, "no lobe of the boundary runs backwards"),
            Self::Internal(what) => write!(f, "internal error: {what}"),
            Self::Trim { curve, error } => write!(f, "free trimming curve {curve}: {error}"),
            Self::NoDomain { low, high } => write!(
                f,
                "free trims need a surface or curves with an extent; these extend from ({}, {}) to ({}, {}) in (u, v)",
                low.x, low.y, high.x, high.y
            ),
            Self::Unbounded { axis } => write!(
                f,
                "the trimming curves keep a part that is unbounded in {}, and so is the surface",
                ['u', 'v'][*axis]
            ),
            Self::TrimsTangled { at, .. } => {
                write!(f, "the trimming curves cannot be separated around (u, v) = ({:.6}, {:.6})", at.x, at.y)
            }
            Self::NothingKept => write!(f, "the trimming curves keep nothing of the face"),
            Self::NoArea { size_mm } => {
                write!(f, "the surface has no area: it is a point or a curve within a box of {size_mm:e} mm")
            }
            Self::Unresolved { size_mm, coordinates_mm } => write!(
                f,
                "the surface is {size_mm:e} mm wide, below the spacing of numbers at coordinates of {coordinates_mm:e} \
                 mm"
            ),
            Self::TooLarge { coordinates_mm } => {
                write!(f, "coordinates of {coordinates_mm:e} mm are too large: their products overflow")
            }
            Self::Thin { axis, extent } => {
                write!(f, "the region is only {extent:e} wide in {}", ['u', 'v'][*axis])
            }
        }
    }
}

impl FaceError {
    /// Whether the cause may be that seams are treated as boundaries.
    pub(crate) fn may_be_seams(&self) -> bool {
        matches!(self, Self::Region(_) | Self::Tangled { .. })
    }

    /// The place in space, millimetres, if the error has one.
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
