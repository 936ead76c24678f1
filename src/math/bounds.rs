//! Bézier nets -> upper bounds of their first and second derivatives by the local parameters (0 to 1).
//!
//! Polynomial nets: the convex hull of the derivative nets. Rational nets: each derivative is written as one quotient of
//! Bernstein polynomials, `S_u = (P_u W - P W_u) / W²`, `S_uu = (W² P_uu - 2 W W_u P_u - W W_uu P + 2 W_u² P) / W³` and so on,
//! and bounded by the largest ratio of coefficients (mediant inequality), which needs positive weights. Within a fifth of
//! the true supremum on quadrics, within a fiftieth on halves of them.

use super::bernstein::binomials;
use glam::{DVec3, DVec4};

/// Upper bounds of the lengths of `S_u`, `S_v`, `S_uu`, `S_uv`, `S_vv` over a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NetBounds {
    /// sup ‖S_u‖.
    pub du: f64,
    /// sup ‖S_v‖.
    pub dv: f64,
    /// sup ‖S_uu‖.
    pub duu: f64,
    /// sup ‖S_uv‖.
    pub duv: f64,
    /// sup ‖S_vv‖.
    pub dvv: f64,
}

/// Bounds of one patch: `control` is u-major, `points_u` rows of homogeneous points, all weights positive (exactly 1 if not
/// `rational`).
///
/// Derivatives that vanish identically may come out as rounding; the caller knows the scale and drops them.
/// O((degree_u · degree_v)²) for rational nets: about 1 µs at degrees (2, 1), 10 µs at (3, 3).
#[must_use]
pub fn patch_bounds(points_u: usize, control: &[DVec4], rational: bool) -> NetBounds {
    let points_v = control.len() / points_u;
    // Derivatives do not see a translation, but cancellation does.
    let corner = |k: usize| control[k].truncate() / control[k].w;
    let last = control.len() - 1;
    let centre = 0.25 * (corner(0) + corner(points_v - 1) + corner(last + 1 - points_v) + corner(last));
    let p = Poly::scaled(points_u, points_v, control.iter().map(|c| c.truncate() - centre * c.w));
    let (pu, pv) = (p.by_u(), p.by_v());
    let (puu, puv, pvv) = (pu.by_u(), pu.by_v(), pv.by_v());
    if !rational {
        return NetBounds { du: pu.hull(), dv: pv.hull(), duu: puu.hull(), duv: puv.hull(), dvv: pvv.hull() };
    }
    let w = Poly::scaled_scalar(points_u, points_v, control.iter().map(|c| c.w));
    let (wu, wv) = (w.by_u(), w.by_v());
    let (wuu, wuv, wvv) = (wu.by_u(), wu.by_v(), wv.by_v());
    let w2 = sum(&[(1.0, &w, &w)]);
    let (wwu, wwv) = (sum(&[(1.0, &w, &wu)]), sum(&[(1.0, &w, &wv)]));
    let w3 = sum(&[(1.0, &w2, &w)]);
    let nu = sum(&[(1.0, &w, &pu), (-1.0, &wu, &p)]).raised_u(1);
    let nv = sum(&[(1.0, &w, &pv), (-1.0, &wv, &p)]).raised_v(1);
    let bend_u = sum(&[(2.0, &wu, &wu), (-1.0, &w, &wuu)]);
    let bend_v = sum(&[(2.0, &wv, &wv), (-1.0, &w, &wvv)]);
    let twist = sum(&[(2.0, &wu, &wv), (-1.0, &w, &wuv)]);
    let nuu = sum(&[(1.0, &w2, &puu), (-2.0, &wwu, &pu), (1.0, &bend_u, &p)]).raised_u(2);
    let nvv = sum(&[(1.0, &w2, &pvv), (-2.0, &wwv, &pv), (1.0, &bend_v, &p)]).raised_v(2);
    let nuv = sum(&[(1.0, &w2, &puv), (-1.0, &wwu, &pv), (-1.0, &wwv, &pu), (1.0, &twist, &p)]);
    NetBounds {
        du: nu.ratio(&w2),
        dv: nv.ratio(&w2),
        duu: nuu.ratio(&w3),
        duv: nuv.raised_u(1).raised_v(1).ratio(&w3),
        dvv: nvv.ratio(&w3),
    }
}

/// Upper bounds of `‖C'‖` and `‖C''‖` over one rational Bézier segment with positive weights.
#[must_use]
pub fn segment_bounds(control: &[DVec4]) -> (f64, f64) {
    let rational = control.iter().any(|c| c.w != control[0].w);
    if !rational && control[0].w != 1.0 {
        let even: Vec<DVec4> = control.iter().map(|c| *c / c.w).collect();
        return segment_bounds(&even);
    }
    let bounds = patch_bounds(control.len(), control, rational);
    (bounds.du, bounds.duu)
}

/// A polynomial in two variables, of `dim` components, by its Bernstein coefficients times binomials, so that products are
/// convolutions. Components lie together, so that a row is one run of numbers.
struct Poly {
    nu: usize,
    nv: usize,
    dim: usize,
    c: Vec<f64>,
}

