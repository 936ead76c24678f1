//! Bézier nets -> upper bounds on their first and second derivatives by the local parameters (0 to 1).
//!
//! Each derivative is written as one quotient of Bernstein polynomials: `S_u = Q / W²` with `Q = W P_u - W_u P`, then
//! `S_uu = (W Q_u - 2 W_u Q) / W³`, `S_uv = (W Q_v - 2 W_v Q) / W³` and so on. The largest ratio of coefficients bounds
//! it (mediant inequality; needs positive weights). For polynomial nets this is the convex hull of the derivative net.
//! Weights of the form `A(u) B(v)`, which all quadrics and surfaces of revolution have, cancel in part: `S_uu` then
//! needs `A` only, over `A³ B`. Within a fifth of the true supremum on quadrics, within a fiftieth on halves of them.
//! Large nets with other weights have the bounds of `fitted_bounds.rs`.
//!
//! Products are convolutions of binomially scaled coefficients (Farouki & Rajan, "Algorithms for polynomials in
//! Bernstein form", CAGD 5, 1988).

use super::bernstein::binomials;
use super::fitted_bounds;
use super::lanes::{larger, widest};
use glam::{DVec3, DVec4};
use smallvec::{SmallVec, smallvec};

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

/// Control points up to which products of polynomials bound nets whose weights are no product. Their work goes with the
/// square.
const FEW: usize = 20;

/// Bounds the derivatives of one patch.
///
/// `control` is u-major, `points_u` rows of homogeneous points. All weights are positive, and exactly 1 if not
/// `rational`. Derivatives that vanish identically may come out as rounding errors; the caller knows the scale and
/// drops them.
///
/// Cost: about 1 µs up to degree (3, 3); tens of µs for nets of 20 control points whose weights are no product, and
/// linear in their number above.
#[must_use]
pub fn patch_bounds(points_u: usize, control: &[DVec4], rational: bool) -> NetBounds {
    let points_v = control.len() / points_u;
    if !rational {
        return polynomial_bounds(points_u, points_v, control);
    }
    let weight = |i: usize, j: usize| control[i * points_v + j].w;
    let product = |i: usize, j: usize| weight(i, 0) * (weight(0, j) / weight(0, 0));
    let is_product =
        (1..points_u).all(|i| (1..points_v).all(|j| (weight(i, j) - product(i, j)).abs() <= PRODUCT * weight(i, j)));
    if !is_product && control.len() > FEW {
        let [du, dv, duu, duv, dvv] = fitted_bounds::lengths(points_v, control);
        return NetBounds { du, dv, duu, duv, dvv };
    }
    // Centre the net: derivatives do not change, but cancellation errors shrink.
    let corner = |k: usize| control[k].truncate() / control[k].w;
    let last = control.len() - 1;
    let centre = 0.25 * (corner(0) + corner(points_v - 1) + corner(last + 1 - points_v) + corner(last));
    let p = Poly::scaled(points_u, points_v, control.iter().map(|c| c.truncate() - centre * c.w));
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
    let (p, q) = ((points_u - 1) as f64, (points_v - 1) as f64);
    let rows = || control.chunks_exact(points_v);
    let most = widest(
        #[inline(always)]
        || {
            let mut most = [0.0_f64; 5];
            // Weights take part in the differences, because four numbers fill a register.
            let mut see = |kind: usize, v: DVec4| most[kind] = larger(v.truncate().length_squared(), most[kind]);
            for row in rows() {
                row.windows(2).for_each(|w| see(1, w[1] - w[0]));
                row.windows(3).for_each(|w| see(4, (w[2] - w[1]) - (w[1] - w[0])));
            }
            for (a, b) in rows().zip(rows().skip(1)) {
                a.iter().zip(b).for_each(|(a, b)| see(0, *b - *a));
                a.windows(2).zip(b.windows(2)).for_each(|(a, b)| see(3, (b[1] - b[0]) - (a[1] - a[0])));
            }
            for ((a, b), c) in rows().zip(rows().skip(1)).zip(rows().skip(2)) {
                a.iter().zip(b).zip(c).for_each(|((a, b), c)| see(2, (*c - *b) - (*b - *a)));
            }
            most
        },
    );
    let [du, dv, duu, duv, dvv] = most.map(f64::sqrt);
    NetBounds { du: p * du, dv: q * dv, duu: p * (p - 1.0) * duu, duv: p * q * duv, dvv: q * (q - 1.0) * dvv }
}

