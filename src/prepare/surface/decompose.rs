//! NURBS curves and surfaces -> rational Bézier pieces in homogeneous form, by knot insertion (Kumar & Manocha 1995,
//! §2.2).

use crate::math::bernstein::{self, dot};
use crate::model::{CurveDerivatives, NurbsCurve3, NurbsSurface, SurfaceDerivatives, homogeneous, quotient, to_bezier};
use glam::{DVec3, DVec4};
use smallvec::SmallVec;

/// Points of a curve that are evaluated together.
const LANES: usize = 4;

/// A curve as rational Bézier segments.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierSpline3 {
    /// Degree of every segment.
    pub degree: usize,
    /// Parameters where segments begin and end, increasing; one more than segments.
    pub breaks: Vec<f64>,
    /// `(w·x, w·y, w·z, w)`, `degree + 1` per segment. Neighbours share their common point bit for bit.
    pub control: Vec<DVec4>,
}

impl BezierSpline3 {
    /// The part of `curve` over `range`, clipped to the curve's domain. The parameter is the curve's.
    #[must_use]
    pub fn new(curve: &NurbsCurve3, range: (f64, f64)) -> Self {
        let weights = uneven(&curve.weights);
        if let Some(breaks) = bezier_breaks(curve.degree, &curve.knots, range) {
            let segments = (0..breaks.len() - 1).map(|k| k * curve.degree);
            let control = segments.flat_map(|first| first..=first + curve.degree);
            let control = control.map(|k| weighted(&curve.points, weights, k)).collect();
            return Self { degree: curve.degree, breaks, control };
        }
        Self::by_insertion(curve, weights, range)
    }

    /// [`new`](Self::new) of any curve, by knot insertion.
    fn by_insertion(curve: &NurbsCurve3, weights: &[f64], range: (f64, f64)) -> Self {
        let rows = homogeneous(&curve.points, weights);
        let (breaks, mut control) = to_bezier(curve.degree, &curve.knots, &rows, 1, range);
        level(&mut control, !weights.is_empty());
        Self { degree: curve.degree, breaks, control }
    }

    /// Number of segments.
    #[must_use]
    pub fn segments(&self) -> usize {
        self.breaks.len() - 1
    }

    /// The control points of segment `i`.
    #[must_use]
    pub fn segment(&self, i: usize) -> &[DVec4] {
        &self.control[i * (self.degree + 1)..(i + 1) * (self.degree + 1)]
    }

