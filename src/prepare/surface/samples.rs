//! Nets of sub-boxes and segments -> how derivatives lie to the normal, and how far directions turn, at evenly spaced
//! samples.
//!
//! Four sub-boxes are evaluated at once, one per lane. Every lane does the arithmetic of a single point, in the same
//! order.

use crate::math::bernstein;
use crate::math::lanes::{Lanes, Plain, Work, in_fours};
use glam::{DVec3, DVec4};

/// Intervals between samples, per sub-box and direction; even.
const SAMPLES: usize = 4;
const COUNT: usize = SAMPLES + 1;
/// Sub-boxes that are evaluated at once.
pub(super) const BOXES: usize = 4;

/// A number of each sub-box, by lane.
type PerBox = [f64; BOXES];
/// A value at each sample, `[i][j]`: `i` along u, `j` along v.
type Grid<T> = [[T; COUNT]; COUNT];
/// Directions at the samples of a line; `None` where there is none.
type Directions = [Option<DVec3>; COUNT];

/// Samples stop 10⁻⁴ short of both ends.
const TO_ENDS: f64 = 1.0 + 4e-4;

/// The local parameter of sample `k`: evenly spaced, but the first and last slightly inside, where poles and collapsed
/// borders have a normal.
fn place(k: usize) -> f64 {
    match k {
        0 => 1e-4,
        SAMPLES => 1.0 - 1e-4,
        _ => k as f64 / SAMPLES as f64,
    }
}

/// Rows of the basis and its first and second derivatives at each sample.
pub(super) fn sample_rows(degree: usize) -> Vec<Vec<f64>> {
    let row = |k| {
        bernstein::with_rows(degree, |rows| {
            bernstein::basis_with_derivatives(degree, place(k), rows);
            rows.to_vec()
        })
    };
    (0..COUNT).map(row).collect()
}

/// Samples the sub-boxes of a surface, [`BOXES`] at once.
pub(super) struct Sampler {
    rational: bool,
    /// By sample and control point of a line: its basis function and two derivatives.
    rows_u: [Vec<[f64; 3]>; COUNT],
    rows_v: [Vec<[f64; 3]>; COUNT],
    /// The control points of the sub-boxes, u-major.
    nets: Vec<[DVec4; BOXES]>,
    /// The same, by coordinate.
    points: Vec<[PerBox; 4]>,
    /// The columns of the nets at a sample of u, with their derivatives.
    columns: Vec<[[PerBox; 4]; 3]>,
    samples: SurfaceSamples,
}

/// The samples of [`BOXES`] sub-boxes. Where a surface has no normal, all numbers are NaN.
pub(super) struct SurfaceSamples {
    normals: Grid<[PerBox; 3]>,
    /// For each of `S_uu`, `S_uv`, `S_vv`: signed part along the normal, and length of the rest.
    bends: Grid<[PerBox; 6]>,
}

impl Sampler {
    /// For nets of `degree_u` and `degree_v`. If not `rational`, all weights are 1.
    pub(super) fn new(degree_u: usize, degree_v: usize, rational: bool) -> Self {
        let rows = |degree: usize| {
            let rows = sample_rows(degree);
            let at = |k: usize, b: usize| [0, 1, 2].map(|order| rows[k][order * (degree + 1) + b]);
            std::array::from_fn(|k| (0..=degree).map(|b| at(k, b)).collect())
        };
        const ZERO: PerBox = [0.0; BOXES];
        Self {
            rational,
            rows_u: rows(degree_u),
            rows_v: rows(degree_v),
            nets: vec![[DVec4::ZERO; BOXES]; (degree_u + 1) * (degree_v + 1)],
            points: vec![[ZERO; 4]; (degree_u + 1) * (degree_v + 1)],
            columns: vec![[[ZERO; 4]; 3]; degree_v + 1],
            samples: SurfaceSamples { normals: [[[ZERO; 3]; COUNT]; COUNT], bends: [[[ZERO; 6]; COUNT]; COUNT] },
        }
    }

