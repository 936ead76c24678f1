//! NURBS surfaces -> points, first and second partial derivatives, closure.

use super::{NurbsSurface, knots};
use crate::math::boxes::around;
use crate::math::lanes::{Lanes, Plain, Work, in_fours, widest};
use glam::{DVec2, DVec3};

/// A surface point with its partial derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceDerivatives {
    /// `S(u,v)`.
    pub point: DVec3,
    /// `S_u`.
    pub du: DVec3,
    /// `S_v`.
    pub dv: DVec3,
    /// `S_uu`.
    pub duu: DVec3,
    /// `S_uv`.
    pub duv: DVec3,
    /// `S_vv`.
    pub dvv: DVec3,
}

impl NurbsSurface {
    /// The Bézier patch of these control points (u-major), over the parameters 0 to 1. Degrees are those in u and v;
    /// `weights` is empty for a polynomial patch.
    #[must_use]
    pub fn bezier((degree_u, degree_v): (usize, usize), points: Vec<DVec3>, weights: Vec<f64>) -> Self {
        let [knots_u, knots_v] = [degree_u, degree_v].map(|degree| knots::knots_of_pieces(degree, &[0.0, 1.0]));
        Self { degree_u, degree_v, knots_u, knots_v, points, weights }
    }

    /// Number of control points along u.
    #[must_use]
    pub fn count_u(&self) -> usize {
        self.knots_u.len().saturating_sub(self.degree_u + 1)
    }

    /// Number of control points along v.
    #[must_use]
    pub fn count_v(&self) -> usize {
        self.knots_v.len().saturating_sub(self.degree_v + 1)
    }

    /// The same surface with u and v exchanged.
    pub(crate) fn transposed(&self) -> Self {
        let (nu, nv) = (self.count_u(), self.count_v());
        let order = || (0..nv).flat_map(move |j| (0..nu).map(move |i| i * nv + j));
        Self {
            degree_u: self.degree_v,
            degree_v: self.degree_u,
            knots_u: self.knots_v.clone(),
            knots_v: self.knots_u.clone(),
            points: order().map(|k| self.points[k]).collect(),
            weights: if self.weights.is_empty() { Vec::new() } else { order().map(|k| self.weights[k]).collect() },
        }
    }

    /// First and last parameter in u and in v.
    #[must_use]
    pub fn domain(&self) -> ((f64, f64), (f64, f64)) {
        (knots::domain(self.degree_u, &self.knots_u), knots::domain(self.degree_v, &self.knots_v))
    }