/// Bounds of `P / (A(u) B(v))`.
fn separable_bounds(p: &Poly, a: &Poly, b: &Poly) -> NetBounds {
    let au = a.by_u();
    let a2 = sum(&[(1.0, a, a)]);
    let a3 = sum(&[(1.0, &a2, a)]);
    let qu = sum(&[(1.0, a, &p.by_u()), (-1.0, &au, p)]);
    let quu = sum(&[(1.0, a, &qu.by_u()), (-2.0, &au, &qu)]);
    if p.nv == 1 {
        // A curve: there is nothing by v.
        return NetBounds { du: qu.over(&a2, b), duu: quu.over(&a3, b), ..NetBounds::default() };
    }
    let bv = b.by_v();
    let b2 = sum(&[(1.0, b, b)]);
    let b3 = sum(&[(1.0, &b2, b)]);
    let qv = sum(&[(1.0, b, &p.by_v()), (-1.0, &bv, p)]);
    let quv = sum(&[(1.0, b, &qu.by_v()), (-1.0, &bv, &qu)]);
    let qvv = sum(&[(1.0, b, &qv.by_v()), (-2.0, &bv, &qv)]);
    NetBounds {
        du: qu.over(&a2, b),
        dv: qv.over(a, &b2),
        duu: quu.over(&a3, b),
        duv: quv.over(&a2, &b2),
        dvv: qvv.over(a, &b3),
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
    // As `over` raises the product, once for all. Neither direction is constant: the weights would be a product.
    let [w2, w3] = [w2, w3].map(|w| {
        let (nu, nv) = (w.nu + 1, w.nv + 1);
        w.raised(nu, nv)
    });
    NetBounds { du: qu.ratio(&w2), dv: qv.ratio(&w2), duu: quu.ratio(&w3), duv: quv.ratio(&w3), dvv: qvv.ratio(&w3) }
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
        let mut raised = Self::zero(self.nu + by_u - 1, self.nv + by_v - 1, self.dim);
        raised.add_product(1.0, (by_v, &binomial_grid(by_u, by_v)), &self);
        raised
    }

    /// Adds `factor · a · b`, which has the degrees of the sum. `a`: scalar coefficients, `columns` per row.
    fn add_product(&mut self, factor: f64, (columns, a): (usize, &[f64]), b: &Self) {
        debug_assert_eq!((self.nu, self.nv), (a.len() / columns + b.nu - 1, columns + b.nv - 1));
        let (row, row_of_b) = (self.nv * self.dim, b.nv * b.dim);
        widest(
            #[inline(always)]
            || {
                let mut padded: SmallVec<[f64; 256]>;
                let b = if b.nu == 1 || row_of_b == row {
                    &b.c[..]
                } else {
                    // With zeros between its rows, all of `b` is one run.
                    padded = smallvec![0.0; (b.nu - 1) * row + row_of_b];
                    let rows = padded.chunks_mut(row).zip(b.c.chunks_exact(row_of_b));
                    rows.for_each(|(to, from)| to[..row_of_b].copy_from_slice(from));
                    &padded[..]
                };
                for (i, values) in a.chunks_exact(columns).enumerate() {
                    for (j, value) in values.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                        axpy(&mut self.c[i * row + j * self.dim..], factor * value, b);
                    }
                }
            },
        );
    }

    /// The largest ratio of a coefficient's length to the same coefficient of `A(u) B(v)`, both raised to the same
    /// degrees; 0 if there are none, as for the derivative of a constant.
    fn over(self, a: &Self, b: &Self) -> f64 {
        if self.c.is_empty() {
            return 0.0;
        }
        // Coefficients approach values as the degree rises: one more degree halves the overestimate of low degrees.
        let more = usize::from(a.nu * b.nv > 1);
        // What is constant stays the same.
        let raised = |n: usize| if n > 1 { n + more } else { n };
        let (nu, nv) = (raised(self.nu.max(a.nu)), raised(self.nv.max(b.nv)));
        // Coefficients of `A(u) B(v)` are products of those of `A` and of `B`, raised or not.
        let (top, a, b) = (self.raised(nu, nv), a.clone().raised(nu, 1), b.clone().raised(1, nv));
        let mut most = 0.0_f64;
        for (row, a) in top.c.chunks_exact(3 * nv).zip(&a.c) {
            for (n, b) in row.chunks_exact(3).zip(&b.c) {
                let w = a * b;
                most = larger((n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / (w * w), most);
            }
        }
        most.sqrt()
    }

    /// The largest ratio of a coefficient's length to the same coefficient of `below`, which has at least as many; 0 if
    /// there are none.
    fn ratio(self, below: &Self) -> f64 {
        let top = self.raised(below.nu, below.nv);
        let lengths = top.c.chunks_exact(3).map(|n| n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        lengths.zip(&below.c).fold(0.0_f64, |most, (n, &w)| most.max(n / (w * w))).sqrt()
    }
}

/// `C(nu - 1, i) · C(nv - 1, j)`, u-major.
fn binomial_grid(nu: usize, nv: usize) -> SmallVec<[f64; 16]> {
    if nu == 0 || nv == 0 {
        return SmallVec::new();
    }
    let (in_u, in_v) = (binomials(nu - 1), binomials(nv - 1));
    let mut grid = smallvec![0.0; nu * nv];
    for (row, u) in grid.chunks_exact_mut(nv).zip(&in_u) {
        row.iter_mut().zip(&in_v).for_each(|(x, v)| *x = u * v);
    }
    grid
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
    kept().for_each(|(factor, a, b)| total.add_product(*factor, (a.nv, &a.c), b));
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;

    fn net(draw: &mut SplitMix, count: usize, rational: bool) -> Vec<DVec4> {
        (0..count)
            .map(|_| {
                let w = if rational { draw.range(0.5, 2.0) } else { 1.0 };
                DVec4::new(draw.range(-3.0, 3.0) * w, draw.range(-3.0, 3.0) * w, draw.range(-3.0, 3.0) * w, w)
            })
            .collect()
    }

    #[test]
    fn polynomial_bounds_are_the_longest_differences() {
        let mut draw = SplitMix(5);
        for (nu, nv) in [(1, 1), (4, 1), (1, 3), (2, 2), (4, 2), (3, 5), (6, 4)] {
            let control = net(&mut draw, nu * nv, false);
            let at = |i: usize, j: usize| control[i * nv + j].truncate();
            let longest = |di: usize, dj: usize, of: &dyn Fn(usize, usize) -> DVec3| {
                let pairs = (0..nu.saturating_sub(di)).flat_map(|i| (0..nv.saturating_sub(dj)).map(move |j| (i, j)));
                pairs.map(|(i, j)| of(i, j).length_squared()).fold(0.0, f64::max).sqrt()
            };
            let du = |i, j| at(i + 1, j) - at(i, j);
            let dv = |i, j| at(i, j + 1) - at(i, j);
            let (p, q) = ((nu - 1) as f64, (nv - 1) as f64);
            let expected = NetBounds {
                du: p * longest(1, 0, &du),
                dv: q * longest(0, 1, &dv),
                duu: p * (p - 1.0) * longest(2, 0, &|i, j| du(i + 1, j) - du(i, j)),
                duv: p * q * longest(1, 1, &|i, j| dv(i + 1, j) - dv(i, j)),
                dvv: q * (q - 1.0) * longest(0, 2, &|i, j| dv(i, j + 1) - dv(i, j)),
            };
            assert_eq!(patch_bounds(nu, &control, false), expected, "{nu} {nv}");
        }
    }

    /// A curve has the bounds of the surface that is the same curve for all v.
    #[test]
    fn rational_curves_are_bounded_like_surfaces_without_v() {
        let mut draw = SplitMix(6);
        for n in [2, 3, 4, 7] {
            let curve = net(&mut draw, n, true);
            let surface: Vec<DVec4> = curve.iter().flat_map(|&c| [c; 2]).collect();
            let (first, second) = segment_bounds(&curve);
            let bounds = patch_bounds(n, &surface, true);
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b;
            assert!(near(first, bounds.du) && near(second, bounds.duu), "{n}: {first} {second} {bounds:?}");
            assert_eq!(patch_bounds(n, &curve, true), NetBounds { du: first, duu: second, ..NetBounds::default() });
        }
    }

    /// A common factor of the weights cancels. 2^99 is the largest power of two in the range of weights.
    #[test]
    fn weights_at_the_ends_of_their_range_neither_vanish_nor_overflow() {
        let mut draw = SplitMix(7);
        for (nu, nv) in [(3, 1), (4, 1), (3, 3), (4, 4), (6, 6)] {
            let control = net(&mut draw, nu * nv, true);
            let bounds = patch_bounds(nu, &control, true);
            for factor in [-99, 98].map(|k| 2.0_f64.powi(k)) {
                let scaled: Vec<DVec4> = control.iter().map(|&c| c * factor).collect();
                assert_eq!(patch_bounds(nu, &scaled, true), bounds, "{nu} {nv} {factor}");
            }
        }
    }
}