    /// Sets the net, u-major, of the sub-box in `lane`.
    pub(super) fn set(&mut self, lane: usize, net: &[DVec4]) {
        self.nets.iter_mut().zip(net).for_each(|(points, point)| points[lane] = *point);
    }

    /// Evaluates the nets that are set, in lanes below `count` (1 to [`BOXES`]), at all samples. Other lanes repeat the
    /// last one.
    pub(super) fn sample(&mut self, count: usize) -> &SurfaceSamples {
        for (points, point) in self.nets.iter_mut().zip(&mut self.points) {
            let last = points[count - 1];
            points[count..].fill(last);
            *point = [0, 1, 2, 3].map(|c| points.map(|p| p[c]));
        }
        if self.rational {
            in_fours(Sample::<4>(self))
        } else {
            in_fours(Sample::<3>(self))
        }
        &self.samples
    }
}

/// Evaluates all samples with the first `N` coordinates of the nets: the weights are the fourth.
struct Sample<'a, const N: usize>(&'a mut Sampler);

impl<const N: usize> Work for Sample<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes<BOXES>>(self, zero: F) {
        let Sampler { rows_u, rows_v, points, columns, samples: SurfaceSamples { normals, bends }, .. } = self.0;
        for ((row_u, normals), bends) in rows_u.iter().zip(normals).zip(bends) {
            // First each column of the nets with all orders in u, then the columns with the orders in v.
            for (b, column) in columns.iter_mut().enumerate() {
                let mut sums = [[zero; N]; 3];
                for (line, row) in points.chunks_exact(rows_v[0].len()).zip(row_u) {
                    for c in 0..N {
                        let x = zero.load(&line[b][c]);
                        for (sums, row) in sums.iter_mut().zip(row) {
                            sums[c] = sums[c] + x * zero.splat(*row);
                        }
                    }
                }
                for (column, sums) in column.iter_mut().zip(sums) {
                    column.iter_mut().zip(sums).for_each(|(to, sum)| *to = sum.to_array());
                }
            }
            for ((row_v, normal), bend) in rows_v.iter().zip(normals).zip(bends) {
                let at = (&**columns, &**row_v);
                let sums: [[F; N]; 6] = [
                    sum(zero, at, (0, 0)),
                    sum(zero, at, (1, 0)),
                    sum(zero, at, (0, 1)),
                    sum(zero, at, (2, 0)),
                    sum(zero, at, (1, 1)),
                    sum(zero, at, (0, 2)),
                ];
                let d = if N == 4 { quotient(zero, &sums) } else { plain(&sums) };
                let (n, [a, b, c, d, e, f]) = split(zero, d);
                *normal = [n[0].to_array(), n[1].to_array(), n[2].to_array()];
                *bend = [a.to_array(), b.to_array(), c.to_array(), d.to_array(), e.to_array(), f.to_array()];
            }
        }
    }
}

impl SurfaceSamples {
    /// The largest magnitude of each bend of each sub-box, with a margin for maxima between samples: for each of
    /// `S_uu`, `S_uv`, `S_vv`, the part along the normal and the rest.
    ///
    /// A parabola exceeds its samples by at most an eighth of the second difference; the margin is twice that, along u
    /// and v.
    pub(super) fn most(&self) -> [PerBox; 6] {
        in_fours(Most(self))
    }

    /// The largest turning of each normal along a line of samples in u, and in v, with a margin for what lines miss: the
    /// overshoot of a parabola through neighbours.
    pub(super) fn turns(&self) -> [PerBox; 2] {
        in_fours(Turns(self))
    }

