//! NURBS curves in 2D and 3D, and the frames of arcs, conics and analytic surfaces.

use super::knots::{self, MOST_TURNS};
use glam::{DVec2, DVec3};
use std::fmt::Debug;
use std::ops::{Add, Mul, Sub};

/// A right-handed orthonormal frame: `z = x × y`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame3 {
    /// Origin, in the part's length unit (millimetres).
    pub origin: DVec3,
    /// First axis, unit length.
    pub x: DVec3,
    /// Second axis, unit length.
    pub y: DVec3,
    /// Third axis (the axis of revolution, the normal of a plane), unit length.
    pub z: DVec3,
}

impl Frame3 {
    /// The world frame.
    pub const WORLD: Self = Self { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };

    /// Makes the frame with its third axis along `axis` and its first axis as near to `reference` as possible.
    ///
    /// `None` if `axis` has no direction. A `reference` parallel to `axis` is replaced by any perpendicular.
    #[must_use]
    pub fn from_axis(origin: DVec3, axis: DVec3, reference: DVec3) -> Option<Self> {
        let z = axis.try_normalize()?;
        let across = reference - z * reference.dot(z);
        let x = if across.length() > 1e-9 * reference.length() {
            across.try_normalize()?
        } else {
            z.any_orthonormal_vector()
        };
        Some(Self { origin, x, y: z.cross(x), z })
    }

    /// Converts local coordinates to a point in space.
    #[must_use]
    pub fn place(&self, local: DVec3) -> DVec3 {
        self.origin + self.x * local.x + self.y * local.y + self.z * local.z
    }

    /// Converts a point in space to local coordinates.
    #[must_use]
    pub fn local(&self, point: DVec3) -> DVec3 {
        let d = point - self.origin;
        DVec3::new(d.dot(self.x), d.dot(self.y), d.dot(self.z))
    }

    /// Distance of a point in space from the axis `z`, and its height above the origin along that axis.
    #[must_use]
    pub fn meridian(&self, point: DVec3) -> DVec2 {
        let local = self.local(point);
        DVec2::new(libm::hypot(local.x, local.y), local.z)
    }

    /// The vector from the axis `z` to a point in space, perpendicular to the axis.
    #[must_use]
    pub fn radial(&self, point: DVec3) -> DVec3 {
        let out = point - self.origin;
        out - self.z * out.dot(self.z)
    }
}

/// A NURBS curve. `P` is [`DVec3`] for curves in space, [`DVec2`] for pcurves.
///
/// `degree ≥ 1`; `knots.len() == points.len() + degree + 1`, finite, non-decreasing, interior multiplicity ≤ degree
/// (clamped or not); `weights` is empty (all 1) or one number from 1e-30 to 1e30 per control point.
/// Domain: `[knots[degree], knots[points.len()]]`. Functions of a curve for which [`check`](Self::check) fails may
/// panic.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsCurve<P> {
    /// Polynomial degree.
    pub degree: usize,
    /// Knots, repeated by multiplicity.
    pub knots: Vec<f64>,
    /// Euclidean control points, not multiplied by weights.
    pub points: Vec<P>,
    /// Weights, or empty for a polynomial curve.
    pub weights: Vec<f64>,
}

impl<P> NurbsCurve<P> {
    /// The Bézier curve of these control points, over the parameters 0 to 1. `weights` is empty for a polynomial one.
    #[must_use]
    pub fn bezier(points: Vec<P>, weights: Vec<f64>) -> Self {
        let degree = points.len().saturating_sub(1);
        Self { degree, knots: knots::knots_of_pieces(degree, &[0.0, 1.0]), points, weights }
    }
}

/// A curve in space.
pub type NurbsCurve3 = NurbsCurve<DVec3>;
/// A curve in a surface's (u,v).
pub type NurbsCurve2 = NurbsCurve<DVec2>;

/// Arithmetic of control points, implemented by [`DVec2`] and [`DVec3`].
pub trait ControlPoint:
    Copy + Debug + PartialEq + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self>
{
    /// The origin.
    const ORIGIN: Self;
    /// Euclidean length.
    fn norm(self) -> f64;
    /// Scalar product.
    fn inner(self, other: Self) -> f64;
    /// Whether all coordinates are finite.
    fn finite(self) -> bool;
}