    /// First and last parameter.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        (self.breaks[0], self.breaks[self.breaks.len() - 1])
    }

    /// `C(t)`, with `t` clamped to the range. Does not allocate up to degree 25.
    ///
    /// The same `t` gives the same bits. At a break this is the stored point that both segments share.
    #[must_use]
    pub fn point(&self, t: f64) -> DVec3 {
        let (i, x) = locate(&self.breaks, t);
        let segment = self.segment(i);
        let sum = match self.degree {
            // Constant degrees, so that the compiler unrolls the loops.
            1 => sum::<2>(x, segment),
            2 => sum::<3>(x, segment),
            3 => sum::<4>(x, segment),
            _ => bernstein::with_rows(self.degree, |rows| {
                let n = &mut rows[..=self.degree];
                bernstein::basis(x, n);
                dot(n, segment)
            }),
        };
        sum.truncate() / sum.w
    }

    /// Appends [`point`](Self::point) of each parameter, with the same bits. Fastest if neighbours are in the same
    /// segment.
    #[inline(always)]
    pub(crate) fn points(&self, ts: &[f64], out: &mut Vec<DVec3>) {
        match self.degree {
            1 => self.points_of_degree::<2>(ts, out),
            2 => self.points_of_degree::<3>(ts, out),
            3 => self.points_of_degree::<4>(ts, out),
            _ => out.extend(ts.iter().map(|&t| self.point(t))),
        }
    }

    /// [`points`](Self::points) of a curve of degree `N - 1`, four at a time.
    #[inline(always)]
    fn points_of_degree<const N: usize>(&self, mut ts: &[f64], out: &mut Vec<DVec3>) {
        while let [first, rest @ ..] = ts {
            let piece = Piece::at(&self.breaks, *first);
            // All at once, without a branch for each.
            let is_whole = |next: &&[f64; LANES]| next.iter().fold(true, |all, &t| all & piece.contains(t));
            let Some(&lanes) = ts.first_chunk::<LANES>().filter(is_whole) else {
                // Where segments are short, most parameters are alone in theirs.
                let [x] = piece.locals([*first]);
                let sum = sum::<N>(x, self.segment(piece.index));
                out.push(sum.truncate() / sum.w);
                ts = rest;
                continue;
            };
            ts = &ts[LANES..];
            let basis = bernstein::constant_basis::<N, LANES>(piece.locals(lanes));
            let mut sums = [[0.0; LANES]; 4];
            for (point, factors) in self.segment(piece.index)[..N].iter().zip(&basis) {
                for (sum, c) in sums.iter_mut().zip(point.to_array()) {
                    for l in 0..LANES {
                        sum[l] += c * factors[l];
                    }
                }
            }
            let [mut x, mut y, mut z, w] = sums;
            for l in 0..LANES {
                x[l] /= w[l];
                y[l] /= w[l];
                z[l] /= w[l];
            }
            let points: [DVec3; LANES] = std::array::from_fn(|l| DVec3::new(x[l], y[l], z[l]));
            out.extend_from_slice(&points);
        }
    }

    /// `C`, `C'`, `C''` by the curve's parameter. At a break they are those of the segment that starts there.
    #[must_use]
    pub fn derivatives(&self, t: f64) -> CurveDerivatives<DVec3> {
        let [point, d1, d2] = self.orders::<3>(t);
        CurveDerivatives { point, d1, d2 }
    }

    /// `C` and `C'`, bit-identical to those of [`derivatives`](Self::derivatives).
    pub(crate) fn tangent(&self, t: f64) -> [DVec3; 2] {
        let [point, d1, _] = self.orders::<2>(t);
        [point, d1]
    }

    /// The point and the derivatives of orders below `ROWS`, 2 or 3; the rest are meaningless.
    fn orders<const ROWS: usize>(&self, t: f64) -> [DVec3; 3] {
        let (i, x) = locate(&self.breaks, t);
        let per = 1.0 / (self.breaks[i + 1] - self.breaks[i]);
        let [p, p1, p2] = bernstein::with_rows(self.degree, |rows| {
            bernstein::basis_with_derivatives(self.degree, x, rows);
            let mut orders = [DVec4::ZERO; 3];
            for (order, row) in orders.iter_mut().zip(rows.chunks_exact(self.degree + 1)).take(ROWS) {
                *order = dot(row, self.segment(i));
            }
            orders
        });
        let (p1, p2, point) = (p1 * per, p2 * (per * per), p.truncate() / p.w);
        let d1 = (p1.truncate() - point * p1.w) / p.w;
        [point, d1, (p2.truncate() - d1 * (2.0 * p1.w) - point * p2.w) / p.w]
    }
}

/// A surface as a lattice of rational Bézier patches.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierPatches {
    /// Degree in u of every patch.
    pub degree_u: usize,
    /// Degree in v of every patch.
    pub degree_v: usize,
    /// Parameters in u where patches begin and end, increasing.
    pub breaks_u: Vec<f64>,
    /// Parameters in v where patches begin and end, increasing.
    pub breaks_v: Vec<f64>,
    /// `(w·x, w·y, w·z, w)`, patch by patch (u-major), each patch u-major too: point (a, b) is at
    /// `a * (degree_v + 1) + b`. Neighbours share their border rows bit for bit.
    pub control: Vec<DVec4>,
    /// Whether any weight differs from 1.
    pub rational: bool,
}

impl BezierPatches {
    /// The whole surface.
    #[must_use]
    pub fn new(surface: &NurbsSurface) -> Self {
        let (u, v) = surface.domain();
        Self::over(surface, u, v)
    }