    /// `S(u,v)`, with (u,v) clamped to the domain. Bit-identical to [`derivatives`](Self::derivatives).
    #[must_use]
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        self.orders::<1>(u, v).point
    }

    /// `S(u,v)`, `S_u`, `S_v`, bit-identical to [`derivatives`](Self::derivatives).
    #[must_use]
    pub fn tangents(&self, u: f64, v: f64) -> [DVec3; 3] {
        let SurfaceDerivatives { point, du, dv, .. } = self.orders::<2>(u, v);
        [point, du, dv]
    }

    /// The points at all pairs of `us` and `vs`, u-major, bit-identical to [`point`](Self::point).
    ///
    /// Sums the rows of the net once per v, with the basis of each u made once: a few operations per point on lattices
    /// finer than the net.
    #[must_use]
    pub fn lattice(&self, us: &[f64], vs: &[f64]) -> Vec<DVec3> {
        let ((u0, u1), (v0, v1)) = self.domain();
        let (count_v, nu) = (self.count_v(), self.degree_u + 1);
        let mut out = vec![DVec3::ZERO; us.len() * vs.len()];
        let mut bases = Vec::with_capacity(us.len() * nu);
        let firsts: Vec<usize> = us
            .iter()
            .map(|u| {
                let u = u.max(u0).min(u1);
                let span = knots::span(self.degree_u, &self.knots_u, u);
                knots::with_basis::<1, _>(self.degree_u, &self.knots_u, span, u, |rows| {
                    bases.extend_from_slice(&rows[..nu]);
                });
                span - self.degree_u
            })
            .collect();
        let mut lines = vec![[0.0; 4]; self.count_u()];
        for (j, v) in vs.iter().enumerate() {
            let v = v.max(v0).min(v1);
            let span = knots::span(self.degree_v, &self.knots_v, v);
            knots::with_basis::<1, _>(self.degree_v, &self.knots_v, span, v, |rows| {
                let rows = &rows[..=self.degree_v];
                widest(
                    #[inline(always)]
                    || {
                        for (i, line) in lines.iter_mut().enumerate() {
                            [*line] = self.line(Plain([0.0; 4]), i * count_v + span - self.degree_v, rows).map(|l| l.0);
                        }
                    },
                );
            });
            widest(
                #[inline(always)]
                || {
                    for (i, (first, basis)) in firsts.iter().zip(bases.chunks_exact(nu)).enumerate() {
                        let mut sum = [0.0; 4];
                        for (line, &n) in lines[*first..].iter().zip(basis) {
                            add(&mut sum, n, line);
                        }
                        let p = DVec3::new(sum[0], sum[1], sum[2]);
                        out[i * vs.len() + j] = if self.weights.is_empty() { p } else { p * (1.0 / sum[3]) };
                    }
                },
            );
        }
        out
    }

    /// The line where u (`axis` 0) or v (`axis` 1) is `at`, clamped to the domain.
    pub(crate) fn iso_line(&self, axis: usize, at: f64) -> IsoLine<'_> {
        let ((u0, u1), (v0, v1)) = self.domain();
        let count_v = self.count_v();
        let is_rational = !self.weights.is_empty();
        if axis == 0 {
            let at = at.max(u0).min(u1);
            let span = knots::span(self.degree_u, &self.knots_u, at);
            let mut net = vec![[0.0; 4]; count_v];
            knots::with_basis::<1, _>(self.degree_u, &self.knots_u, span, at, |rows| {
                for (row, &n) in (span - self.degree_u..=span).zip(rows.iter()) {
                    let row = row * count_v..(row + 1) * count_v;
                    let weights = self.weights.get(row.clone()).unwrap_or_default();
                    let weights = weights.iter().copied().chain(std::iter::repeat(1.0));
                    for ((sum, point), weight) in net.iter_mut().zip(&self.points[row]).zip(weights) {
                        add(sum, n * weight, &[point.x, point.y, point.z, 1.0]);
                    }
                }
            });
            return IsoLine { degree: self.degree_v, knots: &self.knots_v, net, is_rational };
        }
        let at = at.max(v0).min(v1);
        let span = knots::span(self.degree_v, &self.knots_v, at);
        let net = knots::with_basis::<1, _>(self.degree_v, &self.knots_v, span, at, |rows| {
            let start = |i: usize| i * count_v + span - self.degree_v;
            let line = |i: usize| self.line::<_, 1>(Plain([0.0; 4]), start(i), rows)[0].0;
            (0..self.count_u()).map(line).collect()
        });
        IsoLine { degree: self.degree_u, knots: &self.knots_u, net, is_rational }
    }

    /// The point and its five partial derivatives, with (u,v) clamped to the domain.
    ///
    /// Exact also for rational surfaces. At a knot, uses the span that starts there. O(degree_u · degree_v); no
    /// allocation up to degree 25.
    #[must_use]
    pub fn derivatives(&self, u: f64, v: f64) -> SurfaceDerivatives {
        self.orders::<3>(u, v)
    }

    /// The point and the derivatives of orders below `ROWS`; the rest are meaningless.
    fn orders<const ROWS: usize>(&self, u: f64, v: f64) -> SurfaceDerivatives {
        let ((u0, u1), (v0, v1)) = self.domain();
        let (u, v) = (u.max(u0).min(u1), v.max(v0).min(v1));
        let span_u = knots::span(self.degree_u, &self.knots_u, u);
        let span_v = knots::span(self.degree_v, &self.knots_v, v);
        knots::with_basis::<ROWS, _>(self.degree_u, &self.knots_u, span_u, u, |rows_u| {
            knots::with_basis::<ROWS, _>(self.degree_v, &self.knots_v, span_v, v, |rows_v| {
                self.weighted::<ROWS>(span_u - self.degree_u, rows_u, span_v - self.degree_v, rows_v)
            })
        })
    }

    /// The point and derivatives of the piece whose first control point is (`row`, `column`), from the bases there.
    fn weighted<const ROWS: usize>(
        &self,
        row: usize,
        rows_u: &[f64],
        column: usize,
        rows_v: &[f64],
    ) -> SurfaceDerivatives {
        let sums = in_fours(PieceSums::<ROWS> { surface: self, at: [row, column], rows_u, rows_v });
        let p = sums.map(|[x, y, z, _]| DVec3::new(x, y, z));
        if self.weights.is_empty() {
            SurfaceDerivatives { point: p[0], du: p[1], dv: p[2], duu: p[3], duv: p[4], dvv: p[5] }
        } else {
            quotient(p, sums.map(|[.., w]| w))
        }
    }

    /// Homogeneous sums of `degree_v + 1` control points from `start` on, for each of `ROWS` rows of a basis. Without
    /// weights the last component means nothing.
    #[inline(always)]
    fn line<F: Lanes<4>, const ROWS: usize>(&self, zero: F, start: usize, rows: &[f64]) -> [F; ROWS] {
        let nv = self.degree_v + 1;
        let mut line = [zero; ROWS];
        let rows: [&[f64]; ROWS] = std::array::from_fn(|order| &rows[order * nv..][..nv]);
        let mut see = |b: usize, point: &DVec3, weight: f64| {
            let point = zero.load(&[point.x, point.y, point.z, 1.0]);
            for (sum, row) in line.iter_mut().zip(&rows) {
                *sum = *sum + zero.splat(row[b] * weight) * point;
            }
        };
        let points = self.points[start..start + nv].iter().enumerate();
        if self.weights.is_empty() {
            points.for_each(|(b, point)| see(b, point, 1.0));
        } else {
            points.zip(&self.weights[start..start + nv]).for_each(|((b, point), &weight)| see(b, point, weight));
        }
        line
    }

    /// The parameters at which the control point nearest to `p` has most influence (Greville): those of the corners at
    /// corners. One pass over the control points.
    pub(crate) fn nearest_control(&self, p: DVec3) -> DVec2 {
        let mut nearest = (f64::INFINITY, 0);
        for (k, point) in self.points.iter().enumerate() {
            let square = point.distance_squared(p);
            if square < nearest.0 {
                nearest = (square, k);
            }
        }
        let mean = |knots: &[f64]| knots.iter().sum::<f64>() / knots.len() as f64;
        let [i, j] = [nearest.1 / self.count_v(), nearest.1 % self.count_v()];
        DVec2::new(mean(&self.knots_u[i + 1..=i + self.degree_u]), mean(&self.knots_v[j + 1..=j + self.degree_v]))
    }

    /// Whether the first and the last line of constant parameter `axis` (0: u, 1: v) coincide within `tol` millimetres.
    ///
    /// # Panics
    /// If `axis` is neither 0 nor 1.
    #[must_use]
    pub fn is_closed(&self, axis: usize, tol: f64) -> bool {
        let (a, b) = <[_; 2]>::from(self.domain())[axis];
        let at = |x: f64, t: f64| self.on_line(axis, x, t);
        self.samples(1 - axis).all(|t| at(a, t).distance(at(b, t)) <= tol)
    }

    /// Whether all points with parameter `axis` equal to `at` lie within `tol` of the first.
    pub(super) fn is_collapsed(&self, axis: usize, at: f64, tol: f64) -> bool {
        let mut places = self.samples(1 - axis).map(|t| self.on_line(axis, at, t));
        places.next().is_some_and(|start| places.all(|place| place.distance(start) <= tol))
    }

    /// The point with parameter `axis` equal to `at`, and the other one to `t`.
    fn on_line(&self, axis: usize, at: f64, t: f64) -> DVec3 {
        if axis == 0 { self.point(at, t) } else { self.point(t, at) }
    }

    /// Parameters that determine a curve along which parameter `axis` varies: `degree + 1` per span.
    pub(super) fn samples(&self, axis: usize) -> impl Iterator<Item = f64> {
        let (degree, knots) = if axis == 0 { (self.degree_u, &self.knots_u) } else { (self.degree_v, &self.knots_v) };
        knots::spans(degree, knots).flat_map(move |i| {
            (0..=degree).map(move |j| knots[i] + (knots[i + 1] - knots[i]) * j as f64 / degree.max(1) as f64)
        })
    }

    /// Half the diagonal of the largest box of a line of control points along which parameter `axis` varies. Tolerances
    /// of coincidence along such lines are relative to it: the rest of the surface may be far larger.
    pub(super) fn size_along(&self, axis: usize) -> f64 {
        let (rows, row) = (self.count_u(), self.count_v());
        let [lines, length, from, step] = if axis == 1 { [rows, row, row, 1] } else { [row, rows, 1, row] };
        let size = |line: usize| extent(self.points[line * from..].iter().step_by(step).take(length));
        (0..lines).map(size).fold(0.0, f64::max)
    }
}

