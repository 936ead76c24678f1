//! Nets of sub-boxes and segments -> how derivatives lie to the normal, and how far directions turn, at evenly spaced
//! samples.
//!
//! A row of samples along v is evaluated at once, in lanes. Every lane does the arithmetic of a single point, in the
//! same order.

use crate::math::Elementary as _;
use crate::math::bernstein;
use crate::math::lanes::widest;
use glam::{DVec3, DVec4};

/// Intervals between samples, per sub-box and direction; even.
const SAMPLES: usize = 4;
const COUNT: usize = SAMPLES + 1;
/// Samples of a row, filled up with copies of the last one.
const LANES: usize = 8;

type Lanes = [f64; LANES];
/// Vectors, by coordinate.
type Vectors = [Lanes; 3];
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

/// Basis rows at the samples of a net, shared by all sub-boxes.
pub(super) struct Sampler {
    rational: bool,
    rows_u: Vec<Vec<f64>>,
    /// By control point: its basis function and two derivatives at the samples of a row.
    rows_v: Vec<[Lanes; 3]>,
    /// The columns of the net at a sample of u, with their derivatives.
    columns: Vec<[[f64; 4]; 3]>,
    samples: SurfaceSamples,
}

/// A sub-box's samples, row by row along v. Where the surface has no normal, all numbers are NaN.
pub(super) struct SurfaceSamples {
    normals: [Vectors; COUNT],
    /// For each of `S_uu`, `S_uv`, `S_vv`: signed part along the normal, and length of the rest.
    bends: [[Lanes; 6]; COUNT],
}

impl Sampler {
    /// For nets of `degree_u` and `degree_v`. If not `rational`, all weights are 1.
    pub(super) fn new(degree_u: usize, degree_v: usize, rational: bool) -> Self {
        let rows = sample_rows(degree_v);
        let lanes = |b: usize| [0, 1, 2].map(|order| lanes(|k| rows[k.min(SAMPLES)][order * (degree_v + 1) + b]));
        Self {
            rational,
            rows_u: sample_rows(degree_u),
            rows_v: (0..=degree_v).map(lanes).collect(),
            columns: vec![[[0.0; 4]; 3]; degree_v + 1],
            samples: SurfaceSamples { normals: [[[0.0; LANES]; 3]; COUNT], bends: [[[0.0; LANES]; 6]; COUNT] },
        }
    }

    /// Evaluates a net, u-major, at all samples.
    pub(super) fn sample(&mut self, net: &[DVec4]) -> &SurfaceSamples {
        widest(
            #[inline(always)]
            || if self.rational { self.evaluate::<4>(net) } else { self.evaluate::<3>(net) },
        );
        &self.samples
    }

    /// Evaluates all samples with the first `N` coordinates of the net: the weights are the fourth.
    #[inline(always)]
    fn evaluate<const N: usize>(&mut self, net: &[DVec4]) {
        let Self { rows_u, rows_v, columns, samples: SurfaceSamples { normals, bends }, .. } = self;
        let nv = rows_v.len();
        // First each column of the net with all orders in u, then the columns with the orders in v.
        for ((row_u, normals), bends) in rows_u.iter().zip(normals).zip(bends) {
            let (n, rest) = row_u.split_at(row_u.len() / 3);
            let (d1, d2) = rest.split_at(n.len());
            for (b, column) in columns.iter_mut().enumerate() {
                let mut sums = [[0.0; 4]; 3];
                for (((point, n), d1), d2) in net[b..].iter().step_by(nv).zip(n).zip(d1).zip(d2) {
                    for (sum, factor) in sums.iter_mut().zip([n, d1, d2]) {
                        sum.iter_mut().zip(point.to_array()).for_each(|(sum, x)| *sum += x * factor);
                    }
                }
                *column = sums;
            }
            let columns = columns.iter().zip(&*rows_v);
            let sums = [
                sum::<N>(columns.clone(), (0, 0)),
                sum(columns.clone(), (1, 0)),
                sum(columns.clone(), (0, 1)),
                sum(columns.clone(), (2, 0)),
                sum(columns.clone(), (1, 1)),
                sum(columns, (0, 2)),
            ];
            let [_, du, dv, duu, duv, dvv] = if N == 4 { quotient(&sums) } else { plain(&sums) };
            (*normals, *bends) = split([&du, &dv], [&duu, &duv, &dvv]);
        }
    }
}