    /// The surface over the box `u` × `v`, clipped to the surface's domain.
    #[must_use]
    pub fn over(surface: &NurbsSurface, u: (f64, f64), v: (f64, f64)) -> Self {
        let (degree_u, degree_v) = (surface.degree_u, surface.degree_v);
        let weights = uneven(&surface.weights);
        let rational = !weights.is_empty();
        let width = surface.count_v();
        let bezier_u = bezier_breaks(degree_u, &surface.knots_u, u);
        if let Some((breaks_u, breaks_v)) = bezier_u.zip(bezier_breaks(degree_v, &surface.knots_v, v)) {
            let patches = (breaks_u.len() - 1) * (breaks_v.len() - 1);
            let mut control = Vec::with_capacity(patches * (degree_u + 1) * (degree_v + 1));
            for (i, j) in (0..breaks_u.len() - 1).flat_map(|i| (0..breaks_v.len() - 1).map(move |j| (i, j))) {
                for a in i * degree_u..=(i + 1) * degree_u {
                    let line = a * width + j * degree_v..=a * width + (j + 1) * degree_v;
                    control.extend(line.map(|k| weighted(&surface.points, weights, k)));
                }
            }
            return Self { degree_u, degree_v, breaks_u, breaks_v, control, rational };
        }
        Self::by_insertion(surface, weights, u, v)
    }

    /// [`over`](Self::over) of any surface, by knot insertion.
    fn by_insertion(surface: &NurbsSurface, weights: &[f64], u: (f64, f64), v: (f64, f64)) -> Self {
        let (degree_u, degree_v, width) = (surface.degree_u, surface.degree_v, surface.count_v());
        let rational = !weights.is_empty();
        let rows = homogeneous(&surface.points, weights);
        let (breaks_u, rows) = to_bezier(degree_u, &surface.knots_u, &rows, width, u);
        // Now along v: columns become rows.
        let tall = rows.len() / width;
        let columns: Vec<DVec4> =
            (0..width).flat_map(|j| (0..tall).map(move |i| i * width + j)).map(|k| rows[k]).collect();
        let (breaks_v, columns) = to_bezier(degree_v, &surface.knots_v, &columns, tall, v);
        let mut control = Vec::with_capacity(columns.len());
        for i in 0..breaks_u.len() - 1 {
            for j in 0..breaks_v.len() - 1 {
                for a in i * (degree_u + 1)..(i + 1) * (degree_u + 1) {
                    control.extend((j * (degree_v + 1)..(j + 1) * (degree_v + 1)).map(|b| columns[b * tall + a]));
                }
            }
        }
        level(&mut control, rational);
        Self { degree_u, degree_v, breaks_u, breaks_v, control, rational }
    }

    /// Number of patches along u and along v.
    #[must_use]
    pub fn counts(&self) -> (usize, usize) {
        (self.breaks_u.len() - 1, self.breaks_v.len() - 1)
    }

    fn net_size(&self) -> usize {
        (self.degree_u + 1) * (self.degree_v + 1)
    }

    /// The control points of each patch, in the order of [`control`](Self::control).
    pub(crate) fn nets(&self) -> impl Iterator<Item = &[DVec4]> {
        self.control.chunks_exact(self.net_size())
    }

    /// The control points of patch (i, j), u-major.
    #[must_use]
    pub fn patch(&self, i: usize, j: usize) -> &[DVec4] {
        let size = self.net_size();
        let start = (i * (self.breaks_v.len() - 1) + j) * size;
        &self.control[start..start + size]
    }

    /// Index of the patch that contains (u, v), in the order of [`control`](Self::control).
    pub(crate) fn piece(&self, u: f64, v: f64) -> usize {
        locate(&self.breaks_u, u).0 * (self.breaks_v.len() - 1) + locate(&self.breaks_v, v).0
    }