/// Homogeneous sums over the control points of one piece of a surface, from the first one `at` (row, column), with the
/// bases there.
struct PieceSums<'a, const ROWS: usize> {
    surface: &'a NurbsSurface,
    at: [usize; 2],
    rows_u: &'a [f64],
    rows_v: &'a [f64],
}

impl<const ROWS: usize> Work for PieceSums<'_, ROWS> {
    /// By total order: the first `ROWS · (ROWS + 1) / 2` have orders below `ROWS`.
    type Output = [[f64; 4]; 6];

    #[inline(always)]
    fn run<F: Lanes<4>>(self, zero: F) -> Self::Output {
        /// Orders in u and v.
        const ORDERS: [(usize, usize); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];
        let Self { surface, at: [row, column], rows_u, rows_v } = self;
        let (nu, count_v) = (surface.degree_u + 1, surface.count_v());
        // In here, sums stay in registers.
        let mut sums = [zero; 6];
        let [values, first, second] = [0, 1, 2].map(|order| &rows_u[order * nu..][..nu]);
        for (a, ((&n, &d1), &d2)) in values.iter().zip(first).zip(second).enumerate() {
            let line: [F; ROWS] = surface.line(zero, (row + a) * count_v + column, rows_v);
            for (sum, (order_u, order_v)) in sums.iter_mut().zip(ORDERS).take(ROWS * (ROWS + 1) / 2) {
                *sum = *sum + zero.splat([n, d1, d2][order_u]) * line[order_v];
            }
        }
        sums.map(F::to_array)
    }
}