impl SurfaceSamples {
    /// The largest magnitude of each of its bends, with a margin for maxima between samples: for each of `S_uu`, `S_uv`,
    /// `S_vv`, the part along the normal and the rest.
    ///
    /// A parabola exceeds its samples by at most an eighth of the second difference; the margin is twice that, along u
    /// and v.
    pub(super) fn most(&self) -> [f64; 6] {
        widest(
            #[inline(always)]
            || {
                let mut all = [0.0; 6];
                for (k, all) in all.iter_mut().enumerate() {
                    let at = |i: usize, l: usize| self.bends[i][k][l];
                    let (mut most, mut by_u, mut by_v) = ([0.0; LANES], [0.0; LANES], [0.0; SAMPLES - 1]);
                    for i in 0..COUNT {
                        raise(&mut most, |l| at(i, l));
                        raise(&mut by_v, |l| at(i, l) - 2.0 * at(i, l + 1) + at(i, l + 2));
                    }
                    for i in 1..SAMPLES {
                        raise(&mut by_u, |l| at(i - 1, l) - 2.0 * at(i, l) + at(i + 1, l));
                    }
                    *all = largest(&most) + 0.25 * (largest(&by_u) + largest(&by_v));
                }
                all
            },
        )
    }

    /// The largest turning of the normal along a line of samples in u, and in v, with a margin for what lines miss: the
    /// overshoot of a parabola through neighbours.
    pub(super) fn turns(&self) -> [f64; 2] {
        let across: [Vectors; COUNT] =
            std::array::from_fn(|j| std::array::from_fn(|c| lanes(|l| self.normals[l.min(SAMPLES)][c][j])));
        [&self.normals, &across].map(|rows| {
            let turning = turnings(rows);
            let most = turning.iter().copied().fold(0.0_f64, f64::max);
            let bend = turning.windows(3).map(|t| (t[0] - 2.0 * t[1] + t[2]).abs()).fold(0.0_f64, f64::max);
            (most + 0.125 * bend) * TO_ENDS
        })
    }
}

/// How far the tangent of a segment turns, given the basis rows at the samples.
pub(super) fn tangent_turning(net: &[DVec4], rows: &[Vec<f64>]) -> f64 {
    let degree = net.len() - 1;
    let mut tangents: Directions = [None; COUNT];
    for (tangent, row) in tangents.iter_mut().zip(rows) {
        let (n, d) = row[..2 * (degree + 1)].split_at(degree + 1);
        let dot = |f: &[f64]| f.iter().zip(net).fold(DVec4::ZERO, |sum, (&f, &c)| sum + c * f);
        let (p, p1) = (dot(n), dot(d));
        *tangent = (p1.truncate() * p.w - p.truncate() * p1.w).try_normalize();
    }
    turning(&tangents) * TO_ENDS
}

#[inline(always)]
fn lanes(of: impl Fn(usize) -> f64) -> Lanes {
    let mut out = [0.0; LANES];
    for (l, out) in out.iter_mut().enumerate() {
        *out = of(l);
    }
    out
}

/// Vectors by coordinate.
#[inline(always)]
fn vectors(of: impl Fn(usize) -> Lanes) -> Vectors {
    [of(0), of(1), of(2)]
}

/// Raises `most` to the magnitude of `x`, which counts as nothing where it is NaN.
#[inline(always)]
fn raise(most: &mut [f64], x: impl Fn(usize) -> f64) {
    for (l, most) in most.iter_mut().enumerate() {
        let x = x(l).abs();
        *most = if x > *most { x } else { *most };
    }
}

#[inline(always)]
fn largest(of: &[f64]) -> f64 {
    of.iter().fold(0.0, |most, &x| if x > most { x } else { most })
}

#[inline(always)]
fn times(a: &Vectors, factor: &Lanes) -> Vectors {
    vectors(|c| lanes(|l| a[c][l] * factor[l]))
}

