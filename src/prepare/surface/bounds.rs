//! Bézier patches and segments -> tables of derivative bounds and turning angles over sub-boxes, from which plans
//! derive lattice lines and tessellants.
//!
//! Lengths of derivatives are rigorous, by [`math::bounds`](crate::math::bounds) on each sub-box's own net. Their parts
//! along and across the normal, and the turning of the normal, are sampled, with margins from the differences between
//! samples.

use super::arc_bounds;
use super::decompose::{BezierPatches, BezierSpline3};
use super::tables::{Bend, BoundingBox, BoxBounds, CurveBounds, StripBounds, SurfaceBounds};
use crate::math::Elementary as _;
use crate::math::bernstein;
use crate::math::bounds::{patch_bounds, segment_bounds};
use crate::math::lanes::widest;
use crate::model::{SurfaceDerivatives, quotient};
use glam::{DVec3, DVec4};
use std::cell::OnceCell;

/// A derivative below this share of the size (largest distance from the origin) is rounding and counts as zero.
const ROUNDING: f64 = 1e-12;
/// Intervals between samples, per sub-box and direction; even.
const SAMPLES: usize = 4;

impl SurfaceBounds {
    /// Bounds all patches.
    ///
    /// Sub-boxes per patch and direction: 1 where the degree is 1, else 4; 2 or 1 on surfaces with many patches or
    /// large rational nets. Cost: a few µs per sub-box up to degree (3, 3).
    #[must_use]
    pub fn new(patches: &BezierPatches) -> Self {
        let (count_u, count_v) = patches.counts();
        let cost = if patches.rational { (patches.degree_u + 1) * (patches.degree_v + 1) } else { 1 };
        let parts_u = parts(patches.degree_u, count_u, cost);
        let parts_v = parts(patches.degree_v, count_v, cost);
        let breaks_u = subdivided(&patches.breaks_u, parts_u);
        let breaks_v = subdivided(&patches.breaks_v, parts_v);
        let size = patches.control.iter().fold(0.0_f64, |most, c| most.max(c.truncate().length() / c.w));
        let sampler = Sampler::new(patches);
        let columns = breaks_v.len() - 1;
        let mut cells = Vec::with_capacity((breaks_u.len() - 1) * columns);
        let mut places = Vec::with_capacity(cells.capacity());
        for i in 0..breaks_u.len() - 1 {
            for j in 0..columns {
                let net = sub_net(patches, (i / parts_u, j / parts_v), (i % parts_u, parts_u), (j % parts_v, parts_v));
                places.push(BoundingBox::of_net(&net));
                let local = patch_bounds(patches.degree_u + 1, &net, patches.rational);
                let (u, v) = (breaks_u[i + 1] - breaks_u[i], breaks_v[j + 1] - breaks_v[j]);
                let keep = |x: f64| if x <= ROUNDING * size { 0.0 } else { x };
                let norms = [local.duu, local.duv, local.dvv].map(keep);
                if norms == [0.0; 3] {
                    cells.push(BoxBounds { u: local.du / u, v: local.dv / v, ..BoxBounds::default() });
                    continue;
                }
                let samples = widest(
                    #[inline(always)]
                    || sampler.samples(&net),
                );
                let most = samples.most();
                let part = |k: usize, part: usize| norms[k].min(keep(most[2 * k + part]));
                let bend = |k: usize| Bend { norm: norms[k], lift: part(k, 0), slide: part(k, 1) };
                cells.push(BoxBounds {
                    uu: bend(0).scaled(1.0 / (u * u)),
                    uv: bend(1).scaled(1.0 / (u * v)),
                    vv: bend(2).scaled(1.0 / (v * v)),
                    u: local.du / u,
                    v: local.dv / v,
                    turn_u: most_turning(|line, k| samples.0[k][line].map(|s| s.normal)),
                    turn_v: most_turning(|line, k| samples.0[line][k].map(|s| s.normal)),
                });
            }
        }
        Self { breaks_u, breaks_v, cells, places }
    }