/// A curve on a surface along which one parameter is constant, as a spline in the other one.
///
/// Where it is a border of a clamped surface without weights, and on any line of constant v, points and slopes are
/// bit-identical to those of the surface. On other lines they differ by rounding.
pub(crate) struct IsoLine<'a> {
    degree: usize,
    knots: &'a [f64],
    /// Homogeneous control points. Without weights their last component means nothing.
    net: Vec<[f64; 4]>,
    is_rational: bool,
}

impl IsoLine<'_> {
    /// The same curve on its own.
    #[cfg(feature = "step")]
    pub(crate) fn curve(&self) -> super::NurbsCurve3 {
        let (knots, rows) = (self.knots.to_vec(), self.net.iter());
        let weights: Vec<f64> = rows.clone().filter(|_| self.is_rational).map(|row| row[3]).collect();
        let point = |(k, row): (usize, &[f64; 4])| DVec3::from_slice(row) / weights.get(k).copied().unwrap_or(1.0);
        super::NurbsCurve3 { degree: self.degree, knots, points: rows.enumerate().map(point).collect(), weights }
    }

    /// The point at `t`, clamped to the domain.
    pub(crate) fn point(&self, t: f64) -> DVec3 {
        self.orders::<1>(t, t)[0]
    }

    /// The derivative at `t`, clamped to the domain, of the piece that contains `inside`: at a knot, that before or
    /// that after it.
    pub(crate) fn slope(&self, t: f64, inside: f64) -> DVec3 {
        self.orders::<2>(t, inside)[1]
    }

    /// Whether it is a polynomial of degree 3 or less between knots.
    pub(crate) fn is_cubic(&self) -> bool {
        self.degree <= 3 && !self.is_rational
    }

    /// The point and, if `ROWS` is 2, the derivative, of the piece that contains `inside`.
    fn orders<const ROWS: usize>(&self, t: f64, inside: f64) -> [DVec3; 2] {
        let (a, b) = knots::domain(self.degree, self.knots);
        let [t, inside] = [t, inside].map(|t| t.max(a).min(b));
        let span = knots::span(self.degree, self.knots, inside);
        let n = self.degree + 1;
        knots::with_basis::<ROWS, _>(self.degree, self.knots, span, t, |rows| {
            let mut sums = [[0.0; 4]; 2];
            for (sum, row) in sums.iter_mut().zip(rows.chunks_exact(n)).take(ROWS) {
                let terms = self.net[span - self.degree..].iter().zip(row);
                terms.for_each(|(point, &n)| add(sum, n, point));
            }
            let [p, d] = sums.map(|[x, y, z, _]| DVec3::new(x, y, z));
            if !self.is_rational {
                return [p, d];
            }
            let [w, dw] = sums.map(|[.., w]| w);
            let per = 1.0 / w;
            let point = p * per;
            [point, (d - point * dw) * per]
        })
    }
}