    /// The control points of the line at constant u through a piece, which has an index as [`piece`](Self::piece) tells.
    pub(crate) fn line_at(&self, u: f64, piece: usize) -> impl Iterator<Item = DVec3> {
        let (_, x) = locate(&self.breaks_u, u);
        let columns = self.degree_v + 1;
        let mut sums: SmallVec<[DVec4; 8]> = SmallVec::from_elem(DVec4::ZERO, columns);
        bernstein::with_rows(self.degree_u, |rows| {
            let factors = &mut rows[..=self.degree_u];
            bernstein::basis(x, factors);
            let net = &self.control[piece * self.net_size()..][..self.net_size()];
            for (row, &factor) in net.chunks_exact(columns).zip(&*factors) {
                sums.iter_mut().zip(row).for_each(|(sum, c)| *sum += *c * factor);
            }
        });
        sums.into_iter().map(|c| c.truncate() / c.w)
    }

    /// The point, bit-identical to that of [`derivatives`](Self::derivatives) at a fifth of the cost.
    #[must_use]
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        let ((i, x), (j, y)) = (locate(&self.breaks_u, u), locate(&self.breaks_v, v));
        let patch = self.patch(i, j);
        let sum = bernstein::with_rows(self.degree_u, |rows_u| {
            let nu = &mut rows_u[..=self.degree_u];
            bernstein::basis(x, nu);
            match self.degree_v {
                // Constant degrees, so that the compiler unrolls the loops.
                1 => sum_of_lines::<2>(nu, y, patch),
                2 => sum_of_lines::<3>(nu, y, patch),
                3 => sum_of_lines::<4>(nu, y, patch),
                degree => bernstein::with_rows(degree, |rows_v| {
                    let nv = &mut rows_v[..=degree];
                    bernstein::basis(y, nv);
                    let lines = nu.iter().zip(patch.chunks_exact(nv.len()));
                    lines.fold(DVec4::ZERO, |sum, (&n, line)| sum + dot(nv, line) * n)
                }),
            }
        });
        sum.truncate() * (1.0 / sum.w)
    }

    /// The point and its five partial derivatives. At a break they are those of the patch that starts there, outside
    /// the domain those of its border.
    #[must_use]
    pub fn derivatives(&self, u: f64, v: f64) -> SurfaceDerivatives {
        self.orders::<3>(u, v)
    }

    /// The point and its derivatives by u and v, bit-identical to those of [`derivatives`](Self::derivatives).
    pub(crate) fn tangents(&self, u: f64, v: f64) -> [DVec3; 3] {
        let SurfaceDerivatives { point, du, dv, .. } = self.orders::<2>(u, v);
        [point, du, dv]
    }

    /// The point and the derivatives of orders below `ROWS`, 2 or 3; the rest are meaningless.
    #[inline]
    fn orders<const ROWS: usize>(&self, u: f64, v: f64) -> SurfaceDerivatives {
        /// Orders in u and v of the results, by total order.
        const ORDERS: [(usize, usize); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];
        let ((i, x), (j, y)) = (locate(&self.breaks_u, u), locate(&self.breaks_v, v));
        let per_u = 1.0 / (self.breaks_u[i + 1] - self.breaks_u[i]);
        let per_v = 1.0 / (self.breaks_v[j + 1] - self.breaks_v[j]);
        let (nu, nv) = (self.degree_u + 1, self.degree_v + 1);
        let mut sums = [DVec4::ZERO; 6];
        bernstein::with_rows(self.degree_u, |rows_u| {
            bernstein::with_rows(self.degree_v, |rows_v| {
                bernstein::basis_with_derivatives(self.degree_u, x, rows_u);
                bernstein::basis_with_derivatives(self.degree_v, y, rows_v);
                for (a, line) in self.patch(i, j).chunks_exact(nv).enumerate() {
                    let along: [DVec4; ROWS] =
                        std::array::from_fn(|order| dot(&rows_v[order * nv..(order + 1) * nv], line));
                    let n = [rows_u[a], rows_u[nu + a], rows_u[2 * nu + a]];
                    for (sum, (du, dv)) in sums.iter_mut().zip(ORDERS).take(ROWS * (ROWS + 1) / 2) {
                        *sum += along[dv] * n[du];
                    }
                }
            });
        });
        let per = [1.0, per_u, per_v, per_u * per_u, per_u * per_v, per_v * per_v];
        for (sum, per) in sums.iter_mut().zip(per) {
            *sum *= per;
        }
        quotient(sums.map(DVec4::truncate), sums.map(|s| s.w))
    }

    /// The exact curve on the surface at constant u (`axis` 0) or v (`axis` 1) over `range` of the other parameter.
    #[must_use]
    pub fn iso_curve(&self, axis: usize, at: f64, range: (f64, f64)) -> BezierSpline3 {
        let (across, along) =
            if axis == 0 { (&self.breaks_u, &self.breaks_v) } else { (&self.breaks_v, &self.breaks_u) };
        let (degree_across, degree) =
            if axis == 0 { (self.degree_u, self.degree_v) } else { (self.degree_v, self.degree_u) };
        let (fixed, x) = locate(across, at);
        let mut n = vec![0.0; degree_across + 1];
        bernstein::basis(x, &mut n);
        let last = along.len() - 1;
        let (a, b) = (range.0.clamp(along[0], along[last]), range.1.clamp(along[0], along[last]));
        let sliver = 1e-12 * (b - a);
        let mut breaks = vec![a];
        breaks.extend(along.iter().copied().filter(|&t| t > a + sliver && t < b - sliver));
        breaks.push(b);
        let mut control: Vec<DVec4> = Vec::with_capacity((breaks.len() - 1) * (degree + 1));
        for ends in breaks.windows(2) {
            let (k, _) = locate(along, 0.5 * (ends[0] + ends[1]));
            let patch = if axis == 0 { self.patch(fixed, k) } else { self.patch(k, fixed) };
            let nv = self.degree_v + 1;
            let point = |c: usize| {
                let across = |r: usize| if axis == 0 { patch[r * nv + c] } else { patch[c * nv + r] };
                n.iter().enumerate().filter(|(_, f)| **f != 0.0).fold(DVec4::ZERO, |sum, (r, &f)| sum + across(r) * f)
            };
            let mut piece: Vec<DVec4> = (0..=degree).map(point).collect();
            let (from, length) = (along[k], along[k + 1] - along[k]);
            bernstein::restrict(&mut piece, (ends[0] - from) / length, (ends[1] - from) / length);
            if let Some(&before) = control.last() {
                piece[0] = before;
            }
            control.extend(piece);
        }
        BezierSpline3 { degree, breaks, control }
    }
}