#[inline(always)]
fn minus(a: &Vectors, b: &Vectors) -> Vectors {
    vectors(|c| lanes(|l| a[c][l] - b[c][l]))
}

#[inline(always)]
fn dot(a: &Vectors, b: &Vectors) -> Lanes {
    lanes(|l| a[0][l] * b[0][l] + a[1][l] * b[1][l] + a[2][l] * b[2][l])
}

#[inline(always)]
fn length(a: &Vectors) -> Lanes {
    let square = dot(a, a);
    lanes(|l| square[l].sqrt())
}

#[inline(always)]
fn cross(a: &Vectors, b: &Vectors) -> Vectors {
    let minor = |c: usize, d: usize| lanes(|l| a[c][l] * b[d][l] - b[c][l] * a[d][l]);
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

/// The derivative of the orders `of` of the weighted point and, if `N` is 4, of its weight.
#[inline(always)]
fn sum<'a, const N: usize>(
    columns: impl Iterator<Item = (&'a [[f64; 4]; 3], &'a [Lanes; 3])>,
    of: (usize, usize),
) -> [Lanes; N] {
    let mut sum = [[0.0; LANES]; N];
    for (column, row) in columns {
        for (sum, c) in sum.iter_mut().zip(column[of.0]) {
            *sum = lanes(|l| sum[l] + c * row[of.1][l]);
        }
    }
    sum
}

/// Derivatives of `P / W` from those of `P` and `W`, as [`quotient`](crate::model::quotient) has them.
#[inline(always)]
fn quotient<const N: usize>(sums: &[[Lanes; N]; 6]) -> [Vectors; 6] {
    let p = plain(sums);
    let w = |k: usize| &sums[k][N - 1];
    let twice = |a: &Lanes| lanes(|l| 2.0 * a[l]);
    let per = lanes(|l| 1.0 / w(0)[l]);
    let point = times(&p[0], &per);
    let less = |a: &Vectors, b: &Vectors, factor: &Lanes| minus(a, &times(b, factor));
    let du = times(&less(&p[1], &point, w(1)), &per);
    let dv = times(&less(&p[2], &point, w(2)), &per);
    let duu = times(&less(&less(&p[3], &du, &twice(w(1))), &point, w(3)), &per);
    let duv = times(&less(&less(&less(&p[4], &du, w(2)), &dv, w(1)), &point, w(4)), &per);
    let dvv = times(&less(&less(&p[5], &dv, &twice(w(2))), &point, w(5)), &per);
    [point, du, dv, duu, duv, dvv]
}

/// Derivatives where all weights are 1.
#[inline(always)]
fn plain<const N: usize>(sums: &[[Lanes; N]; 6]) -> [Vectors; 6] {
    let of = |k: usize| vectors(|c| sums[k][c]);
    [of(0), of(1), of(2), of(3), of(4), of(5)]
}

/// The normals, and the parts of the second derivatives along and across them.
#[inline(always)]
fn split([du, dv]: [&Vectors; 2], [duu, duv, dvv]: [&Vectors; 3]) -> (Vectors, [Lanes; 6]) {
    let normal = cross(du, dv);
    let (all, of_u, of_v) = (length(&normal), length(du), length(dv));
    let per = lanes(|l| {
        let per = 1.0 / all[l];
        let exists = all[l] > 1e-10 * of_u[l] * of_v[l] && per.is_finite() && per > 0.0;
        if exists { per } else { f64::NAN }
    });
    let normal = times(&normal, &per);
    let ([a, b], [c, d], [e, f]) = (parts(duu, &normal), parts(duv, &normal), parts(dvv, &normal));
    (normal, [a, b, c, d, e, f])
}

/// The part of a vector along the normal, and the length of the rest.
#[inline(always)]
fn parts(x: &Vectors, normal: &Vectors) -> [Lanes; 2] {
    let along = dot(x, normal);
    [along, length(&minus(x, &times(normal, &along)))]
}

