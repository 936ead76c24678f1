//! Why a face cannot be meshed as stated.

use super::region_error::RegionError;
use super::step::StepCause;
use crate::model::{SurfaceError, TrimError};
use glam::{DVec2, DVec3};

/// Why a face cannot be meshed as stated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FaceError {
    /// The surface is invalid.
    #[error(transparent)]
    Surface(SurfaceError),
    /// The surface was not read.
    #[error("the surface was not read: {0}")]
    Refused(StepCause),
    /// The loops enclose no region.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// The region cannot be cut into tiles: the winding numbers of its loops do not add up there, whatever the cuts.
    #[error("the face cannot be cut into tiles at (u, v) = ({:.6}, {:.6})", .at.x, .at.y)]
    Tangled {
        /// Where, (u, v).
        at: DVec2,
        /// Where in space, millimetres.
        place: DVec3,
    },
    /// The edges are nowhere near the surface.
    #[error("edges lie {gap_mm:.3e} mm off the surface; the face is {extent_mm:.3e} mm across")]
    OffSurface {
        /// Largest distance between edges and surface, millimetres.
        gap_mm: f64,
        /// Size of the face, millimetres.
        extent_mm: f64,
    },
    /// No lobe of the boundary runs backwards.
    #[error("no lobe of the boundary runs backwards")]
    NoLobes,
    /// A bug in this crate.
    #[error("internal error: {0}")]
    Internal(String),
    /// A free trimming curve is invalid.
    #[error("free trimming curve {curve}: {error}")]
    Trim {
        /// Which of the face's curves.
        curve: usize,
        /// Why.
        error: TrimError,
    },
    /// Free trims have no domain: the surface has no extent, or is unbounded where the curves have no extent.
    #[error(
        "free trims need a surface or curves with an extent; these extend from ({}, {}) to ({}, {}) in (u, v)",
        .low.x, .low.y, .high.x, .high.y
    )]
    NoDomain {
        /// Lower corner of their box, (u, v).
        low: DVec2,
        /// Upper corner of their box, (u, v).
        high: DVec2,
    },
    /// Free trims keep an unbounded part of the surface.
    #[error("the trimming curves keep a part that is unbounded in {}, and so is the surface", ['u', 'v'][*.axis])]
    Unbounded {
        /// The direction: 0 for u, 1 for v.
        axis: usize,
    },
    /// Free trimming curves are too close to each other to be separated.
    #[error("the trimming curves cannot be separated around (u, v) = ({:.6}, {:.6})", .at.x, .at.y)]
    TrimsTangled {
        /// Where, (u, v).
        at: DVec2,
        /// Where in space, millimetres.
        place: DVec3,
    },
    /// Free trims keep nothing of the face.
    #[error("the trimming curves keep nothing of the face")]
    NothingKept,
    /// The surface is a point or a curve.
    #[error("the surface has no area: it is a point or a curve within a box of {size_mm:e} mm")]
    NoArea {
        /// Size of the box around it, millimetres.
        size_mm: f64,
    },
    /// The surface is smaller than the spacing of numbers at its coordinates.
    #[error("the surface is {size_mm:e} mm wide, below the spacing of numbers at coordinates of {coordinates_mm:e} mm")]
    Unresolved {
        /// Its width, millimetres.
        size_mm: f64,
        /// Largest coordinate, millimetres.
        coordinates_mm: f64,
    },
    /// Products of its coordinates overflow.
    #[error("coordinates of {coordinates_mm:e} mm are too large: their products overflow")]
    TooLarge {
        /// Largest coordinate, millimetres.
        coordinates_mm: f64,
    },
    /// The region has no extent in one direction.
    #[error("the region is only {extent:e} wide in {}", ['u', 'v'][*.axis])]
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