/// The piece that contains `t` (at a break the one that starts there) and the local parameter, clamped to 0 to 1.
#[inline]
pub(crate) fn locate(breaks: &[f64], t: f64) -> (usize, f64) {
    let piece = Piece::at(breaks, t);
    let [x] = piece.locals([t]);
    (piece.index, x)
}

/// A piece between two breaks.
#[derive(Clone, Copy)]
pub(crate) struct Piece {
    pub(crate) index: usize,
    ends: [f64; 2],
    /// The parameters that belong to it, without the second. The outer pieces extend beyond the outer breaks.
    within: [f64; 2],
}

impl Piece {
    /// The piece that contains `t`; at a break, the one that starts there.
    #[inline]
    pub(crate) fn at(breaks: &[f64], t: f64) -> Self {
        let last = breaks.len() - 2;
        let index = breaks[1..=last].partition_point(|&b| b <= t);
        let ends = [breaks[index], breaks[index + 1]];
        let from = if index == 0 { f64::NEG_INFINITY } else { ends[0] };
        let to = if index == last { f64::INFINITY } else { ends[1] };
        Self { index, ends, within: [from, to] }
    }

    /// Whether `t` is certainly in this piece.
    #[inline(always)]
    pub(crate) fn contains(&self, t: f64) -> bool {
        self.within[0] <= t && t < self.within[1]
    }

    /// The local parameters, clamped to 0 to 1.
    #[inline(always)]
    pub(crate) fn locals<const L: usize>(&self, ts: [f64; L]) -> [f64; L] {
        let [a, b] = self.ends;
        let mut x = [0.0; L];
        if b > a {
            for l in 0..L {
                x[l] = ((ts[l] - a) / (b - a)).clamp(0.0, 1.0);
            }
        }
        x
    }
}