/// [`turning`] of the normals from row to row, by lane.
fn turnings(rows: &[Vectors; COUNT]) -> [f64; COUNT] {
    let (mut fine, mut coarse) = ([[0.0; LANES]; SAMPLES], [[0.0; LANES]; SAMPLES / 2]);
    widest(
        #[inline(always)]
        || {
            let chord = |a: usize, b: usize| length(&minus(&rows[b], &rows[a]));
            fine.iter_mut().enumerate().for_each(|(k, fine)| *fine = chord(k, k + 1));
            coarse.iter_mut().enumerate().for_each(|(k, coarse)| *coarse = chord(2 * k, 2 * k + 2));
        },
    );
    std::array::from_fn(|l| {
        let sum = |chords: &[Lanes]| chords.iter().fold(0.0, |sum, chord| sum + chord_angle(chord[l]));
        if fine.iter().any(|chord| chord[l].is_nan()) {
            let normal = |k: usize| DVec3::from_array(rows[k].map(|row| row[l]));
            return turning(&std::array::from_fn(|k| Some(normal(k)).filter(|normal| !normal.is_nan())));
        }
        let (fine, coarse) = (sum(&fine), sum(&coarse));
        fine + (fine - coarse).max(0.0)
    })
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

/// The angle subtended by a chord of the unit circle; below 0.1 by a series that is good to 10⁻⁹.
fn chord_angle(chord: f64) -> f64 {
    if chord < 0.1 {
        let square = chord * chord;
        return chord * (1.0 + square * (1.0 / 24.0 + square * (3.0 / 640.0)));
    }
    2.0 * (0.5 * chord).min(1.0).arc_sine()
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

    #[test]
    fn lanes_have_the_bits_of_single_points() {
        let mut draw = SplitMix(7);
        for (degree_u, degree_v) in [(1, 1), (1, 3), (2, 2), (3, 3), (5, 2), (4, 6)] {
            for (rational, pole) in [(false, false), (true, false), (false, true), (true, true)] {
                let mut coordinate = |low: f64, high: f64| draw.range(low, high);
                let mut net: Vec<DVec4> = (0..(degree_u + 1) * (degree_v + 1))
                    .map(|_| {
                        let point = DVec3::from_array([(); 3].map(|()| coordinate(-5.0, 5.0)));
                        let weight = if rational { coordinate(0.3, 3.0) } else { 1.0 };
                        (point * weight).extend(weight)
                    })
                    .collect();
                if pole {
                    // All of it: no sample has a normal.
                    let point = net[0];
                    net.fill(point);
                }
                let (rows_u, rows_v) = (sample_rows(degree_u), sample_rows(degree_v));
                let mut sampler = Sampler::new(degree_u, degree_v, rational);
                let samples = sampler.sample(&net);
                let expected: [[_; COUNT]; COUNT] =
                    std::array::from_fn(|i| std::array::from_fn(|j| single(&net, [&rows_u[i], &rows_v[j]], rational)));
                for (i, row) in expected.iter().enumerate() {
                    for (j, expected) in row.iter().enumerate() {
                        let normal = DVec3::from_array(samples.normals[i].map(|c| c[j]));
                        let bends = samples.bends[i].map(|bend| bend[j]);
                        match expected {
                            Some(expected) => assert_eq!((normal, bends), *expected, "{degree_u} {degree_v} {i} {j}"),
                            None => assert!(normal.is_nan(), "{degree_u} {degree_v} {i} {j}"),
                        }
                    }
                }
                let along = |of: &dyn Fn(usize, usize) -> Option<DVec3>| -> f64 {
                    (0..COUNT).map(|line| turning(&std::array::from_fn(|k| of(line, k)))).fold(0.0, f64::max)
                };
                let normal = |i: usize, j: usize| expected[i][j].map(|(normal, _)| normal);
                let least = [along(&|line, k| normal(k, line)), along(&|line, k| normal(line, k))];
                let turns = samples.turns();
                assert!((0..2).all(|k| turns[k] >= least[k] * TO_ENDS), "{turns:?} {least:?}");
                let most = samples.most();
                let all = || expected.iter().flatten().flatten();
                assert!(all().all(|(_, bends)| (0..6).all(|k| most[k] >= bends[k].abs())), "{most:?}");
            }
        }
    }
}