macro_rules! control_points {
    ($($vector:ident),*) => {
        $(impl ControlPoint for $vector {
            const ORIGIN: Self = Self::ZERO;
            fn norm(self) -> f64 {
                self.length()
            }
            fn inner(self, other: Self) -> f64 {
                self.dot(other)
            }
            fn finite(self) -> bool {
                self.is_finite()
            }
        })*
    };
}

control_points!(DVec2, DVec3);

/// A curve point with the first and second derivative by the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveDerivatives<P> {
    /// `C(t)`.
    pub point: P,
    /// `C'(t)`.
    pub d1: P,
    /// `C''(t)`.
    pub d2: P,
}

/// Smallest change of tangent direction that counts as a kink, radians. Below it, a "kink" is rounding: files print
/// knots and points with 6-15 digits.
const KINK: f64 = 1e-6;

impl<P: ControlPoint> NurbsCurve<P> {
    /// First and last parameter.
    #[must_use]
    pub fn domain(&self) -> (f64, f64) {
        knots::domain(self.degree, &self.knots)
    }

    /// `C(t)`, with `t` clamped to the domain. Bit-identical to [`derivatives`](Self::derivatives).
    #[must_use]
    pub fn point(&self, t: f64) -> P {
        let [point, ..] = self.orders::<1>(t);
        point
    }

    /// `C(t)` and `C'(t)`, bit-identical to [`derivatives`](Self::derivatives).
    #[must_use]
    pub fn tangent(&self, t: f64) -> [P; 2] {
        let [point, d1, _] = self.orders::<2>(t);
        [point, d1]
    }

    /// `C(t)`, `C'(t)`, `C''(t)`, with `t` clamped to the domain.
    ///
    /// Exact also for rational curves. At a knot, uses the span that starts there; at the domain's end, the span that
    /// ends there. O(degree²); no allocation up to degree 25.
    #[must_use]
    pub fn derivatives(&self, t: f64) -> CurveDerivatives<P> {
        let [point, d1, d2] = self.orders::<3>(t);
        CurveDerivatives { point, d1, d2 }
    }

    /// The point and derivatives of orders below `ROWS`; the rest are meaningless.
    fn orders<const ROWS: usize>(&self, t: f64) -> [P; 3] {
        let (a, b) = self.domain();
        let t = t.max(a).min(b);
        if let ([p, q], [], [_, low, high, _], 1) = (&self.points[..], &self.weights[..], &self.knots[..], self.degree)
            && low < high
        {
            return segment::<P, ROWS>([*p, *q], (t - low) / (high - low), high - low);
        }
        self.orders_on::<ROWS>(knots::span(self.degree, &self.knots, t), t)
    }

    /// Like [`orders`](Self::orders), of the polynomial piece on knot span `span`.
    fn orders_on<const ROWS: usize>(&self, span: usize, t: f64) -> [P; 3] {
        knots::with_basis::<ROWS, _>(self.degree, &self.knots, span, t, |rows| self.weighted::<ROWS>(span, rows))
    }

    /// Like [`orders_on`](Self::orders_on), from the basis `rows` on `span`.
    #[inline]
    fn weighted<const ROWS: usize>(&self, span: usize, rows: &[f64]) -> [P; 3] {
        // Known degrees let the loops unroll. Nearly all curves have one of these.
        match self.degree {
            1 => self.combined::<ROWS>(1, span, rows),
            2 => self.combined::<ROWS>(2, span, rows),
            3 => self.combined::<ROWS>(3, span, rows),
            degree => self.combined::<ROWS>(degree, span, rows),
        }
    }

