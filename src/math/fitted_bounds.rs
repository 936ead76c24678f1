//! Large rational Bézier nets of any weights -> upper bounds on their first and second derivatives by the local
//! parameters.
//!
//! With `S = P / W`: `S_u = (P_u - W_u S) / W`, `S_uu = (P_uu - W_uu S - 2 W_u S_u) / W`,
//! `S_uv = (P_uv - W_uv S - W_v S_u - W_u S_v) / W` and so on. Bilinear fits replace `S`, `S_u` and `S_v`, and the
//! error of each times its factor is added. Each term is then one quotient by `W`, and the largest ratio of Bernstein
//! coefficients bounds it (mediant inequality; needs positive weights).

use super::lanes::{larger, widest};
use glam::DVec4;
use smallvec::SmallVec;

/// Bounds on the lengths of `S_u`, `S_v`, `S_uu`, `S_uv`, `S_vv`.
///
/// `control` is u-major, in rows of `points_v` homogeneous points with positive weights. Cost: linear in their number.
/// On bumpy nets of degree (5, 4) they are within 40 % of the true supremum.
pub(super) fn lengths(points_v: usize, control: &[DVec4]) -> [f64; 5] {
    widest(
        #[inline(always)]
        || all(points_v, control),
    )
}

#[inline(always)]
fn all(points_v: usize, control: &[DVec4]) -> [f64; 5] {
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
    let v = by_v(&net, points_v);
    let (uv, vv) = (by_v(&u, points_v), by_v(&v, points_v));
    let (dv, of_v) = elevated.first(&net, &v, &point);
    let (wv, wuv, wvv) = (most_weight(&v, &net), most_weight(&uv, &net), most_weight(&vv, &net));
    let duv = elevated.over(&uv, [(&uv, point.corners), (&v, of_u.corners), (&u, of_v.corners)]).longest();
    let dvv = elevated.over(&vv, [(&vv, point.corners), (&v, twice(&of_v))]).longest();
    let duv = duv + wuv * point.error + wv * of_u.error + wu * of_v.error;
    [du, dv, duu, duv, dvv + wvv * point.error + 2.0 * wv * of_v.error]
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

/// The weights of a net, elevated by one degree in u and v: quotients of polynomials of that degree by them are in the
/// hull of the ratios of coefficients.
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
