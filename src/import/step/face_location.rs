//! Surfaces as stated in the file, the place of a face on them, and pieces of unbounded curves that cover the face.

use super::curve::Carrier;
use crate::model::{Frame3, NurbsCurve3, Severity, StepOutcome, Surface};
use glam::DVec3;

/// Points that locate a face's boundary.
#[derive(Clone, Debug, Default)]
pub(super) struct FaceLocation {
    /// Points whose hull contains the boundary.
    pub(super) hull: Vec<DVec3>,
    /// Points on the boundary.
    pub(super) on: Vec<DVec3>,
}

impl FaceLocation {
    /// With all points within `distance` of it in the hull.
    pub(super) fn grown(self, distance: f64) -> Self {
        // The octahedron with these corners contains the ball.
        let ways = DVec3::AXES.map(|axis| axis * (3.0_f64.sqrt() * distance));
        let around = |p: DVec3| ways.into_iter().flat_map(move |way| [p - way, p + way]);
        Self { hull: self.hull.into_iter().flat_map(around).collect(), on: self.on }
    }
}

/// Locates the face. Called only to bound a sweep of an unbounded curve or to choose one of several sheets.
pub(super) type LocateFace<'a> = &'a dyn Fn() -> FaceLocation;

/// A surface, and how it differs from the file's.
#[derive(Clone, Debug)]
pub(super) struct Stated {
    pub(super) surface: Surface,
    /// Whether its normal is opposite to the stated surface's.
    pub(super) turned: bool,
    /// The difference from the file to report, with its severity.
    pub(super) note: Option<(Severity, StepOutcome)>,
}

impl Stated {
    pub(super) fn exact(surface: Surface) -> Self {
        Self { surface, turned: false, note: None }
    }
}

/// The part of an unbounded conic whose sweep covers all of `reach`. `flat` moves a point into the conic's plane.
pub(super) fn reaching(
    carrier: &Carrier,
    reach: &[DVec3],
    flat: impl Fn(&DVec3, &Frame3) -> DVec3,
) -> Option<NurbsCurve3> {
    let (Carrier::Hyperbola { frame, .. } | Carrier::Parabola { frame, .. }) = carrier else { return None };
    let (low, high) = extent(reach.iter().map(|p| carrier.parameter(flat(p, frame))))?;
    Some(carrier.arc(widened(low, high)?))
}

/// Smallest and largest value; `None` without values.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
    (low <= high).then_some((low, high))
}

/// Widens a range by a thousandth and rounding on each side. `None` if the result is not finite or empty.
pub(super) fn widened(low: f64, high: f64) -> Option<(f64, f64)> {
    let margin = 1e-3 * (high - low) + 4.0 * f64::EPSILON * low.abs().max(high.abs());
    let range = (low - margin, high + margin);
    (range.0 < range.1 && (range.1 - range.0).is_finite()).then_some(range)
}