    #[inline(always)]
    fn combined<const ROWS: usize>(&self, degree: usize, span: usize, rows: &[f64]) -> [P; 3] {
        let n = degree + 1;
        let first = span - degree;
        let (points, rows) = (&self.points[first..][..n], &rows[..ROWS * n]);
        let mut sum = [P::ORIGIN; 3];
        if self.weights.is_empty() {
            for (j, &p) in points.iter().enumerate() {
                for order in 0..ROWS {
                    sum[order] = sum[order] + p * rows[order * n + j];
                }
            }
            return sum;
        }
        let mut w = [0.0; 3];
        for ((j, &p), &weight) in points.iter().enumerate().zip(&self.weights[first..][..n]) {
            for order in 0..ROWS {
                let value = weight * rows[order * n + j];
                sum[order] = sum[order] + p * value;
                w[order] += value;
            }
        }
        let per = 1.0 / w[0];
        let point = sum[0] * per;
        let d1 = (sum[1] - point * w[1]) * per;
        let d2 = (sum[2] - point * w[2] - d1 * (2.0 * w[1])) * per;
        [point, d1, d2]
    }

    /// Reverses the curve over the same domain `[a, b]`: `reversed.point(t)` is `point(a + b - t)`.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let (a, b) = self.domain();
        // `a + b - b` may differ from `a` in the last digit.
        let turned = |&k: &f64| match k {
            _ if k == a => b,
            _ if k == b => a,
            _ => a + b - k,
        };
        Self {
            degree: self.degree,
            knots: self.knots.iter().rev().map(turned).collect(),
            points: self.points.iter().rev().copied().collect(),
            weights: self.weights.iter().rev().copied().collect(),
        }
    }

    /// Inner knots where the tangent direction changes by more than a microradian, increasing.
    ///
    /// Only knots of multiplicity ≥ degree can be kinks. In arcs and Bézier chains many of them are smooth.
    #[must_use]
    pub fn kinks(&self) -> Vec<f64> {
        if self.points.len() <= self.degree + 1 {
            // One span.
            return Vec::new();
        }
        let (a, b) = self.domain();
        let sharp =
            |equal: &[f64]| equal.len() >= self.degree && equal[0] > a && equal[0] < b && self.breaks_at(equal[0]);
        self.knots.chunk_by(|a, b| a == b).filter(|equal| sharp(equal)).map(|equal| equal[0]).collect()
    }

    /// Whether the tangents on both sides of the knot `t` differ in direction.
    fn breaks_at(&self, t: f64) -> bool {
        let before = knots::span_left(self.degree, &self.knots, t);
        let after = knots::span(self.degree, &self.knots, t);
        let left = self.tangent_on(before, t, self.knots[before] - t);
        let right = self.tangent_on(after, t, self.knots[after + 1] - t);
        let (l, r) = (left.norm(), right.norm());
        if l == 0.0 || r == 0.0 {
            return false;
        }
        (left * (1.0 / l) - right * (1.0 / r)).norm() > KINK
    }

    /// The tangent of the piece on `span` at its end `t`. Where it vanishes, the chord over a thousandth of the signed
    /// length `inside`, which leads into the span.
    fn tangent_on(&self, span: usize, t: f64, inside: f64) -> P {
        let [point, d1, d2] = self.orders_on::<3>(span, t);
        if d1.norm() * inside.abs() > 1e-9 * d2.norm() * inside * inside {
            return d1;
        }
        let [near, ..] = self.orders_on::<1>(span, t + 1e-3 * inside);
        (near - point) * inside.signum()
    }
}

/// [`NurbsCurve::orders`] of a line of two points, whose domain is `width` long, at the share `x` of it: half of all
/// edges. Has the bits of the sums over the basis.
fn segment<P: ControlPoint, const ROWS: usize>([p, q]: [P; 2], x: f64, width: f64) -> [P; 3] {
    let sum = |f: f64, g: f64| P::ORIGIN + p * f + q * g;
    let slope = 1.0 / width;
    let row = |order: usize, f: f64, g: f64| if order < ROWS { sum(f, g) } else { P::ORIGIN };
    [sum(1.0 - x, x), row(1, -slope, slope), row(2, 0.0, 0.0)]
}

impl NurbsCurve3 {
    /// The segment from `a` to `b`, over the parameters 0 to 1.
    #[must_use]
    pub fn line(a: DVec3, b: DVec3) -> Self {
        Self::bezier(vec![a, b], Vec::new())
    }