    /// Whether the normal of a sub-box changes its side between neighbours. Halves of such a box turn as far.
    pub(super) fn fold_over(&self, lane: usize) -> bool {
        /// The angle between neighbours is above 120 degrees. Smooth surfaces that turn so far between samples turn by
        /// more than 360 degrees in the box.
        const OTHER_SIDE: f64 = -0.5;
        let dot = |(i, j): (usize, usize), (k, l): (usize, usize)| -> f64 {
            (0..3).map(|c| self.normals[i][j][c][lane] * self.normals[k][l][c][lane]).sum()
        };
        let mut pairs = (0..COUNT).flat_map(|i| (1..COUNT).map(move |k| (i, k)));
        pairs.any(|(i, k)| dot((i, k - 1), (i, k)) < OTHER_SIDE || dot((k - 1, i), (k, i)) < OTHER_SIDE)
    }
}

/// What [`SurfaceSamples::most`] does.
struct Most<'a>(&'a SurfaceSamples);

impl Work for Most<'_> {
    type Output = [PerBox; 6];

    #[inline(always)]
    fn run<F: Lanes<BOXES>>(self, zero: F) -> [PerBox; 6] {
        let (two, quarter) = (zero.splat(2.0), zero.splat(0.25));
        let mut all = [[0.0; BOXES]; 6];
        for (k, all) in all.iter_mut().enumerate() {
            let at = |i: usize, j: usize| zero.load(&self.0.bends[i][j][k]);
            let (mut most, mut by_u, mut by_v) = (zero, zero, zero);
            for a in 0..COUNT {
                for b in 0..COUNT {
                    most = raised(zero, most, at(a, b));
                }
                for b in 1..SAMPLES {
                    by_u = raised(zero, by_u, at(b - 1, a) - two * at(b, a) + at(b + 1, a));
                    by_v = raised(zero, by_v, at(a, b - 1) - two * at(a, b) + at(a, b + 1));
                }
            }
            *all = (most + quarter * (by_u + by_v)).to_array();
        }
        all
    }
}

/// What [`SurfaceSamples::turns`] does.
struct Turns<'a>(&'a SurfaceSamples);

impl Work for Turns<'_> {
    type Output = [PerBox; 2];

    #[inline(always)]
    fn run<F: Lanes<BOXES>>(self, zero: F) -> [PerBox; 2] {
        let n = &self.0.normals;
        let mut turns = [[0.0; BOXES]; 2];
        for (axis, turns) in turns.iter_mut().enumerate() {
            let mut by_line = [zero; COUNT];
            for (k, by_line) in by_line.iter_mut().enumerate() {
                let at = |i: usize| if axis == 0 { &n[i][k] } else { &n[k][i] };
                *by_line = turnings(zero, [at(0), at(1), at(2), at(3), at(4)]);
            }
            let most = by_line.iter().fold(zero, |most, turn| raised(zero, most, *turn));
            let bend =
                by_line.windows(3).fold(zero, |most, t| raised(zero, most, t[0] - zero.splat(2.0) * t[1] + t[2]));
            *turns = ((most + zero.splat(0.125) * bend) * zero.splat(TO_ENDS)).to_array();
        }
        turns
    }
}

/// How far the tangent of a segment turns, given the basis rows at the samples.
pub(super) fn tangent_turning(net: &[DVec4], rows: &[Vec<f64>]) -> f64 {
    let degree = net.len() - 1;
    let mut tangents: Directions = [None; COUNT];
    for (tangent, row) in tangents.iter_mut().zip(rows) {
        let (n, d) = row[..2 * (degree + 1)].split_at(degree + 1);
        let (p, p1) = (bernstein::dot(n, net), bernstein::dot(d, net));
        *tangent = (p1.truncate() * p.w - p.truncate() * p1.w).try_normalize();
    }
    turning(&tangents) * TO_ENDS
}

/// `most` or the magnitude of `x`, which counts as nothing where it is NaN.
#[inline(always)]
fn raised<F: Lanes<BOXES>>(zero: F, most: F, x: F) -> F {
    x.larger((zero - x).larger(most))
}

#[inline(always)]
fn times<F: Lanes<BOXES>>([x, y, z]: [F; 3], factor: F) -> [F; 3] {
    [x * factor, y * factor, z * factor]
}

