//! Bézier nets -> upper bounds on their first and second derivatives by the local parameters (0 to 1).
//!
//! Each derivative is written as one quotient of Bernstein polynomials: `S_u = Q / W²` with `Q = W P_u - W_u P`, then
//! `S_uu = (W Q_u - 2 W_u Q) / W³`, `S_uv = (W Q_v - 2 W_v Q) / W³` and so on. The largest ratio of coefficients bounds
//! it (mediant inequality; needs positive weights). For polynomial nets this is the convex hull of the derivative net.
//! Weights of the form `A(u) B(v)`, which all quadrics and surfaces of revolution have, cancel in part: `S_uu` then
//! needs `A` only, over `A³ B`. Within a fifth of the true supremum on quadrics, within a fiftieth on halves of them.
//!
//! Products are convolutions of binomially scaled coefficients (Farouki & Rajan, "Algorithms for polynomials in
//! Bernstein form", CAGD 5, 1988).

use super::bernstein::binomials;
use super::lanes::widest;
use glam::{DVec3, DVec4};

/// Upper bounds on the lengths of `S_u`, `S_v`, `S_uu`, `S_uv`, `S_vv` over a patch.
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

/// Relative distance within which weights count as a product: a few rounding errors of the arithmetic that makes them.
const PRODUCT: f64 = 1e-14;

/// Bounds the derivatives of one patch.
///
/// `control` is u-major, `points_u` rows of homogeneous points. All weights are positive, and exactly 1 if not
/// `rational`. Derivatives that vanish identically may come out as rounding errors; the caller knows the scale and
/// drops them.
///
/// Cost: about 1 µs up to degree (3, 3); O((degree_u · degree_v)²), tens of µs, where the weights are not a
/// product.
#[must_use]
pub fn patch_bounds(points_u: usize, control: &[DVec4], rational: bool) -> NetBounds {
    let points_v = control.len() / points_u;
    if !rational {
        return polynomial_bounds(points_u, points_v, control);
    }
    // Centre the net: derivatives do not change, but cancellation errors shrink.
    let corner = |k: usize| control[k].truncate() / control[k].w;
    let last = control.len() - 1;
    let centre = 0.25 * (corner(0) + corner(points_v - 1) + corner(last + 1 - points_v) + corner(last));
    let p = Poly::scaled(points_u, points_v, control.iter().map(|c| c.truncate() - centre * c.w));
    let weight = |i: usize, j: usize| control[i * points_v + j].w;
    let product = |i: usize, j: usize| weight(i, 0) * (weight(0, j) / weight(0, 0));
    let is_product =
        (1..points_u).all(|i| (1..points_v).all(|j| (weight(i, j) - product(i, j)).abs() <= PRODUCT * weight(i, j)));
    if is_product {
        let a = Poly::row((0..points_u).map(|i| weight(i, 0))).transposed();
        let b = Poly::row((0..points_v).map(|j| weight(0, j) / weight(0, 0)));
        separable_bounds(&p, &a, &b)
    } else {
        general_bounds(&p, &Poly::scaled_scalar(points_u, points_v, control.iter().map(|c| c.w)))
    }
}

/// Bounds by the convex hulls of the derivative nets.
fn polynomial_bounds(points_u: usize, points_v: usize, control: &[DVec4]) -> NetBounds {
    let at = |i: usize, j: usize| control[i * points_v + j].truncate();
    let (p, q) = ((points_u - 1) as f64, (points_v - 1) as f64);
    let mut most = [0.0_f64; 5];
    let mut see = |kind: usize, v: DVec3| most[kind] = most[kind].max(v.length_squared());
    for i in 0..points_u {
        for j in 0..points_v {
            let (more_u, more_v) = (i + 1 < points_u, j + 1 < points_v);
            if more_u {
                see(0, at(i + 1, j) - at(i, j));
            }
            if more_v {
                see(1, at(i, j + 1) - at(i, j));
            }
            if i + 2 < points_u {
                see(2, at(i + 2, j) - at(i + 1, j) - (at(i + 1, j) - at(i, j)));
            }
            if more_u && more_v {
                see(3, at(i + 1, j + 1) - at(i + 1, j) - (at(i, j + 1) - at(i, j)));
            }
            if j + 2 < points_v {
                see(4, at(i, j + 2) - at(i, j + 1) - (at(i, j + 1) - at(i, j)));
            }
        }
    }
    let [du, dv, duu, duv, dvv] = most.map(f64::sqrt);
    NetBounds { du: p * du, dv: q * dv, duu: p * (p - 1.0) * duu, duv: p * q * duv, dvv: q * (q - 1.0) * dvv }
}