/// `to += factor · from`.
#[inline(always)]
fn add(to: &mut [f64; 4], factor: f64, from: &[f64; 4]) {
    *to = std::array::from_fn(|k| to[k] + factor * from[k]);
}

/// Half the diagonal of the box of `points`; 0 without any.
pub(super) fn extent<'a>(points: impl IntoIterator<Item = &'a DVec3>) -> f64 {
    let [low, high] = around(points.into_iter().copied());
    if low.x > high.x { 0.0 } else { 0.5 * low.distance(high) }
}

/// Derivatives of `P / W` from those of `P` and `W`, in the order 1, u, v, uu, uv, vv.
#[inline]
pub(crate) fn quotient(p: [DVec3; 6], w: [f64; 6]) -> SurfaceDerivatives {
    let per = 1.0 / w[0];
    let point = p[0] * per;
    let du = (p[1] - point * w[1]) * per;
    let dv = (p[2] - point * w[2]) * per;
    let duu = (p[3] - du * (2.0 * w[1]) - point * w[3]) * per;
    let duv = (p[4] - du * w[2] - dv * w[1] - point * w[4]) * per;
    let dvv = (p[5] - dv * (2.0 * w[2]) - point * w[5]) * per;
    SurfaceDerivatives { point, du, dv, duu, duv, dvv }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clamped surface of degrees 3 and 2 with one inner knot in u and two in v.
    fn surface(weights: Vec<f64>) -> NurbsSurface {
        let points = (0..25).map(|k| {
            let t = f64::from(k);
            DVec3::new(f64::from(k / 5), f64::from(k % 5), (0.7 * t).sin())
        });
        NurbsSurface {
            degree_u: 3,
            degree_v: 2,
            knots_u: vec![0.0, 0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0, 1.0],
            knots_v: vec![-1.0, -1.0, -1.0, 0.1, 0.3, 2.0, 2.0, 2.0],
            points: points.collect(),
            weights,
        }
    }

    #[test]
    fn slopes_of_iso_lines_at_knots_are_those_of_the_piece_that_is_meant() {
        let surface = surface(Vec::new());
        for axis in [0, 1] {
            let line = surface.iso_line(axis, 0.3);
            assert!(line.is_cubic());
            let mut knots = line.knots.to_vec();
            knots.dedup();
            for w in knots.windows(2) {
                let [a, b] = [w[0], w[1]];
                let step = 1e-8 * (b - a);
                let [d, e] = [line.slope(a, a + step), line.slope(b, b - step)];
                let cubic = line.point(a).midpoint(line.point(b)) + (d - e) * ((b - a) / 8.0);
                let off = cubic.distance(line.point(0.5 * (a + b)));
                assert!(off <= 1e-13, "axis {axis} from {a} to {b}: {off:e}");
            }
        }
    }

    #[test]
    fn iso_lines_have_the_points_and_slopes_of_the_surface() {
        let weights: Vec<f64> = (0..25).map(|k| 1.0 + 0.5 * (1.3 * f64::from(k)).sin()).collect();
        for (surface, exact) in [(surface(Vec::new()), true), (surface(weights), false)] {
            let ((u0, u1), (v0, v1)) = surface.domain();
            for (axis, at, run) in
                [(0, u0, (v0, v1)), (0, u1, (v0, v1)), (1, v0, (u0, u1)), (1, 0.2, (u0, u1)), (0, 0.6, (v0, v1))]
            {
                let line = surface.iso_line(axis, at);
                for k in 0..=20 {
                    let t = run.0 + (run.1 - run.0) * f64::from(k) / 20.0;
                    let (u, v) = if axis == 0 { (at, t) } else { (t, at) };
                    let [point, du, dv] = surface.tangents(u, v);
                    let slope = if axis == 0 { dv } else { du };
                    if exact && at != 0.6 {
                        assert_eq!([line.point(t), line.slope(t, t)], [point, slope], "axis {axis} at {at}, {t}");
                    }
                    let off = line.point(t).distance(point).max(line.slope(t, t).distance(slope));
                    assert!(off <= 1e-13, "axis {axis} at {at}, {t}: {off:e}");
                }
            }
        }
    }
}
