//! Free trimming curves -> chains of rational Bézier arcs of the unit square, each monotone in both coordinates.
//!
//! A monotone arc lies in the box of its ends, cannot cross itself, and crosses an axis-parallel line at most once.
//! Intersections and winding numbers of whole curves therefore reduce to box tests and bisection. Arcs end at the roots
//! of the derivatives' numerators, isolated by the signs of their Bernstein coefficients (Descartes' rule).

use crate::math::bernstein::{self, dot};
use crate::math::solve::bisected;
use crate::model::{TrimCurve, TrimPiece, to_bezier};
use glam::{DVec2, DVec3, DVec4};

/// A rectangle of a surface's parameters, mapped to the unit square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvDomain {
    /// Lower corner.
    pub low: DVec2,
    /// Upper corner.
    pub high: DVec2,
    /// In u and in v: whether opposite sides are the same line of the surface.
    pub periodic: [bool; 2],
}

impl UvDomain {
    /// A rectangle without periods.
    #[must_use]
    pub fn new(low: DVec2, high: DVec2) -> Self {
        Self { low, high, periodic: [false; 2] }
    }

    fn to_unit(self, p: DVec2) -> DVec2 {
        let q = (p - self.low) / (self.high - self.low);
        // Rounding of the quotient must not move points off the border.
        DVec2::select(p.cmpeq(self.high), DVec2::ONE, q)
    }

    pub(crate) fn of_unit(self, q: DVec2) -> DVec2 {
        let p = self.low + q * (self.high - self.low);
        DVec2::select(q.cmpeq(DVec2::ONE), self.high, p)
    }
}

/// A rational Bézier arc, monotone in both coordinates of the unit square.
#[derive(Clone, Debug)]
pub(crate) struct Span {
    /// `(w x, w y, w)`.
    pub(crate) control: Vec<DVec3>,
    /// Its ends. Neighbours in a chain share them bit for bit.
    pub(crate) ends: [DVec2; 2],
    /// Index of the piece of the curve that contains it, and its range there. Points of a polyline have integer
    /// parameters.
    pub(crate) piece: usize,
    pub(crate) range: (f64, f64),
}

impl Span {
    pub(crate) fn line(a: DVec2, b: DVec2, piece: usize, range: (f64, f64)) -> Self {
        Self { control: vec![a.extend(1.0), b.extend(1.0)], ends: [a, b], piece, range }
    }

    pub(crate) fn low(&self) -> DVec2 {
        self.ends[0].min(self.ends[1])
    }

    pub(crate) fn high(&self) -> DVec2 {
        self.ends[0].max(self.ends[1])
    }

    /// The point at `s`, clamped to 0..=1.
    pub(crate) fn point(&self, s: f64) -> DVec2 {
        if s <= 0.0 {
            return self.ends[0];
        }
        if s >= 1.0 {
            return self.ends[1];
        }
        if let [a, b] = self.control[..]
            && a.z == b.z
        {
            return self.ends[0] + (self.ends[1] - self.ends[0]) * s;
        }
        bernstein::with_rows(self.control.len() - 1, |rows| {
            let n = &mut rows[..self.control.len()];
            bernstein::basis(s, n);
            let sum = dot(n, &self.control);
            sum.truncate() / sum.z
        })
    }

    /// Point, first and second derivative by `s`.
    pub(crate) fn derivatives(&self, s: f64) -> [DVec2; 3] {
        let n = self.control.len();
        bernstein::with_rows(n - 1, |rows| {
            bernstein::basis_with_derivatives(n - 1, s, rows);
            let [c, c1, c2] = [0, 1, 2].map(|k| dot(&rows[k * n..(k + 1) * n], &self.control));
            let p = c.truncate() / c.z;
            let d1 = (c1.truncate() - p * c1.z) / c.z;
            let d2 = (c2.truncate() - d1 * (2.0 * c1.z) - p * c2.z) / c.z;
            [p, d1, d2]
        })
    }

    /// The parameter of the piece at `s`.
    pub(crate) fn parameter(&self, s: f64) -> f64 {
        if s >= 1.0 { self.range.1 } else { self.range.0 + (self.range.1 - self.range.0) * s }
    }

    /// The `s` at which coordinate `axis` is `x`, by bisection. `x` must lie between the ends.
    pub(crate) fn at(&self, axis: usize, x: f64) -> f64 {
        let rising = self.ends[1][axis] > self.ends[0][axis];
        let [low, high] = bisected([0.0, 1.0], 60, |s| (self.point(s)[axis] < x) == rising);
        0.5 * (low + high)
    }
}

