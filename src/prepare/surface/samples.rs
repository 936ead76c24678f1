//! Nets of sub-boxes and segments -> how derivatives lie to the normal, and how far directions turn, at evenly spaced
//! samples.
//!
//! A row of samples along v is evaluated at once, in lanes. Every lane does the arithmetic of a single point, in the
//! same order.

use crate::math::bernstein;
use crate::math::lanes::widest;
use glam::{DVec3, DVec4};

/// Intervals between samples, per sub-box and direction; even.
const SAMPLES: usize = 4;
const COUNT: usize = SAMPLES + 1;

/// The samples of a row.
type Lanes<const L: usize = COUNT> = [f64; L];
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
    /// By control point: its basis function and two derivatives at the samples of a line.
    rows_u: Vec<[Lanes; 3]>,
    rows_v: Vec<[Lanes; 3]>,
    /// The columns of the net at all samples of u, with their derivatives.
    columns: Vec<[[Lanes; 4]; 3]>,
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
        let rows = |degree: usize| {
            let rows = sample_rows(degree);
            let at = |b: usize| [0, 1, 2].map(|order| lanes(|k| rows[k][order * (degree + 1) + b]));
            (0..=degree).map(at).collect()
        };
        Self {
            rational,
            rows_u: rows(degree_u),
            rows_v: rows(degree_v),
            columns: vec![[[[0.0; COUNT]; 4]; 3]; degree_v + 1],
            samples: SurfaceSamples { normals: [[[0.0; COUNT]; 3]; COUNT], bends: [[[0.0; COUNT]; 6]; COUNT] },
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
        let (nu, nv) = (rows_u.len(), rows_v.len());
        // First each column of the net with all orders in u, then the columns with the orders in v.
        for (b, column) in columns.iter_mut().enumerate() {
            // Higher orders are 0.
            for (order, column) in column.iter_mut().enumerate().take(nu) {
                let mut sums = [[0.0; COUNT]; N];
                for (points, row) in net.chunks_exact(nv).zip(&*rows_u) {
                    for (sum, x) in sums.iter_mut().zip(points[b].to_array()) {
                        *sum = lanes(|l| sum[l] + x * row[order][l]);
                    }
                }
                column[..N].copy_from_slice(&sums);
            }
        }
        for (i, (normals, bends)) in normals.iter_mut().zip(bends).enumerate() {
            (*normals, *bends) = combine::<N>((columns, rows_v), (nu, nv), i);
        }
    }
}

