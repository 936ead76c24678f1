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
use glam::DVec4;
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
    let centre = (0.25 * (corner(0) + corner(points_v - 1) + corner(last + 1 - points_v) + corner(last))).extend(0.0);
    let centred = control.iter().map(|c| *c - centre * c.w);
    // The cube of the weights, raised by one degree, is the longest product.
    let row = |degrees: usize| if points_v == 1 { 1 } else { points_v.max(3 * degrees + 1) + 1 };
    if is_product {
        let a = line((0..points_u).map(|i| weight(i, 0)));
        let b = line((0..points_v).map(|j| weight(0, j) / weight(0, 0)));
        separable_bounds(&Poly::scaled(points_u, points_v, row(b.len() - 1), centred), &a, &b)
    } else {
        let row = row(points_v - 1);
        let p = Poly::scaled(points_u, points_v, row, centred);
        general_bounds(&p, &Poly::scaled(points_u, points_v, row, control.iter().map(|c| DVec4::X * c.w)))
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
fn separable_bounds(p: &Poly, a: &Line, b: &Line) -> NetBounds {
    let (au, a2) = (slope(a), product(a, a));
    let a3 = product(&a2, a);
    let along_u = |line| -> Grid<'_> { (1, line) };
    let qu = sum(along_u(a), &p.by_u(), -1.0, along_u(&au), p);
    let quu = sum(along_u(a), &qu.by_u(), -2.0, along_u(&au), &qu);
    if p.nv == 1 {
        // A curve: there is nothing by v.
        return NetBounds { du: qu.over(&a2, b), duu: quu.over(&a3, b), ..NetBounds::default() };
    }
    let (bv, b2) = (slope(b), product(b, b));
    let b3 = product(&b2, b);
    let [along_v, slope_v]: [Grid<'_>; 2] = [(b.len(), b), (b.len() - 1, &bv)];
    let qv = sum(along_v, &p.by_v(), -1.0, slope_v, p);
    let quv = sum(along_v, &qu.by_v(), -1.0, slope_v, &qu);
    let qvv = sum(along_v, &qv.by_v(), -2.0, slope_v, &qv);
    NetBounds {
        du: qu.over(&a2, b),
        dv: qv.over(a, &b2),
        duu: quu.over(&a3, b),
        duv: quv.over(&a2, &b2),
        dvv: qvv.over(a, &b3),
    }
}

/// Bounds of `P / W`. `w`: the weights, as first components.
fn general_bounds(p: &Poly, w: &Poly) -> NetBounds {
    let [g, gu, gv] = [w, &w.by_u(), &w.by_v()].map(Poly::first);
    let [w1, wu, wv]: [Grid<'_>; 3] = [(w.nv, &g), (w.nv, &gu), (w.nv - 1, &gv)];
    let square = Poly::product(w1, w);
    let cube = Poly::product((square.nv, &square.first()), w);
    let qu = sum(w1, &p.by_u(), -1.0, wu, p);
    let qv = sum(w1, &p.by_v(), -1.0, wv, p);
    let quu = sum(w1, &qu.by_u(), -2.0, wu, &qu);
    let quv = sum(w1, &qu.by_v(), -2.0, wv, &qu);
    let qvv = sum(w1, &qv.by_v(), -2.0, wv, &qv);
    // As `over` raises the product, once for all. Neither direction is constant: the weights would be a product.
    let [w2, w3] = [square, cube].map(|w| {
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

/// A scalar polynomial in one variable, as Bernstein coefficients times binomials: products are convolutions.
type Line = SmallVec<[f64; 16]>;

/// The polynomial of these Bernstein coefficients; of degree 0 if all are equal.
fn line(plain: impl ExactSizeIterator<Item = f64> + Clone) -> Line {
    let mut values = plain.clone();
    let first = values.next().unwrap_or(1.0);
    if values.all(|w| (w - first).abs() <= PRODUCT * first) {
        return smallvec![first];
    }
    binomials(plain.len() - 1).iter().zip(plain).map(|(f, w)| f * w).collect()
}

/// The derivative; empty if `a` is constant.
fn slope(a: &[f64]) -> Line {
    let n = a.len() - 1;
    a.windows(2).enumerate().map(|(j, w)| (j + 1) as f64 * w[1] - (n - j) as f64 * w[0]).collect()
}

fn product(a: &[f64], b: &[f64]) -> Line {
    let mut product: Line = smallvec![0.0; a.len() + b.len() - 1];
    for (i, &value) in a.iter().enumerate() {
        product[i..][..b.len()].iter_mut().zip(b).for_each(|(to, from)| *to += value * from);
    }
    product
}

/// The same polynomial with at least so many coefficients.
fn raised_line(a: &Line, n: usize) -> Line {
    if n <= a.len() { a.clone() } else { product(&binomials(n - a.len()), a) }
}

/// The coefficients of a scalar polynomial in two variables, u-major, after their number per row.
type Grid<'a> = (usize, &'a [f64]);

/// A polynomial in two variables, as vectors of Bernstein coefficients times binomials. The fourth component means
/// nothing; four numbers fill a register.
struct Poly {
    nu: usize,
    nv: usize,
    /// Distance between rows, the same in factors and products. The rest of each row is 0, so that all are one run.
    row: usize,
    c: Vec<DVec4>,
}

impl Poly {
    fn scaled(nu: usize, nv: usize, row: usize, plain: impl Iterator<Item = DVec4>) -> Self {
        let mut scaled = Self::zero(nu, nv, row);
        let factors = binomial_grid(nu, nv);
        for (k, (f, p)) in factors.iter().zip(plain).enumerate() {
            scaled.c[k / nv * row + k % nv] = p * *f;
        }
        scaled
    }

    fn zero(nu: usize, nv: usize, row: usize) -> Self {
        debug_assert!(nv <= row, "{nv} coefficients in a row of {row}");
        Self { nu, nv, row, c: vec![DVec4::ZERO; nu * row] }
    }

    fn by_u(&self) -> Self {
        let mut d = Self::zero(self.nu.saturating_sub(1), self.nv, self.row);
        for (i, out) in d.c.chunks_exact_mut(self.row).enumerate() {
            let (up, down) = ((i + 1) as f64, (self.nu - 1 - i) as f64);
            let [here, next] = [i, i + 1].map(|i| &self.c[i * self.row..][..self.nv]);
            out.iter_mut().zip(here).zip(next).for_each(|((x, here), next)| *x = *next * up - *here * down);
        }
        d
    }

    fn by_v(&self) -> Self {
        let mut d = Self::zero(self.nu, self.nv.saturating_sub(1), self.row);
        for (out, row) in d.c.chunks_exact_mut(self.row).zip(self.c.chunks_exact(self.row)) {
            for (j, (x, w)) in out.iter_mut().zip(row[..self.nv].windows(2)).enumerate() {
                let (up, down) = ((j + 1) as f64, (self.nv - 1 - j) as f64);
                *x = w[1] * up - w[0] * down;
            }
        }
        d
    }

    /// Adds `factor · a · b`, which has the degrees of the sum.
    fn add_product(&mut self, factor: f64, (columns, a): Grid<'_>, b: &Self) {
        let run = &b.c[..(b.nu - 1) * b.row + b.nv];
        widest(
            #[inline(always)]
            || {
                for (i, values) in a.chunks_exact(columns).enumerate() {
                    for (j, value) in values.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                        let factor = factor * value;
                        let to = &mut self.c[i * self.row + j..][..run.len()];
                        to.iter_mut().zip(run).for_each(|(to, from)| *to += *from * factor);
                    }
                }
            },
        );
    }

    /// The same polynomial with at least the given numbers of coefficients.
    fn raised(self, nu: usize, nv: usize) -> Self {
        if nu <= self.nu && nv <= self.nv {
            return self;
        }
        let (nu, nv) = (nu.max(self.nu), nv.max(self.nv));
        let mut raised = Self::zero(nu, nv, self.row);
        let columns = nv + 1 - self.nv;
        raised.add_product(1.0, (columns, &binomial_grid(nu + 1 - self.nu, columns)), &self);
        raised
    }

    /// The first components, without the rest of each row.
    fn first(&self) -> Line {
        self.c.chunks_exact(self.row).flat_map(|row| row[..self.nv].iter().map(|c| c.x)).collect()
    }

    fn product(a: Grid<'_>, b: &Self) -> Self {
        let mut product = Self::zero(a.1.len() / a.0 + b.nu - 1, a.0 + b.nv - 1, b.row);
        product.add_product(1.0, a, b);
        product
    }

    fn is_empty(&self) -> bool {
        self.nu == 0 || self.nv == 0
    }

    /// The largest ratio of a coefficient's length to the same coefficient of `A(u) B(v)`, both raised to the same
    /// degrees; 0 if there are none, as for the derivative of a constant.
    fn over(self, a: &Line, b: &Line) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        // Coefficients approach values as the degree rises: one more degree halves the overestimate of low degrees.
        let more = usize::from(a.len() * b.len() > 1);
        // What is constant stays the same.
        let raised = |n: usize| if n > 1 { n + more } else { n };
        let (nu, nv) = (raised(self.nu.max(a.len())), raised(self.nv.max(b.len())));
        // Coefficients of `A(u) B(v)` are products of those of `A` and of `B`, raised or not.
        let (top, a, b) = (self.raised(nu, nv), raised_line(a, nu), raised_line(b, nv));
        let mut most = 0.0_f64;
        for (row, a) in top.c.chunks_exact(top.row).zip(&a) {
            for (n, b) in row.iter().zip(&b) {
                let w = a * b;
                most = larger(n.truncate().length_squared() / (w * w), most);
            }
        }
        most.sqrt()
    }

    /// The largest ratio of a coefficient's length to the first component of the same coefficient of `below`, which has
    /// at least as many; 0 if there are none.
    fn ratio(self, below: &Self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let top = self.raised(below.nu, below.nv);
        let rows = top.c.chunks_exact(top.row).zip(below.c.chunks_exact(below.row));
        let all = rows.flat_map(|(row, weights)| row.iter().zip(&weights[..below.nv]));
        all.fold(0.0_f64, |most, (n, w)| most.max(n.truncate().length_squared() / (w.x * w.x))).sqrt()
    }
}

/// `C(nu - 1, i) · C(nv - 1, j)`, u-major.
fn binomial_grid(nu: usize, nv: usize) -> SmallVec<[f64; 16]> {
    let (in_u, in_v) = (binomials(nu - 1), binomials(nv - 1));
    let mut grid = smallvec![0.0; nu * nv];
    for (row, u) in grid.chunks_exact_mut(nv).zip(&in_u) {
        row.iter_mut().zip(&in_v).for_each(|(x, v)| *x = u * v);
    }
    grid
}

/// `a · b + factor · c · d`; both products have the same degrees. One with a factor without coefficients, the
/// derivative of a constant, is 0.
fn sum(a: Grid<'_>, b: &Poly, factor: f64, c: Grid<'_>, d: &Poly) -> Poly {
    let products = [(1.0, a, b), (factor, c, d)];
    let kept = || products.iter().filter(|(_, (_, a), b)| !a.is_empty() && !b.is_empty());
    let Some((_, (columns, a), b)) = kept().next() else { return Poly::zero(0, 0, b.row) };
    let mut total = Poly::zero(a.len() / columns + b.nu - 1, columns + b.nv - 1, b.row);
    kept().for_each(|(factor, a, b)| total.add_product(*factor, *a, b));
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;
    use glam::DVec3;

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
        for (nu, nv) in [(3, 1), (4, 1), (1, 3), (1, 4), (2, 2), (3, 3), (4, 4), (6, 6), (2, 9)] {
            let control = net(&mut draw, nu * nv, true);
            let bounds = patch_bounds(nu, &control, true);
            for factor in [-99, 98].map(|k| 2.0_f64.powi(k)) {
                let scaled: Vec<DVec4> = control.iter().map(|&c| c * factor).collect();
                assert_eq!(patch_bounds(nu, &scaled, true), bounds, "{nu} {nv} {factor}");
            }
        }
    }
}
