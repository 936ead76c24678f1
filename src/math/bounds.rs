//! Bézier nets -> upper bounds on their first and second derivatives by the local parameters (0 to 1).
//!
//! Polynomial nets: the convex hulls of the derivative nets. Rational ones, `S = P / W`: `S_u = (P_u - W_u S) / W`,
//! `S_uu = (P_uu - W_uu S - 2 W_u S_u) / W`, `S_uv = (P_uv - W_uv S - W_v S_u - W_u S_v) / W` and so on. Bilinear
//! fits replace `S`, `S_u` and `S_v`, and the error of each times its factor is added. Each term is then one quotient by
//! `W`, and the largest ratio of Bernstein coefficients bounds it (mediant inequality; needs positive weights). Second
//! derivatives are within 4 % of the true supremum on arcs of 22.5 degrees, within two thirds on boxes of a torus that
//! are 45 degrees wide, and within a factor of 4 on boxes of 90 degrees.

use super::lanes::widest;
use super::order::larger;
use glam::DVec4;
use smallvec::SmallVec;

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

/// Bounds the derivatives of one patch.
///
/// `control` is u-major, `points_u` rows of homogeneous points. All weights are positive, and exactly 1 if not
/// `rational`. Derivatives that vanish identically may come out as rounding errors; the caller knows the scale and
/// drops them.
///
/// Cost: about 1 µs up to degree (3, 3); linear in the number of control points.
#[must_use]
pub fn patch_bounds(points_u: usize, control: &[DVec4], rational: bool) -> NetBounds {
    let points_v = control.len() / points_u;
    if !rational {
        return polynomial_bounds(points_u, points_v, control);
    }
    widest(
        #[inline(always)]
        || rational_bounds(points_v, control),
    )
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

/// Bounds of a rational net.
#[inline(always)]
fn rational_bounds(points_v: usize, control: &[DVec4]) -> NetBounds {
    let last = control.len() - 1;
    let corners = [0, points_v - 1, last + 1 - points_v, last];
    // About the middle of the corners: derivatives do not change, but rounding errors shrink.
    let centre = corners.iter().map(|&k| control[k] / control[k].w).sum::<DVec4>() * 0.25;
    let net: Net = control.iter().map(|&c| (c - centre * c.w).truncate().extend(c.w)).collect();
    let elevated = Elevated::new(&net, points_v);
    let ends = corners.map(|k| net[k] / net[k].w);
    let point = elevated.over(&net, [(&net, ends)]).fit(ends);
    let twice = |of: &Fit| of.corners.map(|x| x * 2.0);

    let u = by_u(&net, points_v);
    let uu = by_u(&u, points_v);
    let (du, of_u) = elevated.first(&net, &u, &point);
    let (wu, wuu) = (most_weight(&u, &net), most_weight(&uu, &net));
    let duu = elevated.over(&uu, [(&uu, point.corners), (&u, twice(&of_u))]).longest();
    let duu = duu + wuu * point.error + 2.0 * wu * of_u.error;
    if points_v == 1 {
        return NetBounds { du, duu, ..NetBounds::default() };
    }
    let v = by_v(&net, points_v);
    let (uv, vv) = (by_v(&u, points_v), by_v(&v, points_v));
    let (dv, of_v) = elevated.first(&net, &v, &point);
    let (wv, wuv, wvv) = (most_weight(&v, &net), most_weight(&uv, &net), most_weight(&vv, &net));
    let duv = elevated.over(&uv, [(&uv, point.corners), (&v, of_u.corners), (&u, of_v.corners)]).longest();
    let dvv = elevated.over(&vv, [(&vv, point.corners), (&v, twice(&of_v))]).longest();
    NetBounds {
        du,
        dv,
        duu,
        duv: duv + wuv * point.error + wv * of_u.error + wu * of_v.error,
        dvv: dvv + wvv * point.error + 2.0 * wv * of_v.error,
    }
}

/// A net of homogeneous points, u-major.
type Net = SmallVec<[DVec4; 16]>;

/// The derivative of a net by u, as a net of the same degree.
#[inline(always)]
fn by_u(net: &[DVec4], points_v: usize) -> Net {
    let mut by = Net::from_elem(DVec4::ZERO, net.len());
    add_derivative(net, points_v, &mut by);
    by
}

/// The derivative of a net by v, as a net of the same degree.
#[inline(always)]
fn by_v(net: &[DVec4], points_v: usize) -> Net {
    let mut by = Net::from_elem(DVec4::ZERO, net.len());
    net.chunks_exact(points_v).zip(by.chunks_exact_mut(points_v)).for_each(|(row, by)| add_derivative(row, 1, by));
    by
}

/// Adds the derivative along lines whose points are `stride` apart: coefficient k of degree n is
/// `k (c_k - c_(k-1)) + (n - k) (c_(k+1) - c_k)`.
#[inline(always)]
fn add_derivative(net: &[DVec4], stride: usize, to: &mut [DVec4]) {
    let degree = net.len() / stride - 1;
    for i in 0..degree {
        for k in i * stride..(i + 1) * stride {
            let step = net[k + stride] - net[k];
            to[k] += step * (degree - i) as f64;
            to[k + stride] += step * (i + 1) as f64;
        }
    }
}

/// The largest ratio of a derivative's weight to the weight.
#[inline(always)]
fn most_weight(by: &[DVec4], net: &[DVec4]) -> f64 {
    by.iter().zip(net).fold(0.0, |most, (by, c)| larger((by.w / c.w).abs(), most))
}

/// A bilinear fit of a function.
struct Fit {
    /// Its values at 00, 01, 10, 11.
    corners: [DVec4; 4],
    /// Largest distance of the function from it.
    error: f64,
}

/// The weights of a net, elevated by one degree in u and v: quotients of polynomials of that degree by them are in the hull of the
/// ratios of coefficients.
struct Elevated {
    /// Of the net, in u and v.
    points: [usize; 2],
    /// One over each weight.
    per_weight: SmallVec<[f64; 25]>,
}

/// Ratios of coefficients. The fourth coordinate means nothing.
struct Ratios(SmallVec<[DVec4; 25]>);

impl Elevated {
    #[inline(always)]
    fn new(net: &[DVec4], points_v: usize) -> Self {
        let mut elevated = Self { points: [net.len() / points_v, points_v], per_weight: SmallVec::new() };
        elevated.per_weight = elevated.minus(net, []).iter().map(|c| 1.0 / c.w).collect();
        elevated
    }

    /// The length and the fit of a first derivative of the surface, given the derivative of the net and the fit of the
    /// surface.
    #[inline(always)]
    fn first(&self, net: &[DVec4], by: &[DVec4], point: &Fit) -> (f64, Fit) {
        let error = most_weight(by, net) * point.error;
        let longest = self.over(by, [(by, point.corners)]).longest() + error;
        let [_, points_v] = self.points;
        let last = net.len() - 1;
        let corners = [0, points_v - 1, last + 1 - points_v, last];
        let ends = std::array::from_fn(|c| {
            let k = corners[c];
            (by[k] - point.corners[c] * by[k].w) / net[k].w
        });
        let fit = self.over(by, [(by, point.corners), (net, ends)]).fit(ends);
        (longest, Fit { error: fit.error + error, ..fit })
    }

    /// A polynomial less the weights of nets times bilinear functions, over the weights.
    #[inline(always)]
    fn over<const N: usize>(&self, f: &[DVec4], less: [(&[DVec4], [DVec4; 4]); N]) -> Ratios {
        let mut all = self.minus(f, less);
        all.iter_mut().zip(&self.per_weight).for_each(|(sum, per)| *sum *= *per);
        Ratios(all)
    }

    /// A polynomial less the weights of nets times bilinear functions.
    ///
    /// Coefficient `k` of `f` times a linear function `l` is `(1 - k/n) f_k l(0) + k/n f_(k-1) l(1)` if `f` has `n` of
    /// them: first along v, then along u.
    #[inline(always)]
    fn minus<const N: usize>(&self, f: &[DVec4], less: [(&[DVec4], [DVec4; 4]); N]) -> SmallVec<[DVec4; 25]> {
        let [points_u, points_v] = self.points;
        let (step_u, step_v) = (1.0 / points_u as f64, 1.0 / points_v as f64);
        let less = less.map(|(net, at)| (&net[..f.len()], at));
        let columns = points_v + 1;
        let mut sums: SmallVec<[DVec4; 25]> = SmallVec::from_elem(DVec4::ZERO, (points_u + 1) * columns);
        for i in 0..points_u {
            let (here, next) = (1.0 - i as f64 * step_u, (i + 1) as f64 * step_u);
            let mut carry = [DVec4::ZERO; 2];
            for j in 0..=points_v {
                let mut sum = carry;
                if j < points_v {
                    let k = i * points_v + j;
                    let (here, next) = (1.0 - j as f64 * step_v, (j + 1) as f64 * step_v);
                    let mut top = [f[k]; 4];
                    for (net, at) in &less {
                        let weight = net[k].w;
                        top = std::array::from_fn(|c| top[c] - at[c] * weight);
                    }
                    sum = [sum[0] + top[0] * here, sum[1] + top[2] * here];
                    carry = [top[1] * next, top[3] * next];
                }
                sums[i * columns + j] += sum[0] * here;
                sums[(i + 1) * columns + j] += sum[1] * next;
            }
        }
        sums
    }
}

impl Ratios {
    #[inline(always)]
    fn longest(&self) -> f64 {
        self.0.iter().fold(0.0, |most, q| larger(q.truncate().length_squared(), most)).sqrt()
    }

    /// The fit of a quotient. These are the ratios of its difference from the bilinear function with values `ends`.
    #[inline(always)]
    fn fit(&self, ends: [DVec4; 4]) -> Fit {
        let (low, high) = self.0.iter().fold((DVec4::INFINITY, DVec4::NEG_INFINITY), |(a, b), &q| (a.min(q), b.max(q)));
        let middle = (low + high) * 0.5;
        let far = self.0.iter().fold(0.0, |most, &q| larger((q - middle).truncate().length_squared(), most)).sqrt();
        Fit { corners: ends.map(|end| end + middle), error: far }
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
            let largest = bounds.dv.max(bounds.duv).max(bounds.dvv);
            assert!(largest <= 1e-12 * second, "{n}: {bounds:?}");
        }
    }
}