    /// The bounds of sub-box (i, j).
    #[must_use]
    pub fn cell(&self, i: usize, j: usize) -> BoxBounds {
        self.cells[i * (self.breaks_v.len() - 1) + j]
    }
}

impl CurveBounds {
    /// The bounds of a curve over `range` that is a single point. Its bounding box is empty.
    #[must_use]
    pub fn none(range: (f64, f64)) -> Self {
        let places = vec![BoundingBox::EMPTY];
        Self { breaks: vec![range.0, range.1], strips: vec![StripBounds::default()], places }
    }

    /// Whether every strip is straight and of constant speed. The curve may still have kinks between segments.
    #[must_use]
    pub fn is_straight(&self) -> bool {
        self.strips.iter().all(|s| s.second == 0.0)
    }

    /// Bounds all segments: lines in one strip and circular arcs in two, in closed form; others in up to four strips.
    #[must_use]
    pub fn new(spline: &BezierSpline3) -> Self {
        let parts = parts(spline.degree, spline.segments(), 1);
        let size = spline.control.iter().fold(0.0_f64, |most, c| most.max(c.truncate().length() / c.w));
        let mut out = Self { breaks: vec![spline.breaks[0]], strips: Vec::new(), places: Vec::new() };
        let mut net = Vec::with_capacity(spline.degree + 1);
        let rows = OnceCell::new();
        for (k, ends) in spline.breaks.windows(2).enumerate() {
            let first = out.places.len();
            let strips = arc_bounds::segment(spline.segment(k), ends[1] - ends[0]).unwrap_or_else(|| {
                let width = (ends[1] - ends[0]) / parts as f64;
                let strip = |i| {
                    net.clear();
                    net.extend_from_slice(spline.segment(k));
                    let (x0, x1) = share(i, parts);
                    bernstein::restrict(&mut net, x0, x1);
                    out.places.push(BoundingBox::of_net(&net));
                    let (first, second) = segment_bounds(&net);
                    let straight = second <= ROUNDING * size;
                    StripBounds {
                        first: first / width,
                        second: if straight { 0.0 } else { second / (width * width) },
                        turn: if straight {
                            0.0
                        } else {
                            tangent_turning(&net, rows.get_or_init(|| sample_rows(spline.degree)))
                        },
                    }
                };
                (0..parts).map(strip).collect()
            });
            let n = strips.len();
            if out.places.len() == first {
                out.places.resize(first + n, BoundingBox::of_net(spline.segment(k)));
            }
            out.breaks.extend((1..n).map(|i| ends[0] + (ends[1] - ends[0]) * i as f64 / n as f64));
            out.breaks.push(ends[1]);
            out.strips.extend(strips);
        }
        out
    }
}

impl CurveBounds {
    /// Merges neighbouring strips that need nearly the same density. Every plan visits every strip, and some curves are
    /// cut much finer than they bend.
    #[must_use]
    pub(crate) fn merged(&self) -> Self {
        /// Largest ratio of bounds within a merged strip. Densities go with the square root of bounds.
        const ALIKE: f64 = 1.2;
        /// Differences below this share of the curve's largest bound are ignored.
        const NOTHING: f64 = 0.01;
        /// At most this many strips become one, or 1/`PART` of the curve's strips if that is more.
        const FEW: usize = 16;
        const PART: usize = 4;
        // First and second derivative and turning, by the parameter.
        let rates = |k: usize| {
            let StripBounds { first, second, turn } = self.strips[k];
            [first, second, turn / (self.breaks[k + 1] - self.breaks[k])]
        };
        let count = self.strips.len();
        let most = (0..count).map(rates).fold([0.0; 3], |m, r| [0, 1, 2].map(|i| f64::max(m[i], r[i])));
        let limit = FEW.max(count / PART);
        let mut out = Self { breaks: vec![self.breaks[0]], strips: Vec::new(), places: Vec::new() };
        let mut from = 0;
        while from < count {
            let (mut low, mut high, mut place) = (rates(from), rates(from), self.places[from]);
            let mut to = from + 1;
            while to < count && to - from < limit {
                let next = rates(to);
                let (l, h) = ([0, 1, 2].map(|i| low[i].min(next[i])), [0, 1, 2].map(|i| high[i].max(next[i])));
                if (0..3).any(|i| h[i] > ALIKE * l[i] + NOTHING * most[i]) {
                    break;
                }
                (low, high, place) = (l, h, place.with(&self.places[to]));
                to += 1;
            }
            let [first, second, turn] = high;
            out.strips.push(StripBounds { first, second, turn: turn * (self.breaks[to] - self.breaks[from]) });
            out.places.push(place);
            out.breaks.push(self.breaks[to]);
            from = to;
        }
        out
    }
}

