//! Surfaces as stated in the file, the place of a face on them, and what covers the face: pieces of unbounded curves,
//! the part of a surface's domain.

use super::curve::Carrier;
use crate::math::solve::least_squares;
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

/// First and last parameter.
pub(super) type Range = (f64, f64);

/// The part is wider than the boundary points by this share: the boundary bulges between them.
const MARGIN: f64 = 1e-2;
/// Boundary points further than this share of the boundary's size from the surface are not on it.
const ON_SURFACE: f64 = 1e-3;
/// Lines of the lattice from which points are looked for, per direction: at least one per knot span up to the maximum.
const LINES: usize = 64;
const MAX_LINES: usize = 256;
/// Maximum number of boundary points, since each is compared with the whole lattice.
const MAX_POINTS: usize = 256;
const MAX_STEPS: usize = 30;

/// The part of the domain that contains the face with boundary points `on`. `at` is a surface with the parameters of
/// `base`, which is a net; `None` where it has no point.
///
/// `None` if a boundary point is not found on the surface.
pub(super) fn face_part(base: &Surface, on: &[DVec3], at: impl Fn(f64, f64) -> Option<DVec3>) -> Option<[Range; 2]> {
    let search = Search { domain: base.natural_domain(), period: base.period(), at };
    let [us, vs] = base.breaks().map(|breaks| lines(&breaks));
    let lattice: Vec<([f64; 2], DVec3)> = us
        .iter()
        .flat_map(|u| vs.iter().map(move |v| [*u, *v]))
        .filter_map(|uv| Some((uv, search.point(uv)?)))
        .collect();
    let first = *on.first()?;
    let near = ON_SURFACE * on.iter().map(|p| p.distance(first)).fold(0.0, f64::max);
    let mut images = Vec::with_capacity(MAX_POINTS);
    for p in on.iter().step_by(on.len().div_ceil(MAX_POINTS)) {
        let away = |(_, q): &&([f64; 2], DVec3)| q.distance_squared(*p);
        let (start, _) = lattice.iter().min_by(|a, b| away(a).total_cmp(&away(b)))?;
        images.push(search.image(*p, *start, near)?);
    }
    let mut part = search.domain;
    // A boundary in a closed direction may cross the seam.
    for axis in (0..2).filter(|axis| search.period[*axis].is_none()) {
        let (low, high) = search.domain[axis];
        // A boundary that goes round a pole encloses it.
        let round = search.period[1 - axis].is_some();
        let poles = base.poles().into_iter().filter(|pole| round && pole.axis == axis).map(|pole| pole.at);
        let (from, to) = extent(images.iter().map(|image| image[axis]).chain(poles))?;
        let margin = MARGIN * (to - from);
        part[axis] = (low.max(from - margin), high.min(to + margin));
    }
    part.iter().all(|(from, to)| from < to).then_some(part)
}

/// Ends of equal pieces of the spans between breaks.
fn lines(breaks: &[f64]) -> Vec<f64> {
    let spans = breaks.len().saturating_sub(1).max(1);
    let pieces = LINES.div_ceil(spans);
    let inside = |ends: &[f64]| {
        let (from, step) = (ends[0], (ends[1] - ends[0]) / pieces as f64);
        (0..pieces).map(move |i| from + step * i as f64)
    };
    let all: Vec<f64> = breaks.windows(2).flat_map(inside).chain(breaks.last().copied()).collect();
    let every = all.len().div_ceil(MAX_LINES);
    all.into_iter().step_by(every).collect()
}

struct Search<F> {
    domain: [Range; 2],
    period: [Option<f64>; 2],
    at: F,
}

impl<F: Fn(f64, f64) -> Option<DVec3>> Search<F> {
    fn point(&self, [u, v]: [f64; 2]) -> Option<DVec3> {
        (self.at)(u, v).filter(|p| p.is_finite())
    }

    /// The parameters moved into the domain.
    fn inside(&self, uv: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| {
            let ((low, high), t) = (self.domain[axis], uv[axis]);
            match self.period[axis] {
                Some(period) => low + (t - low).rem_euclid(period),
                None => t.clamp(low, high),
            }
        })
    }

    /// Tangent along `axis`, by differences.
    fn slope(&self, uv: [f64; 2], axis: usize) -> Option<DVec3> {
        let (low, high) = self.domain[axis];
        let step = 1e-6 * (high - low);
        let moved = |by: f64| {
            let mut uv = uv;
            uv[axis] = (uv[axis] + by).clamp(low, high);
            Some((uv[axis], self.point(uv)?))
        };
        let ((a, p), (b, q)) = (moved(-step)?, moved(step)?);
        Some((q - p) / (b - a))
    }

    /// Parameters of the point of the surface nearest to `p`, by Gauss-Newton steps from `uv`. `None` if that point is
    /// further than `near`.
    fn image(&self, p: DVec3, mut uv: [f64; 2], near: f64) -> Option<[f64; 2]> {
        let mut at = self.point(uv)?;
        for _ in 0..MAX_STEPS {
            let (du, dv) = (self.slope(uv, 0)?, self.slope(uv, 1)?);
            let step = least_squares(du, dv, p - at);
            let halved = (0..8).find_map(|k| {
                let share = 0.5_f64.powi(k);
                let uv = self.inside([uv[0] + share * step.x, uv[1] + share * step.y]);
                Some((uv, self.point(uv)?)).filter(|(_, moved)| moved.distance(p) < at.distance(p))
            });
            let Some(closer) = halved else { break };
            (uv, at) = closer;
        }
        (at.distance(p) <= near).then_some(uv)
    }
}