/// Bounds of `P / (A(u) B(v))`.
fn separable_bounds(p: &Poly, a: &Poly, b: &Poly) -> NetBounds {
    let (au, bv) = (a.by_u(), b.by_v());
    let (a2, b2) = (sum(&[(1.0, a, a)]), sum(&[(1.0, b, b)]));
    let qu = sum(&[(1.0, a, &p.by_u()), (-1.0, &au, p)]);
    let qv = sum(&[(1.0, b, &p.by_v()), (-1.0, &bv, p)]);
    let quu = sum(&[(1.0, a, &qu.by_u()), (-2.0, &au, &qu)]);
    let quv = sum(&[(1.0, b, &qu.by_v()), (-1.0, &bv, &qu)]);
    let qvv = sum(&[(1.0, b, &qv.by_v()), (-2.0, &bv, &qv)]);
    let times = |x: &Poly, y: &Poly| sum(&[(1.0, x, y)]);
    NetBounds {
        du: qu.over(|| times(&a2, b)),
        dv: qv.over(|| times(a, &b2)),
        duu: quu.over(|| times(&times(&a2, a), b)),
        duv: quv.over(|| times(&a2, &b2)),
        dvv: qvv.over(|| times(a, &times(&b2, b))),
    }
}

/// Bounds of `P / W`.
fn general_bounds(p: &Poly, w: &Poly) -> NetBounds {
    let (wu, wv) = (w.by_u(), w.by_v());
    let w2 = sum(&[(1.0, w, w)]);
    let w3 = sum(&[(1.0, &w2, w)]);
    let qu = sum(&[(1.0, w, &p.by_u()), (-1.0, &wu, p)]);
    let qv = sum(&[(1.0, w, &p.by_v()), (-1.0, &wv, p)]);
    let quu = sum(&[(1.0, w, &qu.by_u()), (-2.0, &wu, &qu)]);
    let quv = sum(&[(1.0, w, &qu.by_v()), (-2.0, &wv, &qu)]);
    let qvv = sum(&[(1.0, w, &qv.by_v()), (-2.0, &wv, &qv)]);
    NetBounds {
        du: qu.over(|| w2.clone()),
        dv: qv.over(|| w2.clone()),
        duu: quu.over(|| w3.clone()),
        duv: quv.over(|| w3.clone()),
        dvv: qvv.over(|| w3.clone()),
    }
}

/// Upper bounds on `‖C'‖` and `‖C''‖` over one rational Bézier segment with positive weights.
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