#[inline(always)]
fn minus<F: Lanes<BOXES>>(a: [F; 3], b: [F; 3]) -> [F; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<F: Lanes<BOXES>>(a: [F; 3], b: [F; 3]) -> F {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn length<F: Lanes<BOXES>>(a: [F; 3]) -> F {
    dot(a, a).sqrt()
}

#[inline(always)]
fn cross<F: Lanes<BOXES>>(a: [F; 3], b: [F; 3]) -> [F; 3] {
    [a[1] * b[2] - b[1] * a[2], a[2] * b[0] - b[2] * a[0], a[0] * b[1] - b[0] * a[1]]
}

/// The columns of nets at a sample of u, and their basis at a sample of v.
type Terms<'a> = (&'a [[[PerBox; 4]; 3]], &'a [[f64; 3]]);

/// The derivative of the orders `of` of the weighted points and, if `N` is 4, of their weights.
#[inline(always)]
fn sum<F: Lanes<BOXES>, const N: usize>(zero: F, (columns, row): Terms<'_>, of: (usize, usize)) -> [F; N] {
    let mut sum = [zero; N];
    for (column, row) in columns.iter().zip(row) {
        let factor = zero.splat(row[of.1]);
        for (sum, x) in sum.iter_mut().zip(&column[of.0]) {
            *sum = *sum + zero.load(x) * factor;
        }
    }
    sum
}

/// `a - factor · b`.
#[inline(always)]
fn minus_times<F: Lanes<BOXES>>(a: [F; 3], b: [F; 3], factor: F) -> [F; 3] {
    minus(a, times(b, factor))
}

/// Derivatives of `P / W` from those of `P` and `W`, as [`quotient`](crate::model::quotient) has them.
#[inline(always)]
fn quotient<F: Lanes<BOXES>, const N: usize>(zero: F, sums: &[[F; N]; 6]) -> [[F; 3]; 6] {
    let p = plain(sums);
    let w = [sums[0][N - 1], sums[1][N - 1], sums[2][N - 1], sums[3][N - 1], sums[4][N - 1], sums[5][N - 1]];
    let (per, two) = (zero.splat(1.0) / w[0], zero.splat(2.0));
    let point = times(p[0], per);
    let du = times(minus_times(p[1], point, w[1]), per);
    let dv = times(minus_times(p[2], point, w[2]), per);
    let duu = times(minus_times(minus_times(p[3], du, two * w[1]), point, w[3]), per);
    let duv = times(minus_times(minus_times(minus_times(p[4], du, w[2]), dv, w[1]), point, w[4]), per);
    let dvv = times(minus_times(minus_times(p[5], dv, two * w[2]), point, w[5]), per);
    [point, du, dv, duu, duv, dvv]
}

/// Derivatives where all weights are 1.
#[inline(always)]
fn plain<F: Lanes<BOXES>, const N: usize>(sums: &[[F; N]; 6]) -> [[F; 3]; 6] {
    let of = |k: usize| [sums[k][0], sums[k][1], sums[k][2]];
    [of(0), of(1), of(2), of(3), of(4), of(5)]
}

/// The normals, and the parts of the second derivatives along and across them.
#[inline(always)]
fn split<F: Lanes<BOXES>>(zero: F, [_, du, dv, duu, duv, dvv]: [[F; 3]; 6]) -> ([F; 3], [F; 6]) {
    let normal = cross(du, dv);
    let (all, of_u, of_v) = (length(normal), length(du), length(dv));
    let mut per = zero.splat(1.0) / all;
    let exist = (zero.splat(1e-10) * of_u * of_v).below(all) & per.below(zero.splat(f64::INFINITY)) & zero.below(per);
    if exist != (1 << BOXES) - 1 {
        let mut each = per.to_array();
        (0..BOXES).filter(|l| exist >> l & 1 == 0).for_each(|l| each[l] = f64::NAN);
        per = zero.load(&each);
    }
    let normal = times(normal, per);
    let ([a, b], [c, d], [e, f]) = (parts(duu, normal), parts(duv, normal), parts(dvv, normal));
    (normal, [a, b, c, d, e, f])
}

/// The part of a vector along the normal, and the length of the rest.
#[inline(always)]
fn parts<F: Lanes<BOXES>>(x: [F; 3], normal: [F; 3]) -> [F; 2] {
    let along = dot(x, normal);
    [along, length(minus(x, times(normal, along)))]
}

/// [`turning`] of normals along a line, by lane.
#[inline(always)]
fn turnings<F: Lanes<BOXES>>(zero: F, line: [&[PerBox; 3]; COUNT]) -> F {
    let n = [load(zero, line[0]), load(zero, line[1]), load(zero, line[2]), load(zero, line[3]), load(zero, line[4])];
    let fine =
        angles(zero, n[0], n[1]) + angles(zero, n[1], n[2]) + angles(zero, n[2], n[3]) + angles(zero, n[3], n[4]);
    let coarse = angles(zero, n[0], n[2]) + angles(zero, n[2], n[4]);
    let all = fine + (fine - coarse).larger(zero);
    if fine.below(zero.splat(f64::INFINITY)) == (1 << BOXES) - 1 {
        return all;
    }
    let (mut each, fine) = (all.to_array(), fine.to_array());
    for (l, turn) in each.iter_mut().enumerate().filter(|(l, _)| fine[*l].is_nan()) {
        *turn = turning(&line.map(|n| Some(DVec3::from_array(n.map(|c| c[l]))).filter(|n| !n.is_nan())));
    }
    zero.load(&each)
}

#[inline(always)]
fn load<F: Lanes<BOXES>>(zero: F, [x, y, z]: &[PerBox; 3]) -> [F; 3] {
    [zero.load(x), zero.load(y), zero.load(z)]
}

/// The angles between unit vectors.
#[inline(always)]
fn angles<F: Lanes<BOXES>>(zero: F, a: [F; 3], b: [F; 3]) -> F {
    let chord = length(minus(b, a));
    if zero.splat(SHORT).below(chord) == 0 {
        short_angle(zero, chord)
    } else {
        zero.load(&chord.to_array().map(chord_angle))
    }
}

/// The turning along a line, with a margin for what samples miss: the growth of the sum of angles when the samples were
/// doubled. Exact where directions turn in one plane and one way.
fn turning(samples: &Directions) -> f64 {
    let halved: [Option<DVec3>; SAMPLES / 2 + 1] = std::array::from_fn(|k| samples[2 * k]);
    let (fine, coarse) = (path(samples), path(&halved));
    fine + (fine - coarse).max(0.0)
}

/// The sum of the angles between successive directions.
fn path(directions: &[Option<DVec3>]) -> f64 {
    let directions = directions.iter().flatten();
    let pairs = directions.clone().zip(directions.skip(1));
    pairs.fold(0.0, |sum, (before, here)| sum + chord_angle(here.distance(*before)))
}

/// Chords up to this have their angle by a series.
const SHORT: f64 = 0.1;

/// The angle subtended by a chord of the unit circle, to 10⁻⁹. NaN stays: it marks lines that lack a direction.
fn chord_angle(chord: f64) -> f64 {
    if chord > SHORT {
        return 2.0 * libm::asin((0.5 * chord).min(1.0));
    }
    short_angle(Plain([0.0]), Plain([chord])).to_array()[0]
}

/// [`chord_angle`] up to [`SHORT`].
#[inline(always)]
fn short_angle<const L: usize, F: Lanes<L>>(zero: F, chord: F) -> F {
    let square = chord * chord;
    chord * (zero.splat(1.0) + square * (zero.splat(1.0 / 24.0) + square * zero.splat(3.0 / 640.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{SurfaceDerivatives, quotient};
    use crate::sequence::random::SplitMix;

    /// A point's normal and bends, by the arithmetic of a single point.
    fn single(net: &[DVec4], rows: [&[f64]; 2], rational: bool) -> Option<(DVec3, [f64; 6])> {
        let [nu, nv] = rows.map(|row| row.len() / 3);
        let sums = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)].map(|(by_u, by_v)| {
            (0..nv).fold(DVec4::ZERO, |sum, b| {
                let column = (0..nu).fold(DVec4::ZERO, |sum, a| sum + net[a * nv + b] * rows[0][by_u * nu + a]);
                sum + column * rows[1][by_v * nv + b]
            })
        });
        let p = sums.map(DVec4::truncate);
        let plain = SurfaceDerivatives { point: p[0], du: p[1], dv: p[2], duu: p[3], duv: p[4], dvv: p[5] };
        let d = if rational { quotient(p, sums.map(|sum| sum.w)) } else { plain };
        let normal = d.du.cross(d.dv);
        let exists = normal.length() > 1e-10 * d.du.length() * d.dv.length();
        let normal = normal.try_normalize().filter(|_| exists)?;
        let parts = |x: DVec3| [x.dot(normal), (x - normal * x.dot(normal)).length()];
        let [[a, b], [c, d], [e, f]] = [d.duu, d.duv, d.dvv].map(parts);
        Some((normal, [a, b, c, d, e, f]))
    }

    /// Nets of random points, but for a single point, which has no normal, and a fold without a normal in its middle.
    fn nets(draw: &mut SplitMix, [nu, nv]: [usize; 2], rational: bool) -> [Vec<DVec4>; BOXES] {
        let mut point = |_| DVec3::from_array([(); 3].map(|()| draw.range(-5.0, 5.0)));
        let mut all = [(); BOXES].map(|()| (0..nu * nv).map(&mut point).collect::<Vec<_>>());
        let first = all[2][0];
        all[2].fill(first);
        for (k, point) in all[1].iter_mut().enumerate() {
            let (i, j) = (k / nv, k % nv);
            *point = DVec3::new(i.min(nu - 1 - i) as f64, j as f64, 0.0);
        }
        all.map(|net| {
            let weight = |k: usize| if rational { 1.0 + 0.25 * (k % nv) as f64 } else { 1.0 };
            net.into_iter().enumerate().map(|(k, point)| (point * weight(k)).extend(weight(k))).collect()
        })
    }

    #[test]
    fn lanes_have_the_bits_of_single_points() {
        let mut draw = SplitMix(7);
        let mut without_normal = 0;
        for (degree_u, degree_v) in [(1, 1), (1, 3), (2, 2), (3, 3), (5, 2), (4, 6)] {
            let (rows_u, rows_v) = (sample_rows(degree_u), sample_rows(degree_v));
            for rational in [false, true] {
                let mut sampler = Sampler::new(degree_u, degree_v, rational);
                let nets = nets(&mut draw, [degree_u + 1, degree_v + 1], rational);
                nets.iter().enumerate().for_each(|(lane, net)| sampler.set(lane, net));
                let samples = sampler.sample(BOXES);
                let (turns, most) = (samples.turns(), samples.most());
                for (lane, net) in nets.iter().enumerate() {
                    let expected: Grid<_> = std::array::from_fn(|i| {
                        std::array::from_fn(|j| single(net, [&rows_u[i], &rows_v[j]], rational))
                    });
                    let exist = expected.iter().flatten().flatten().count();
                    without_normal += usize::from((1..COUNT * COUNT).contains(&exist));
                    for (i, j) in (0..COUNT).flat_map(|i| (0..COUNT).map(move |j| (i, j))) {
                        let normal = DVec3::from_array(samples.normals[i][j].map(|c| c[lane]));
                        let bends = samples.bends[i][j].map(|bend| bend[lane]);
                        match expected[i][j] {
                            Some(expected) => assert_eq!((normal, bends), expected, "{degree_u} {degree_v} {i} {j}"),
                            None => assert!(normal.is_nan(), "{degree_u} {degree_v} {i} {j}"),
                        }
                    }
                    let along = |of: &dyn Fn(usize, usize) -> Option<DVec3>| -> f64 {
                        (0..COUNT).map(|line| turning(&std::array::from_fn(|k| of(line, k)))).fold(0.0, f64::max)
                    };
                    let normal = |i: usize, j: usize| expected[i][j].map(|(normal, _)| normal);
                    let least = [along(&|line, k| normal(k, line)), along(&|line, k| normal(line, k))];
                    assert!((0..2).all(|k| turns[k][lane] >= least[k] * TO_ENDS), "{turns:?} {least:?}");
                    for (k, most) in most.iter().enumerate() {
                        let at = |i: usize, j: usize| expected[i][j].map_or(f64::NAN, |(_, bends)| bends[k]);
                        let (mut all, mut by_u, mut by_v) = (0.0_f64, 0.0_f64, 0.0_f64);
                        for (i, j) in (0..COUNT).flat_map(|i| (0..COUNT).map(move |j| (i, j))) {
                            all = all.max(at(i, j).abs());
                            if (1..SAMPLES).contains(&i) {
                                by_u = by_u.max((at(i - 1, j) - 2.0 * at(i, j) + at(i + 1, j)).abs());
                            }
                            if (1..SAMPLES).contains(&j) {
                                by_v = by_v.max((at(i, j - 1) - 2.0 * at(i, j) + at(i, j + 1)).abs());
                            }
                        }
                        assert_eq!(most[lane], all + 0.25 * (by_u + by_v), "{degree_u} {degree_v} {lane} {k}");
                    }
                }
                // Fewer nets after four.
                for count in 1..BOXES {
                    (0..count).for_each(|lane| sampler.set(lane, &nets[BOXES - 1 - lane]));
                    let fewer = sampler.sample(count);
                    for (of_fewer, of_all) in
                        [(fewer.most().to_vec(), most.to_vec()), (fewer.turns().to_vec(), turns.to_vec())]
                    {
                        for (a, b) in of_fewer.iter().zip(&of_all) {
                            assert!((0..count).all(|lane| a[lane] == b[BOXES - 1 - lane]), "{count}");
                        }
                    }
                }
            }
        }
        assert!(without_normal > 0, "folds have normals everywhere");
    }

    /// The turnings of a line of normals, by lane.
    struct Turnings<'a>(&'a [[PerBox; 3]; COUNT]);

    impl Work for Turnings<'_> {
        type Output = PerBox;

        fn run<F: Lanes<BOXES>>(self, zero: F) -> PerBox {
            turnings(zero, self.0.each_ref()).to_array()
        }
    }

    #[test]
    fn turnings_in_lanes_are_those_of_single_lines() {
        let mut draw = SplitMix(8);
        // Chords below and above `SHORT`, both, and lines without a direction somewhere.
        for (spread, hole) in [(0.01, None), (0.08, None), (1.0, None), (0.03, Some((2, 1))), (1.0, Some((4, 3)))] {
            let line: [[PerBox; 3]; COUNT] = std::array::from_fn(|k| {
                let of: [DVec3; BOXES] = std::array::from_fn(|l| {
                    let [x, y] = [(); 2].map(|()| draw.range(-spread, spread));
                    if hole == Some((k, l)) { DVec3::NAN } else { DVec3::new(x, y, 1.0).normalize() }
                });
                [0, 1, 2].map(|c| of.map(|n| n[c]))
            });
            for (l, turn) in in_fours(Turnings(&line)).into_iter().enumerate() {
                let normal = |k: usize| DVec3::from_array(line[k].map(|c| c[l]));
                let single = turning(&std::array::from_fn(|k| Some(normal(k)).filter(|normal| !normal.is_nan())));
                assert!(turn == single, "{spread} {hole:?} {l}: {turn} {single}");
            }
        }
    }
}