impl Poly {
    fn scaled(nu: usize, nv: usize, plain: impl Iterator<Item = DVec3>) -> Self {
        let scaled = binomial_grid(nu, nv).into_iter().zip(plain).flat_map(|(f, p)| (p * f).to_array());
        Self { nu, nv, dim: 3, c: scaled.collect() }
    }

    fn scaled_scalar(nu: usize, nv: usize, plain: impl Iterator<Item = f64>) -> Self {
        Self { nu, nv, dim: 1, c: binomial_grid(nu, nv).into_iter().zip(plain).map(|(f, w)| f * w).collect() }
    }

    /// The zero polynomial of the given size; of no coefficients if one size is 0.
    fn zero(nu: usize, nv: usize, dim: usize) -> Self {
        Self { nu, nv, dim, c: vec![0.0; nu * nv * dim] }
    }

    fn by_u(&self) -> Self {
        let mut d = Self::zero(self.nu.saturating_sub(1), self.nv, self.dim);
        let row = self.nv * self.dim;
        for (i, out) in d.c.chunks_exact_mut(row).enumerate() {
            let (up, down) = ((i + 1) as f64, (self.nu - 1 - i) as f64);
            for (k, x) in out.iter_mut().enumerate() {
                *x = up * self.c[(i + 1) * row + k] - down * self.c[i * row + k];
            }
        }
        d
    }

    fn by_v(&self) -> Self {
        let mut d = Self::zero(self.nu, self.nv.saturating_sub(1), self.dim);
        if d.c.is_empty() {
            return d;
        }
        for (out, row) in d.c.chunks_exact_mut(d.nv * d.dim).zip(self.c.chunks_exact(self.nv * self.dim)) {
            for (k, x) in out.iter_mut().enumerate() {
                let j = k / self.dim;
                *x = (j + 1) as f64 * row[k + self.dim] - (self.nv - 1 - j) as f64 * row[k];
            }
        }
        d
    }

    /// The same polynomial, `by` degrees higher in u.
    fn raised_u(self, by: usize) -> Self {
        (0..by).fold(self, |low, _| {
            let mut high = Self::zero(low.nu + 1, low.nv, low.dim);
            axpy(&mut high.c, 1.0, &low.c);
            axpy(&mut high.c[low.nv * low.dim..], 1.0, &low.c);
            high
        })
    }

    /// The same polynomial, `by` degrees higher in v.
    fn raised_v(self, by: usize) -> Self {
        (0..by).fold(self, |low, _| {
            let mut high = Self::zero(low.nu, low.nv + 1, low.dim);
            let rows = low.c.chunks_exact((low.nv * low.dim).max(1));
            for (out, row) in high.c.chunks_exact_mut((low.nv + 1) * low.dim).zip(rows) {
                axpy(out, 1.0, row);
                axpy(&mut out[low.dim..], 1.0, row);
            }
            high
        })
    }

    /// The largest length of a plain Bernstein coefficient; 0 without any.
    fn hull(&self) -> f64 {
        self.most(&binomial_grid(self.nu, self.nv))
    }

    /// The largest length of a coefficient over the same coefficient of `below`; 0 without any.
    fn ratio(&self, below: &Self) -> f64 {
        self.most(&below.c)
    }

    fn most(&self, below: &[f64]) -> f64 {
        let lengths = self.c.chunks_exact(3).map(|n| n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        lengths.zip(below).fold(0.0_f64, |most, (n, &w)| most.max(n / (w * w))).sqrt()
    }
}

/// `C(nu - 1, i) · C(nv - 1, j)`, u-major.
fn binomial_grid(nu: usize, nv: usize) -> Vec<f64> {
    if nu == 0 || nv == 0 {
        return Vec::new();
    }
    let (in_u, in_v) = (binomials(nu - 1), binomials(nv - 1));
    in_u.iter().flat_map(|u| in_v.iter().map(move |v| u * v)).collect()
}

/// `to += factor · from` over the shorter of both.
#[inline]
fn axpy(to: &mut [f64], factor: f64, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += factor * from;
    }
}

/// `Σ factor · a · b` with scalar `a`; all products have the same degrees. Factors without coefficients (derivatives of
/// constants) drop out.
fn sum(terms: &[(f64, &Poly, &Poly)]) -> Poly {
    let kept = || terms.iter().filter(|(_, a, b)| !a.c.is_empty() && !b.c.is_empty());
    let Some((_, a, b)) = kept().next() else { return Poly::zero(0, 0, terms[0].2.dim) };
    let mut total = Poly::zero(a.nu + b.nu - 1, a.nv + b.nv - 1, b.dim);
    let row = total.nv * total.dim;
    for (factor, a, b) in kept() {
        debug_assert_eq!((total.nu, total.nv), (a.nu + b.nu - 1, a.nv + b.nv - 1));
        for (k, &value) in a.c.iter().enumerate().filter(|(_, value)| **value != 0.0) {
            let (i, j) = (k / a.nv, k % a.nv);
            for (r, run) in b.c.chunks_exact(b.nv * b.dim).enumerate() {
                axpy(&mut total.c[(i + r) * row + j * b.dim..], factor * value, run);
            }
        }
    }
    total
}