/// A polynomial in two variables with `dim` components, as Bernstein coefficients times binomials: products are
/// convolutions. The components of a coefficient are adjacent, so a row is contiguous.
#[derive(Clone)]
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

    /// A scalar polynomial in v alone; degree 0 if all coefficients are equal.
    fn row(plain: impl ExactSizeIterator<Item = f64> + Clone) -> Self {
        let mut values = plain.clone();
        let first = values.next().unwrap_or(1.0);
        if values.all(|w| (w - first).abs() <= PRODUCT * first) {
            return Self { nu: 1, nv: 1, dim: 1, c: vec![first] };
        }
        Self::scaled_scalar(1, plain.len(), plain)
    }

    /// Turns a polynomial in v alone into one in u alone.
    fn transposed(self) -> Self {
        Self { nu: self.nv, nv: self.nu, ..self }
    }

    /// The zero polynomial of the given size; without coefficients if `nu` or `nv` is 0.
    fn zero(nu: usize, nv: usize, dim: usize) -> Self {
        Self { nu, nv, dim, c: vec![0.0; nu * nv * dim] }
    }

    fn by_u(&self) -> Self {
        let mut d = Self::zero(self.nu.saturating_sub(1), self.nv, self.dim);
        if d.c.is_empty() {
            return d;
        }
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
            let next = row[self.dim..].chunks_exact(self.dim);
            let columns = out.chunks_exact_mut(self.dim).zip(row.chunks_exact(self.dim)).zip(next);
            for (j, ((out, here), next)) in columns.enumerate() {
                let (up, down) = ((j + 1) as f64, (self.nv - 1 - j) as f64);
                for ((x, here), next) in out.iter_mut().zip(here).zip(next) {
                    *x = up * next - down * here;
                }
            }
        }
        d
    }

    /// The same polynomial with at least the given numbers of coefficients.
    fn raised(self, nu: usize, nv: usize) -> Self {
        if self.c.is_empty() || (nu <= self.nu && nv <= self.nv) {
            return self;
        }
        let (by_u, by_v) = (nu.max(self.nu) - self.nu + 1, nv.max(self.nv) - self.nv + 1);
        let ones = Self { nu: by_u, nv: by_v, dim: 1, c: binomial_grid(by_u, by_v) };
        sum(&[(1.0, &ones, &self)])
    }

    /// The largest ratio of a coefficient's length to the same coefficient of `below`, both raised to the same degrees;
    /// 0 if there are none: curves have no derivatives by v.
    fn over(self, below: impl FnOnce() -> Self) -> f64 {
        if self.c.is_empty() {
            return 0.0;
        }
        let below = below();
        // Coefficients approach values as the degree rises: one more degree halves the overestimate of low degrees.
        let more = usize::from(below.c.len() > 1);
        // What is constant stays the same.
        let raised = |n: usize| if n > 1 { n + more } else { n };
        let (nu, nv) = (raised(self.nu.max(below.nu)), raised(self.nv.max(below.nv)));
        let (top, below) = (self.raised(nu, nv), below.raised(nu, nv));
        let lengths = top.c.chunks_exact(3).map(|n| n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        lengths.zip(&below.c).fold(0.0_f64, |most, (n, &w)| most.max(n / (w * w))).sqrt()
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

/// `to += factor · from`, over the length of `from`. Sixteen numbers at a time, then four, so that runs of a dozen fill
/// the registers too.
#[inline(always)]
fn axpy(to: &mut [f64], factor: f64, from: &[f64]) {
    let (to, from) = axpy_blocks::<16>(&mut to[..from.len()], factor, from);
    let (to, from) = axpy_blocks::<4>(to, factor, from);
    axpy_blocks::<1>(to, factor, from);
}

/// [`axpy`] for whole blocks of `N` numbers. Returns the rest.
#[inline(always)]
fn axpy_blocks<'a, const N: usize>(to: &'a mut [f64], factor: f64, from: &'a [f64]) -> (&'a mut [f64], &'a [f64]) {
    let (to, rest) = to.as_chunks_mut::<N>();
    let (from, rest_from) = from.as_chunks::<N>();
    for (to, from) in to.iter_mut().zip(from) {
        *to = std::array::from_fn(|k| to[k] + factor * from[k]);
    }
    (rest, rest_from)
}

/// `Σ factor · a · b` with scalar `a`; all products have the same degrees. Terms with a factor without coefficients
/// (the derivative of a constant) are 0.
fn sum(terms: &[(f64, &Poly, &Poly)]) -> Poly {
    let kept = || terms.iter().filter(|(_, a, b)| !a.c.is_empty() && !b.c.is_empty());
    let Some((_, a, b)) = kept().next() else { return Poly::zero(0, 0, terms[0].2.dim) };
    let mut total = Poly::zero(a.nu + b.nu - 1, a.nv + b.nv - 1, b.dim);
    let row = total.nv * total.dim;
    widest(
        #[inline(always)]
        || {
            for (factor, a, b) in kept() {
                debug_assert_eq!((total.nu, total.nv), (a.nu + b.nu - 1, a.nv + b.nv - 1));
                for (k, &value) in a.c.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                    let (i, j) = (k / a.nv, k % a.nv);
                    // Where `a` is constant in v, all rows of `b` are one run.
                    let run = if a.nv == 1 { b.c.len() } else { b.nv * b.dim };
                    for (r, run) in b.c.chunks_exact(run).enumerate() {
                        axpy(&mut total.c[(i + r) * row + j * b.dim..], factor * value, run);
                    }
                }
            }
        },
    );
    total
}