/// The spans of a curve, end to end. Empty if all its points coincide.
pub(crate) fn spans(curve: &TrimCurve, domain: &UvDomain) -> Vec<Span> {
    let mut out: Vec<Span> = Vec::new();
    for (piece, stated) in curve.pieces.iter().enumerate() {
        match stated {
            TrimPiece::Polyline(points) => {
                let points: Vec<DVec2> = points.iter().map(|&p| domain.to_unit(p)).collect();
                let segments = points.windows(2).enumerate();
                out.extend(segments.map(|(k, w)| Span::line(w[0], w[1], piece, (k as f64, k as f64 + 1.0))));
            }
            TrimPiece::Nurbs(nurbs) => {
                let weight = |k: usize| nurbs.weights.get(k).copied().unwrap_or(1.0);
                let row = |(k, &p): (usize, &DVec2)| {
                    let q = domain.to_unit(p) * weight(k);
                    DVec4::new(q.x, q.y, 0.0, weight(k))
                };
                let rows: Vec<DVec4> = nurbs.points.iter().enumerate().map(row).collect();
                let (breaks, net) = to_bezier(nurbs.degree, &nurbs.knots, &rows, 1, nurbs.domain());
                for (range, control) in breaks.windows(2).zip(net.chunks_exact(nurbs.degree + 1)) {
                    let control: Vec<DVec3> = control.iter().map(|c| DVec3::new(c.x, c.y, c.w)).collect();
                    monotone(&control, piece, (range[0], range[1]), &mut out);
                }
            }
        }
    }
    out.retain(|s| s.ends[0] != s.ends[1] || s.control.windows(2).any(|c| c[0] / c[0].z != c[1] / c[1].z));
    for k in 1..out.len() {
        out[k].ends[0] = out[k - 1].ends[1];
    }
    out
}

/// Cuts a segment at the extremes of its coordinates and appends the pieces.
fn monotone(control: &[DVec3], piece: usize, range: (f64, f64), out: &mut Vec<Span>) {
    /// Cuts closer than this share of a segment are one.
    const SAME: f64 = 1e-12;
    let mut cuts = vec![0.0, 1.0];
    for axis in 0..2 {
        roots(&slope(control, axis), (0.0, 1.0), &mut cuts);
    }
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|b, a| *b - *a <= SAME || (*b < 1.0 && *b > 1.0 - SAME));
    for w in cuts.windows(2) {
        let mut part = control.to_vec();
        bernstein::restrict(&mut part, w[0], w[1]);
        let ends = [part[0], part[part.len() - 1]].map(|c| c.truncate() / c.z);
        let at = |s: f64| if s >= 1.0 { range.1 } else { range.0 + (range.1 - range.0) * s };
        out.push(Span { control: part, ends, piece, range: (at(w[0]), at(w[1])) });
    }
}

/// Bernstein coefficients of the numerator of the derivative of coordinate `axis`, up to a positive factor.
fn slope(control: &[DVec3], axis: usize) -> Vec<f64> {
    let [x, w]: [Vec<f64>; 2] = [control.iter().map(|c| c[axis]).collect(), control.iter().map(|c| c.z).collect()];
    let rises = |c: &[f64]| c.windows(2).map(|p| p[1] - p[0]).collect::<Vec<f64>>();
    if w.windows(2).all(|p| p[0] == p[1]) {
        return rises(&x);
    }
    let (left, right) = (product(&rises(&x), &w), product(&x, &rises(&w)));
    left.iter().zip(&right).map(|(a, b)| a - b).collect()
}

fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let (m, n) = (a.len() - 1, b.len() - 1);
    let [of_a, of_b, of_both] = [m, n, m + n].map(bernstein::binomials);
    let mut out = vec![0.0; m + n + 1];
    for i in 0..=m {
        for j in 0..=n {
            out[i + j] += a[i] * b[j] * of_a[i] * of_b[j] / of_both[i + j];
        }
    }
    out
}

/// Appends the roots inside `range` of the polynomial with Bernstein coefficients `c` over it.
fn roots(c: &[f64], range: (f64, f64), out: &mut Vec<f64>) {
    /// Roots in an interval narrower than this are one.
    const NARROW: f64 = 1e-9;
    /// Coefficients below this share of the largest one are rounding: a constant coordinate has no extremes.
    const ROUNDING: f64 = 1e-13;
    fn halve(c: &[f64], (low, high): (f64, f64), zero: f64, out: &mut Vec<f64>) {
        let signs = c.iter().filter(|x| x.abs() > zero).map(|&x| x > 0.0);
        let changes = signs.clone().zip(signs.skip(1)).filter(|(a, b)| a != b).count();
        if changes == 0 {
            return;
        }
        let middle = 0.5 * (low + high);
        if high - low <= NARROW && changes > 1 || high - low <= 4.0 * f64::EPSILON {
            out.push(middle);
            return;
        }
        let (mut left, mut right) = (c.to_vec(), c.to_vec());
        bernstein::restrict(&mut left, 0.0, 0.5);
        bernstein::restrict(&mut right, 0.5, 1.0);
        // A root exactly at the middle changes no sign in either half.
        let before = left.iter().rev().find(|x| x.abs() > zero);
        let after = right.iter().find(|x| x.abs() > zero);
        if right[0].abs() <= zero && before.zip(after).is_some_and(|(a, b)| (*a > 0.0) != (*b > 0.0)) {
            out.push(middle);
        }
        halve(&left, (low, middle), zero, out);
        halve(&right, (middle, high), zero, out);
    }
    let largest = c.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if largest > 0.0 {
        halve(c, range, ROUNDING * largest, out);
    }
}