/// Sub-boxes per piece and direction. More if there are few pieces, because one may then fill the screen. Fewer for
/// rational nets of many control points: `cost` is their number, and the work per sub-box goes with its square.
fn parts(degree: usize, pieces: usize, cost: usize) -> usize {
    match (degree, pieces, cost) {
        (1, ..) => 1,
        (_, 0..=16, 0..=6) => 4,
        (_, 0..=64, 0..=20) => 2,
        _ => 1,
    }
}

/// Part `i` of `n` of [0, 1].
fn share(i: usize, n: usize) -> (f64, f64) {
    (i as f64 / n as f64, (i + 1) as f64 / n as f64)
}

/// Cuts every interval into `parts` equal ones.
fn subdivided(breaks: &[f64], parts: usize) -> Vec<f64> {
    let inner = |ends: &[f64]| {
        let (a, b) = (ends[0], ends[1]);
        (0..parts).map(move |k| if k == 0 { a } else { a + (b - a) * k as f64 / parts as f64 })
    };
    let mut all: Vec<f64> = breaks.windows(2).flat_map(inner).collect();
    all.extend(breaks.last());
    all
}

/// The net of part (`part_u`, `part_v`), each given as (index, count), of a patch.
fn sub_net(
    patches: &BezierPatches,
    (i, j): (usize, usize),
    part_u: (usize, usize),
    part_v: (usize, usize),
) -> Vec<DVec4> {
    let mut net = patches.patch(i, j).to_vec();
    let nv = patches.degree_v + 1;
    if part_v.1 > 1 {
        let (y0, y1) = share(part_v.0, part_v.1);
        for row in net.chunks_exact_mut(nv) {
            bernstein::restrict(row, y0, y1);
        }
    }
    if part_u.1 > 1 {
        let (x0, x1) = share(part_u.0, part_u.1);
        let mut column = Vec::with_capacity(patches.degree_u + 1);
        for b in 0..nv {
            column.clear();
            column.extend(net[b..].iter().step_by(nv));
            bernstein::restrict(&mut column, x0, x1);
            for (to, &from) in net[b..].iter_mut().step_by(nv).zip(&column) {
                *to = from;
            }
        }
    }
    net
}

/// Basis rows at the sample lines, shared by all sub-boxes.
struct Sampler {
    degree_v: usize,
    rational: bool,
    rows_u: Vec<Vec<f64>>,
    rows_v: Vec<Vec<f64>>,
}

/// The local parameter of sample `k`: evenly spaced, but the first and last slightly inside, where poles and collapsed
/// borders have a normal.
fn sample(k: usize) -> f64 {
    match k {
        0 => 1e-4,
        SAMPLES => 1.0 - 1e-4,
        _ => k as f64 / SAMPLES as f64,
    }
}

/// Rows of the basis and its first and second derivatives at each sample.
fn sample_rows(degree: usize) -> Vec<Vec<f64>> {
    let row = |k| {
        bernstein::with_rows(degree, |rows| {
            bernstein::basis_with_derivatives(degree, sample(k), rows);
            rows.to_vec()
        })
    };
    (0..=SAMPLES).map(row).collect()
}

/// Normal and second derivatives at a point, by the local parameters of a sub-box.
#[derive(Clone, Copy)]
struct Sample {
    normal: DVec3,
    /// For each of `S_uu`, `S_uv`, `S_vv`: signed part along the normal, and length of the rest.
    bends: [f64; 6],
}

