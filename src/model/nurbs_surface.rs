//! NURBS surfaces -> points, first and second partial derivatives, closure.

use super::NurbsSurface;
use super::knots;
use glam::DVec3;

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
    /// Sums the rows of the net once per v: a few operations per point on lattices finer than the net.
    #[must_use]
    pub fn lattice(&self, us: &[f64], vs: &[f64]) -> Vec<DVec3> {
        let ((u0, u1), (v0, v1)) = self.domain();
        let count_v = self.count_v();
        let weighted = !self.weights.is_empty();
        let mut out = vec![DVec3::ZERO; us.len() * vs.len()];
        let mut lines = vec![(DVec3::ZERO, 0.0); self.count_u()];
        for (j, v) in vs.iter().enumerate() {
            let v = v.max(v0).min(v1);
            let span = knots::span(self.degree_v, &self.knots_v, v);
            knots::with_basis::<1, _>(self.degree_v, &self.knots_v, span, v, |rows| {
                for (i, (line, line_w)) in lines.iter_mut().enumerate() {
                    (*line, *line_w) = (DVec3::ZERO, 0.0);
                    let start = i * count_v + span - self.degree_v;
                    for (b, &n) in rows[..=self.degree_v].iter().enumerate() {
                        let value = n * if weighted { self.weights[start + b] } else { 1.0 };
                        *line += self.points[start + b] * value;
                        *line_w += value;
                    }
                }
            });
            for (i, u) in us.iter().enumerate() {
                let u = u.max(u0).min(u1);
                let span = knots::span(self.degree_u, &self.knots_u, u);
                out[i * vs.len() + j] = knots::with_basis::<1, _>(self.degree_u, &self.knots_u, span, u, |rows| {
                    let (mut p, mut w) = (DVec3::ZERO, 0.0);
                    for (&(line, line_w), &n) in lines[span - self.degree_u..].iter().zip(&rows[..=self.degree_u]) {
                        p += line * n;
                        w += line_w * n;
                    }
                    if weighted { p * (1.0 / w) } else { p }
                });
            }
        }
        out
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
        /// Orders in u and v of the results, by total order: the first `ROWS · (ROWS + 1) / 2` have orders below
        /// `ROWS`.
        const ORDERS: [(usize, usize); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];
        let (nu, nv) = (self.degree_u + 1, self.degree_v + 1);
        let count_v = self.count_v();
        let weighted = !self.weights.is_empty();
        // Homogeneous sums.
        let mut p = [DVec3::ZERO; 6];
        let mut w = [0.0; 6];
        for a in 0..nu {
            let mut line = [DVec3::ZERO; 3];
            let mut line_w = [0.0; 3];
            let start = (row + a) * count_v + column;
            let points = &self.points[start..start + nv];
            if weighted {
                for ((b, &point), &weight) in points.iter().enumerate().zip(&self.weights[start..start + nv]) {
                    for order in 0..ROWS {
                        let value = rows_v[order * nv + b] * weight;
                        line[order] += point * value;
                        line_w[order] += value;
                    }
                }
            } else {
                for (b, &point) in points.iter().enumerate() {
                    for order in 0..ROWS {
                        line[order] += point * rows_v[order * nv + b];
                    }
                }
            }
            let n = [rows_u[a], rows_u[nu + a], rows_u[2 * nu + a]];
            for (k, (order_u, order_v)) in ORDERS.into_iter().take(ROWS * (ROWS + 1) / 2).enumerate() {
                p[k] += line[order_v] * n[order_u];
                if weighted {
                    w[k] += line_w[order_v] * n[order_u];
                }
            }
        }
        if weighted {
            quotient(p, w)
        } else {
            SurfaceDerivatives { point: p[0], du: p[1], dv: p[2], duu: p[3], duv: p[4], dvv: p[5] }
        }
    }

    /// Whether the border lines `u = first` and `u = last` coincide within `tol` (millimetres).
    #[must_use]
    pub fn closed_u(&self, tol: f64) -> bool {
        let ((a, b), _) = self.domain();
        self.samples_v().into_iter().all(|v| self.point(a, v).distance(self.point(b, v)) <= tol)
    }

    /// Whether the border lines `v = first` and `v = last` coincide within `tol` (millimetres).
    #[must_use]
    pub fn closed_v(&self, tol: f64) -> bool {
        let (_, (a, b)) = self.domain();
        self.samples_u().into_iter().all(|u| self.point(u, a).distance(self.point(u, b)) <= tol)
    }

    /// Parameters that determine a curve u -> `S(u, v)`: `degree + 1` per span.
    pub(super) fn samples_u(&self) -> Vec<f64> {
        samples(self.degree_u, &self.knots_u)
    }

    /// Parameters that determine a curve v -> `S(u, v)`: `degree + 1` per span.
    pub(super) fn samples_v(&self) -> Vec<f64> {
        samples(self.degree_v, &self.knots_v)
    }

    /// Half the diagonal of the control net's box. Tolerances of coincidence are relative to it.
    pub(super) fn size(&self) -> f64 {
        extent(&self.points)
    }
}

/// Half the diagonal of the box of `points`.
pub(super) fn extent(points: &[DVec3]) -> f64 {
    let Some(&first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
    0.5 * low.distance(high)
}

/// `degree + 1` evenly spaced parameters per span.
fn samples(degree: usize, knots: &[f64]) -> Vec<f64> {
    knots::spans(degree, knots)
        .flat_map(|i| (0..=degree).map(move |j| knots[i] + (knots[i + 1] - knots[i]) * j as f64 / degree.max(1) as f64))
        .collect()
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