/// The sum of a segment's `N` control points, times their basis at `x`.
#[inline]
fn sum<const N: usize>(x: f64, segment: &[DVec4]) -> DVec4 {
    let mut n = [0.0; N];
    bernstein::basis(x, &mut n);
    dot(&n, &segment[..N])
}

/// The sum of a patch's lines of `N` control points, each times its basis at `y`, and the lines times `nu`.
#[inline]
fn sum_of_lines<const N: usize>(nu: &[f64], y: f64, patch: &[DVec4]) -> DVec4 {
    let lines = nu.iter().zip(patch.as_chunks::<N>().0);
    let mut nv = [0.0; N];
    bernstein::basis(y, &mut nv);
    lines.fold(DVec4::ZERO, |sum, (&n, line)| sum + dot(&nv, line) * n)
}

/// The breaks of a spline whose control points are those of its Bézier pieces: lines, arcs and analytic surfaces.
/// `None` for other splines, or if `range` leaves out a part of the domain.
fn bezier_breaks(degree: usize, knots: &[f64], range: (f64, f64)) -> Option<Vec<f64>> {
    /// Pieces shorter than this share of the domain may be slivers.
    const SHORT: f64 = 1e-6;
    // The outer knots are in no extraction.
    if degree == 0 || knots.len() < 2 * (degree + 1) {
        return None;
    }
    // The outermost knots count for nothing.
    let groups = knots[1..knots.len() - 1].chunks_exact(degree);
    let (first, last) = (knots[1], knots[knots.len() - 2]);
    let is_whole = groups.remainder().is_empty() && range.0 <= first && range.1 >= last;
    let is_even = |group: &[f64]| group.iter().all(|&knot| knot == group[0]);
    if !is_whole || !groups.clone().all(is_even) {
        return None;
    }
    let breaks: Vec<f64> = groups.map(|group| group[0]).collect();
    let is_long = |ends: &[f64]| ends[1] - ends[0] > SHORT * (last - first);
    breaks.windows(2).all(is_long).then_some(breaks)
}

/// Control point `k` in homogeneous form. Zeros are positive, as sums of products are.
fn weighted(points: &[DVec3], weights: &[f64], k: usize) -> DVec4 {
    DVec4::ZERO + if weights.is_empty() { points[k].extend(1.0) } else { (points[k] * weights[k]).extend(weights[k]) }
}

/// The weights, or an empty slice if all are equal and cancel.
fn uneven(weights: &[f64]) -> &[f64] {
    if weights.windows(2).all(|w| w[0] == w[1]) { &[] } else { weights }
}