/// A sub-box's samples, (i, j) in u and v; `None` where the surface has no normal.
struct SurfaceSamples([[Option<Sample>; SAMPLES + 1]; SAMPLES + 1]);

/// The larger of both, as [`f64::max`] where `most` is not NaN.
fn raise(most: &mut f64, x: f64) {
    *most = if x > *most { x } else { *most };
}

impl SurfaceSamples {
    /// The largest magnitude of each of [`Sample::bends`], with a margin for maxima between samples.
    ///
    /// A parabola exceeds its samples by at most an eighth of the second difference; the margin is twice that, along u
    /// and v.
    fn most(&self) -> [f64; 6] {
        let at = |i: usize, j: usize| self.0[i][j].as_ref().map(|s| &s.bends);
        let mut most = [0.0_f64; 6];
        let mut bend = [[0.0_f64; 6]; 2];
        for i in 0..=SAMPLES {
            for j in 0..=SAMPLES {
                let Some(here) = at(i, j) else { continue };
                for (most, here) in most.iter_mut().zip(here) {
                    raise(most, here.abs());
                }
                let across = [
                    (i > 0 && i < SAMPLES).then(|| [at(i - 1, j), at(i + 1, j)]),
                    (j > 0 && j < SAMPLES).then(|| [at(i, j - 1), at(i, j + 1)]),
                ];
                for (bend, sides) in bend.iter_mut().zip(across) {
                    if let Some([Some(a), Some(b)]) = sides {
                        for (k, bend) in bend.iter_mut().enumerate() {
                            raise(bend, (a[k] - 2.0 * here[k] + b[k]).abs());
                        }
                    }
                }
            }
        }
        std::array::from_fn(|k| most[k] + 0.25 * (bend[0][k] + bend[1][k]))
    }
}

impl Sampler {
    fn new(patches: &BezierPatches) -> Self {
        let degree_v = patches.degree_v;
        let rational = patches.rational;
        Self { degree_v, rational, rows_u: sample_rows(patches.degree_u), rows_v: sample_rows(degree_v) }
    }

    /// Evaluates a net at all samples.
    #[inline(always)]
    fn samples(&self, net: &[DVec4]) -> SurfaceSamples {
        let nv = self.degree_v + 1;
        let mut out = [[None; SAMPLES + 1]; SAMPLES + 1];
        // First each column of the net with all orders in u, then the columns with the orders in v.
        let mut curve = vec![[DVec4::ZERO; 3]; nv];
        for (row_u, out) in self.rows_u.iter().zip(&mut out) {
            let nu = row_u.len() / 3;
            for (b, column) in curve.iter_mut().enumerate() {
                let mut sums = [DVec4::ZERO; 3];
                for (a, &point) in net[b..].iter().step_by(nv).enumerate() {
                    for (order, sum) in sums.iter_mut().enumerate() {
                        *sum += point * row_u[order * nu + a];
                    }
                }
                *column = sums;
            }
            for (row_v, out) in self.rows_v.iter().zip(out) {
                let d = if self.rational { rational(&curve, row_v) } else { polynomial(&curve, row_v) };
                let normal = d.du.cross(d.dv);
                if normal.length() > 1e-10 * d.du.length() * d.dv.length() {
                    *out = normal.try_normalize().map(|normal| {
                        let parts = |x: DVec3| [x.dot(normal), (x - normal * x.dot(normal)).length()];
                        let [[a, b], [c, d], [e, f]] = [d.duu, d.duv, d.dvv].map(parts);
                        Sample { normal, bends: [a, b, c, d, e, f] }
                    });
                }
            }
        }
        SurfaceSamples(out)
    }
}

/// A surface's derivatives at a sample of v, from the columns of its net with their derivatives in u.
#[inline(always)]
fn rational(columns: &[[DVec4; 3]], row: &[f64]) -> SurfaceDerivatives {
    let mut sums = [DVec4::ZERO; 6];
    let [n, d1, d2] = orders(row);
    for ((([c, cu, cuu], n), d1), d2) in columns.iter().zip(n).zip(d1).zip(d2) {
        sums[0] += *c * *n;
        sums[1] += *cu * *n;
        sums[2] += *c * *d1;
        sums[3] += *cuu * *n;
        sums[4] += *cu * *d1;
        sums[5] += *c * *d2;
    }
    quotient(sums.map(DVec4::truncate), sums.map(|s| s.w))
}