impl SurfaceSamples {
    /// The largest magnitude of each of its bends, with a margin for maxima between samples: for each of `S_uu`,
    /// `S_uv`, `S_vv`, the part along the normal and the rest.
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
                    let (mut most, mut by_u, mut by_v) = ([0.0; COUNT], [0.0; COUNT], [0.0; COUNT - 2]);
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
        let [by_u, by_v] = widest(
            #[inline(always)]
            || {
                let row = |j: usize| vectors(|c| lanes(|l| self.normals[l][c][j]));
                [turnings(&self.normals), turnings(&[row(0), row(1), row(2), row(3), row(4)])]
            },
        );
        [by_u, by_v].map(|turning| {
            let most = turning.iter().copied().fold(0.0_f64, f64::max);
            let bend = turning.windows(3).map(|t| (t[0] - 2.0 * t[1] + t[2]).abs()).fold(0.0_f64, f64::max);
            (most + 0.125 * bend) * TO_ENDS
        })
    }

    /// Whether the normal changes its side between neighbours. Halves of such a box turn as far.
    pub(super) fn fold_over(&self) -> bool {
        /// The angle between neighbours is above 120 degrees. Smooth surfaces that turn so far between samples turn by
        /// more than 360 degrees in the box.
        const OTHER_SIDE: f64 = -0.5;
        let dot = |(i, j): (usize, usize), (k, l): (usize, usize)| -> f64 {
            (0..3).map(|c| self.normals[i][c][j] * self.normals[k][c][l]).sum()
        };
        let mut pairs = (0..COUNT).flat_map(|i| (1..COUNT).map(move |k| (i, k)));
        pairs.any(|(i, k)| dot((i, k - 1), (i, k)) < OTHER_SIDE || dot((k - 1, i), (k, i)) < OTHER_SIDE)
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

#[inline(always)]
fn lanes<const L: usize>(of: impl Fn(usize) -> f64) -> Lanes<L> {
    let mut out = [0.0; L];
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
fn raise<const L: usize>(most: &mut Lanes<L>, x: impl Fn(usize) -> f64) {
    *most = lanes(|l| {
        let x = x(l).abs();
        if x > most[l] { x } else { most[l] }
    });
}

/// The largest of numbers.
#[inline(always)]
fn largest(of: &[f64]) -> f64 {
    let mut most = 0.0;
    for &x in of {
        most = if x > most { x } else { most };
    }
    most
}

#[inline(always)]
fn times(a: &Vectors, factor: &Lanes) -> Vectors {
    // Three closures in one are not inlined, and leave the wide registers.
    let [x, y, z] = a;
    [lanes(|l| x[l] * factor[l]), lanes(|l| y[l] * factor[l]), lanes(|l| z[l] * factor[l])]
}

#[inline(always)]
fn minus(a: &Vectors, b: &Vectors) -> Vectors {
    [lanes(|l| a[0][l] - b[0][l]), lanes(|l| a[1][l] - b[1][l]), lanes(|l| a[2][l] - b[2][l])]
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

/// Of each column of a net, its sums at all samples of u, and its basis in v.
type Terms<'a> = (&'a [[[Lanes; 4]; 3]], &'a [[Lanes; 3]]);

/// The normals, and the parts of the second derivatives along and across them, at row `i` of samples. `orders`: numbers
/// of derivatives in u and v that are not 0, with the point.
#[inline(always)]
fn combine<const N: usize>(terms: Terms<'_>, orders: (usize, usize), i: usize) -> (Vectors, [Lanes; 6]) {
    let none = [[0.0; COUNT]; N];
    let sums = [
        sum::<N>(terms, i, (0, 0)),
        sum(terms, i, (1, 0)),
        sum(terms, i, (0, 1)),
        if orders.0 > 2 { sum(terms, i, (2, 0)) } else { none },
        sum(terms, i, (1, 1)),
        if orders.1 > 2 { sum(terms, i, (0, 2)) } else { none },
    ];
    let [_, du, dv, duu, duv, dvv] = if N == 4 { quotient(&sums) } else { plain(&sums) };
    split([&du, &dv], [&duu, &duv, &dvv])
}

/// The derivative of the orders `of` of the weighted point and, if `N` is 4, of its weight, for [`combine`].
#[inline(always)]
fn sum<const N: usize>((columns, rows): Terms<'_>, i: usize, of: (usize, usize)) -> [Lanes; N] {
    let mut sum = [[0.0; COUNT]; N];
    for (column, row) in columns.iter().zip(rows) {
        for (sum, column) in sum.iter_mut().zip(&column[of.0]) {
            *sum = lanes(|l| sum[l] + column[i] * row[of.1][l]);
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
    sums.map(|sums| [sums[0], sums[1], sums[2]])
}

/// The normals, and the parts of the second derivatives along and across them.
#[inline(always)]
fn split([du, dv]: [&Vectors; 2], [duu, duv, dvv]: [&Vectors; 3]) -> (Vectors, [Lanes; 6]) {
    let normal = cross(du, dv);
    let (all, of_u, of_v) = (length(&normal), length(du), length(dv));
    // One comparison at a time, which registers have instructions for.
    let mut per = lanes(|l| 1.0 / all[l]);
    per = lanes(|l| if all[l] > 1e-10 * of_u[l] * of_v[l] { per[l] } else { f64::NAN });
    per = lanes(|l| if per[l] < f64::INFINITY { per[l] } else { f64::NAN });
    per = lanes(|l| if per[l] > 0.0 { per[l] } else { f64::NAN });
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
#[inline(always)]
fn turnings(rows: &[Vectors; COUNT]) -> Lanes {
    let fine = angles(rows, [(0, 1), (1, 2), (2, 3), (3, 4)]);
    let coarse = angles(rows, [(0, 2), (2, 4)]);
    let mut all = lanes(|l| fine[l] + (fine[l] - coarse[l]).max(0.0));
    for (l, turn) in all.iter_mut().enumerate() {
        if fine[l].is_nan() {
            *turn = turning(&rows.map(|row| Some(DVec3::from_array(row.map(|c| c[l]))).filter(|n| !n.is_nan())));
        }
    }
    all
}

/// The sums of [`chord_angle`] over pairs of rows, by lane.
#[inline(always)]
fn angles<const K: usize>(rows: &[Vectors; COUNT], pairs: [(usize, usize); K]) -> Lanes {
    let mut sum = [0.0; COUNT];
    for (a, b) in pairs {
        let chord = length(&minus(&rows[b], &rows[a]));
        let mut angle: Lanes = lanes(|l| short_angle(chord[l]));
        if largest(&chord) >= SHORT {
            // NaN stays: it marks lines that lack a direction.
            for (angle, &chord) in angle.iter_mut().zip(&chord).filter(|(_, chord)| **chord >= SHORT) {
                *angle = chord_angle(chord);
            }
        }
        sum = lanes(|l| sum[l] + angle[l]);
    }
    sum
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

/// Chords below this have their angle by a series.
const SHORT: f64 = 0.1;

/// The angle subtended by a chord of the unit circle.
fn chord_angle(chord: f64) -> f64 {
    if chord < SHORT { short_angle(chord) } else { 2.0 * libm::asin((0.5 * chord).min(1.0)) }
}

/// [`chord_angle`] by a series that is good to 10⁻⁹ below [`SHORT`].
#[inline(always)]
fn short_angle(chord: f64) -> f64 {
    let square = chord * chord;
    chord * (1.0 + square * (1.0 / 24.0 + square * (3.0 / 640.0)))
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

    #[test]
    fn turnings_in_lanes_are_those_of_single_lines() {
        let mut draw = SplitMix(8);
        // Chords below and above `SHORT`, both, and lines without a direction somewhere.
        for (spread, hole) in [(0.01, None), (0.08, None), (1.0, None), (0.03, Some((2, 1))), (1.0, Some((4, 4)))] {
            let rows: [Vectors; COUNT] = std::array::from_fn(|k| {
                let of: [DVec3; COUNT] = std::array::from_fn(|l| {
                    let [x, y] = [(); 2].map(|()| draw.range(-spread, spread));
                    if hole == Some((k, l)) { DVec3::NAN } else { DVec3::new(x, y, 1.0).normalize() }
                });
                vectors(|c| lanes(|l| of[l][c]))
            });
            let turns = turnings(&rows);
            for (l, turn) in turns.iter().enumerate() {
                let normal = |k: usize| DVec3::from_array(rows[k].map(|c| c[l]));
                let single = turning(&std::array::from_fn(|k| Some(normal(k)).filter(|normal| !normal.is_nan())));
                assert!(*turn == single, "{spread} {hole:?} {l}: {turn} {single}");
            }
        }
    }
}