/// Resets the weights of a polynomial net to 1, which knot insertion rounds.
fn level(control: &mut [DVec4], rational: bool) {
    if !rational {
        control.iter_mut().for_each(|c| c.w = 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Frame3, Surface};
    use std::f64::consts::TAU;

    /// Degrees with loops of constant length give the bits of the general loop.
    #[test]
    fn points_of_low_degrees_have_the_bits_of_the_general_sum() {
        for degree in 1..=5 {
            let place = |k: usize| DVec4::new(k as f64, (1.3 * k as f64).sin(), 0.1 * (k * k) as f64, 1.0);
            let control: Vec<_> = (0..2 * (degree + 1)).map(|k| place(k) * (1.0 + 0.2 * (k % 3) as f64)).collect();
            let spline = BezierSpline3 { degree, breaks: vec![0.0, 0.7, 2.0], control };
            for t in [-0.1, 0.0, 0.3, 0.7, 1.1, 1.9, 2.0] {
                let (i, x) = locate(&spline.breaks, t);
                let mut n = vec![0.0; degree + 1];
                bernstein::basis(x, &mut n);
                let sum = dot(&n, spline.segment(i));
                assert_eq!(spline.point(t), sum.truncate() / sum.w, "degree {degree} at {t}");
            }
        }
    }

    #[test]
    fn lines_of_pieces_run_from_border_to_border() {
        let torus = Surface::Torus { frame: Frame3::WORLD, major: 5.0, minor: 2.0 };
        let (nurbs, _) = torus.to_nurbs((0.0, TAU), (0.0, TAU));
        let patches = BezierPatches::new(&nurbs);
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let u = patches.breaks_u[i] + 0.3;
            let ends = [j, j + 1].map(|k| patches.breaks_v[k]);
            let piece = patches.piece(u, 0.5 * (ends[0] + ends[1]));
            let line: Vec<DVec3> = patches.line_at(u, piece).collect();
            let off = [(line[0], ends[0]), (line[2], ends[1])].map(|(p, v)| p.distance(patches.point(u, v)));
            assert!(line.len() == 3 && off.iter().all(|off| *off < 1e-14 * 7.0), "{i} {j}: {off:?}");
            // Between them it bends like the tube.
            assert!(line[1].distance(line[0].midpoint(line[2])) > 1.0, "{i} {j}");
        }
    }

    fn bits(control: &[DVec4]) -> Vec<[u64; 4]> {
        control.iter().map(|c| c.to_array().map(f64::to_bits)).collect()
    }

    #[test]
    fn curves_of_bezier_pieces_have_the_bits_of_knot_insertion() {
        let line = NurbsCurve3::line(DVec3::new(-0.0, 1.0, -2.5), DVec3::new(3.0, -0.0, 0.1));
        let arc = |from, to| NurbsCurve3::arc(&Frame3::WORLD, 2.5, 1.5, from, to);
        let even = NurbsCurve3 { weights: vec![0.7; 2], ..line.clone() };
        let chain = NurbsCurve3 {
            degree: 3,
            knots: vec![-1.0, 0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 5.0, 5.0, 5.0, 7.0],
            points: (0..7).map(|k| DVec3::new(f64::from(k), f64::from(k * k) - 3.3, -0.0)).collect(),
            weights: Vec::new(),
        };
        for curve in [line, arc(0.3, 1.0), arc(-1.0, 3.0), arc(0.0, TAU), even, chain] {
            let (a, b) = curve.domain();
            for range in [(a, b), (a - 1.0, b + 1.0)] {
                let fast = BezierSpline3::new(&curve, range);
                assert!(bezier_breaks(curve.degree, &curve.knots, range).is_some(), "{curve:?}");
                let slow = BezierSpline3::by_insertion(&curve, uneven(&curve.weights), range);
                assert_eq!((fast.breaks, bits(&fast.control)), (slow.breaks, bits(&slow.control)), "{curve:?}");
            }
            for part in [(a, b - 0.1), (a + 0.1, b)] {
                assert!(bezier_breaks(curve.degree, &curve.knots, part).is_none());
            }
        }
    }

    #[test]
    fn other_splines_are_no_bezier_pieces() {
        for (degree, knots) in [
            (1, &[0.0, 1.0][..]),
            (2, &[0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0]),
            (2, &[0.0, 0.0, 0.1, 1.0, 1.0, 1.0]),
            // A sliver.
            (1, &[0.0, 0.0, 1e-8, 1.0, 1.0]),
            (0, &[0.0, 1.0]),
        ] {
            assert_eq!(bezier_breaks(degree, knots, (-9.0, 9.0)), None, "{degree} {knots:?}");
        }
    }

    #[test]
    fn surfaces_of_bezier_pieces_have_the_bits_of_knot_insertion() {
        let frame =
            Frame3::from_axis(DVec3::new(1.0, -2.0, 0.0), DVec3::new(0.1, 0.2, 1.0), DVec3::X).expect("an axis");
        for surface in [
            Surface::Plane { frame },
            Surface::Cylinder { frame, radius: 2.0 },
            Surface::Torus { frame, major: 3.0, minor: 1.0 },
        ] {
            let (nurbs, _) = surface.to_nurbs((-1.0, 3.0), (0.0, 4.0));
            let (u, v) = nurbs.domain();
            let fast = BezierPatches::over(&nurbs, u, v);
            let slow = BezierPatches::by_insertion(&nurbs, uneven(&nurbs.weights), u, v);
            assert_eq!(bits(&fast.control), bits(&slow.control), "{surface:?}");
            assert_eq!(fast, slow);
        }
    }
}