/// The same where all weights are 1.
#[inline(always)]
fn polynomial(columns: &[[DVec4; 3]], row: &[f64]) -> SurfaceDerivatives {
    let mut sums = [DVec3::ZERO; 6];
    let [n, d1, d2] = orders(row);
    for (((column, n), d1), d2) in columns.iter().zip(n).zip(d1).zip(d2) {
        let [c, cu, cuu] = column.map(DVec4::truncate);
        sums[0] += c * *n;
        sums[1] += cu * *n;
        sums[2] += c * *d1;
        sums[3] += cuu * *n;
        sums[4] += cu * *d1;
        sums[5] += c * *d2;
    }
    let [point, du, dv, duu, duv, dvv] = sums;
    SurfaceDerivatives { point, du, dv, duu, duv, dvv }
}

/// The three parts of a row of bases: values, first and second derivatives.
fn orders(row: &[f64]) -> [&[f64]; 3] {
    let (n, rest) = row.split_at(row.len() / 3);
    let (d1, d2) = rest.split_at(n.len());
    [n, d1, d2]
}

/// The largest turning along a sample line, with margins for what samples miss.
///
/// Along a line the margin is the growth of the sum of angles when the samples were doubled; across lines, the
/// overshoot of a parabola through neighbours. Exact where directions turn in one plane and one way.
fn most_turning(direction: impl Fn(usize, usize) -> Option<DVec3>) -> f64 {
    let turning: [f64; SAMPLES + 1] = std::array::from_fn(|line| {
        let samples: [Option<DVec3>; SAMPLES + 1] = std::array::from_fn(|k| direction(line, k));
        let halved: [Option<DVec3>; SAMPLES / 2 + 1] = std::array::from_fn(|k| samples[2 * k]);
        let (fine, coarse) = (path(&samples), path(&halved));
        fine + (fine - coarse).max(0.0)
    });
    let most = turning.iter().copied().fold(0.0_f64, f64::max);
    let bend = turning.windows(3).map(|t| (t[0] - 2.0 * t[1] + t[2]).abs()).fold(0.0_f64, f64::max);
    // Samples stop 10⁻⁴ short of both ends.
    (most + 0.125 * bend) * (1.0 + 4e-4)
}

/// The sum of the angles between successive directions.
fn path(directions: &[Option<DVec3>]) -> f64 {
    let mut before = None;
    let mut sum = 0.0;
    for &direction in directions {
        let Some(here) = direction else { continue };
        if let Some(before) = before {
            sum += chord_angle(here.distance(before));
        }
        before = direction;
    }
    sum
}

/// The angle subtended by a chord of the unit circle; below 0.1 by a series that is good to 10⁻⁹.
fn chord_angle(chord: f64) -> f64 {
    if chord < 0.1 {
        let square = chord * chord;
        return chord * (1.0 + square * (1.0 / 24.0 + square * (3.0 / 640.0)));
    }
    2.0 * (0.5 * chord).min(1.0).arc_sine()
}

/// How far the tangent of a segment turns, given the basis rows at the samples.
fn tangent_turning(net: &[DVec4], rows: &[Vec<f64>]) -> f64 {
    let degree = net.len() - 1;
    let mut tangents = [None; SAMPLES + 1];
    for (tangent, row) in tangents.iter_mut().zip(rows) {
        let (n, d) = row[..2 * (degree + 1)].split_at(degree + 1);
        let dot = |f: &[f64]| f.iter().zip(net).fold(DVec4::ZERO, |sum, (&f, &c)| sum + c * f);
        let (p, p1) = (dot(n), dot(d));
        *tangent = (p1.truncate() * p.w - p.truncate() * p1.w).try_normalize();
    }
    most_turning(|_, k| tangents[k])
}