    /// The elliptic arc `O + rx cos t · x + ry sin t · y` for angles from `a0` to `a1 > a0`, as an exact rational
    /// quadratic.
    ///
    /// Has equal spans of at most 90° with double inner knots. The parameter equals the angle at span ends; between
    /// them, [`AxisMap::Arc`](super::AxisMap) maps one to the other. Angles may cover more than one turn.
    #[must_use]
    pub fn arc(frame: &Frame3, rx: f64, ry: f64, a0: f64, a1: f64) -> Self {
        let net = ArcNet::new(a0, a1);
        let points = net.rays.iter().map(|r| frame.place(DVec3::new(rx * r.x, ry * r.y, 0.0))).collect();
        Self { degree: 2, knots: net.knots, points, weights: net.weights }
    }
}

/// The control polygon of a unit arc: rational quadratic, spans of at most 90°.
pub(super) struct ArcNet {
    pub(super) spans: usize,
    pub(super) step: f64,
    pub(super) knots: Vec<f64>,
    /// Control points; those between span ends lie at radius `1 / cos(step / 2)`.
    pub(super) rays: Vec<DVec2>,
    pub(super) weights: Vec<f64>,
}

impl ArcNet {
    pub(super) fn new(a0: f64, a1: f64) -> Self {
        let sweep = a1 - a0;
        // A sweep of k·90° plus rounding takes k spans.
        let wanted = (sweep / std::f64::consts::FRAC_PI_2 - 1e-9).ceil();
        // NaN takes one, so that counts agree; `check` refuses it.
        let wanted = if wanted.is_nan() { 1.0 } else { wanted.clamp(1.0, 4.0 * MOST_TURNS) };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 1..=80_000")]
        let spans = wanted as usize;
        let step = sweep / wanted;
        let half = 0.5 * step;
        let knot = |i: usize| if i == spans { a1 } else { a0 + step * i as f64 };
        let ray = |a: f64| DVec2::new(libm::cos(a), libm::sin(a));
        let room = 2 * spans + 1;
        let mut net = Self {
            spans,
            step,
            knots: Vec::with_capacity(room + 3),
            rays: Vec::with_capacity(room),
            weights: Vec::with_capacity(room),
        };
        net.knots.push(a0);
        net.rays.push(ray(a0));
        net.weights.push(1.0);
        for i in 0..spans {
            net.knots.extend([knot(i), knot(i)]);
            net.rays.extend([ray(knot(i) + half) / libm::cos(half), ray(knot(i + 1))]);
            net.weights.extend([libm::cos(half), 1.0]);
        }
        net.knots.extend([a1; 3]);
        // A full turn closes bit for bit.
        if (sweep - std::f64::consts::TAU).abs() < 1e-12 {
            let first = net.rays[0];
            if let Some(last) = net.rays.last_mut() {
                *last = first;
            }
        }
        net
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;

    #[test]
    fn arcs_of_many_turns_have_spans_of_at_most_a_right_angle() {
        for turns in [1.0, 1024.0, 5000.0, MOST_TURNS] {
            let arc = NurbsCurve3::arc(&Frame3::WORLD, 1.0, 1.0, 0.0, turns * std::f64::consts::TAU);
            assert_eq!(arc.points.len(), 2 * (4.0 * turns) as usize + 1);
        }
    }

    #[test]
    fn lines_have_the_bits_of_the_basis() {
        let mut draw = SplitMix(11);
        for _ in 0..200 {
            let [a, b] = [0, 1].map(|_| DVec3::new(draw.range(-9.0, 9.0), -0.0, draw.range(-1e-3, 1e3)));
            let (low, width) = (draw.range(-5.0, 5.0), draw.range(1e-3, 50.0));
            let line = NurbsCurve3 { knots: vec![low, low, low + width, low + width], ..NurbsCurve3::line(a, b) };
            for t in [low, low + 0.3 * width, low + draw.unit() * width, low + width] {
                let bits = |all: [DVec3; 3]| all.map(|p| p.to_array().map(f64::to_bits));
                let [basis, sum] = [line.orders_on::<3>(1, t), line.orders::<3>(t)];
                assert_eq!(bits(sum), bits(basis), "{line:?} {t}");
                assert_eq!((line.point(t), line.tangent(t)), (sum[0], [sum[0], sum[1]]));
            }
        }
    }
}
