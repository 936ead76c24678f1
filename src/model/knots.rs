//! Knot vectors -> spans, B-spline basis functions with two derivatives, Bézier extraction matrices.
//!
//! Basis: the triangular Cox–de Boor scheme, run once for values and derivatives (Piegl & Tiller, *The NURBS Book*,
//! ch. 2). Extraction: Bézier points are blossom values (Ramshaw), as one small matrix per span.

use crate::math::bernstein::{raise_all, raise_piece, with_rows};
use crate::math::boxes::around;
use glam::DVec4;
use std::cell::LazyCell;

/// Maximum number of turns of a face around a periodic surface, and of periods by which [`unroll`] extends a spline on
/// either side. Springs have tens, threads and coils hundreds.
pub(crate) const MOST_TURNS: f64 = 20_000.0;

/// The same around a surface that is periodic both ways: its net grows with the product.
pub(crate) const MOST_TURNS_BOTH_WAYS: f64 = 300.0;

/// The domain `[knots[degree], knots[count]]` of a spline with `count` control points.
///
/// With too few knots the domain is `[0, 0]`; no panic.
pub(crate) fn domain(degree: usize, knots: &[f64]) -> (f64, f64) {
    let count = knots.len().saturating_sub(degree + 1);
    match (knots.get(degree), knots.get(count)) {
        (Some(&a), Some(&b)) => (a, b),
        _ => (0.0, 0.0),
    }
}

/// Index `i` of the non-empty knot span `[knots[i], knots[i+1])` that contains `t`; at the domain's end, the last span.
pub(crate) fn span(degree: usize, knots: &[f64], t: f64) -> usize {
    span_after(degree, knots, |k| k <= t)
}

/// Like [`span`], but at a knot, the span that ends there.
pub(crate) fn span_left(degree: usize, knots: &[f64], t: f64) -> usize {
    span_after(degree, knots, |k| k < t)
}

/// The non-empty span after the inner knots that are `before`, else the nearest before it, else the nearest after it.
#[inline]
fn span_after(degree: usize, knots: &[f64], before: impl Fn(f64) -> bool) -> usize {
    let inside = &knots[degree + 1..knots.len() - degree - 1];
    let found = degree + inside.partition_point(|&k| before(k));
    if knots[found] < knots[found + 1] { found } else { nearest_full(degree, knots, found) }
}

#[cold]
fn nearest_full(degree: usize, knots: &[f64], found: usize) -> usize {
    let full = |i: &usize| knots[*i] < knots[*i + 1];
    let count = knots.len() - degree - 1;
    (degree..=found).rev().find(full).or_else(|| (found..count).find(full)).unwrap_or(degree)
}

/// Indices of the non-empty spans of the domain, in order.
pub(crate) fn spans(degree: usize, knots: &[f64]) -> impl Iterator<Item = usize> + '_ {
    (degree..knots.len().saturating_sub(degree + 1)).filter(|&i| knots[i] < knots[i + 1])
}

/// The clamped knots of Bézier pieces of `degree` between `breaks`, end to end.
pub(crate) fn knots_of_pieces(degree: usize, breaks: &[f64]) -> Vec<f64> {
    let inner = breaks.iter().flat_map(|&t| std::iter::repeat_n(t, degree));
    breaks.first().copied().into_iter().chain(inner).chain(breaks.last().copied()).collect()
}

/// Whether first derivatives are continuous: no inner knot is repeated as often as the degree, to [`SLIVER`].
pub(crate) fn is_smooth(degree: usize, knots: &[f64]) -> bool {
    let (a, b) = domain(degree, knots);
    let inner = |k: f64| k > a && k < b;
    let is_one = |near: &[f64]| near[near.len() - 1] - near[0] <= SLIVER * (b - a);
    !knots.windows(degree.max(1)).any(|near| is_one(near) && near.iter().any(|&k| inner(k)))
}

/// The distinct knots of the domain, ends included.
pub(crate) fn breaks(degree: usize, knots: &[f64]) -> Vec<f64> {
    let (a, b) = domain(degree, knots);
    let mut found: Vec<f64> = knots.iter().copied().filter(|&k| k >= a && k <= b).collect();
    found.dedup();
    found
}

/// Calls `work` with the values, first and second derivatives at `t` of the basis functions of `span`: three rows of
/// `degree + 1` numbers, one after the other. `t` may lie outside the span.
///
/// Function `j` belongs to control point `span - degree + j`. Only the first `ROWS` rows are filled in, with the same
/// bits whatever `ROWS` is: values alone cost a third.
pub(crate) fn with_basis<const ROWS: usize, R>(
    degree: usize,
    knots: &[f64],
    span: usize,
    t: f64,
    work: impl FnOnce(&[f64]) -> R,
) -> R {
    let around = &knots[span + 1 - degree..=span + degree];
    with_rows(degree, |rows| {
        // Known degrees let the loops unroll. Nearly all curves and surfaces have one of these.
        match degree {
            1 => fill::<ROWS>(1, around, t, rows),
            2 => fill::<ROWS>(2, around, t, rows),
            3 => fill::<ROWS>(3, around, t, rows),
            _ => fill::<ROWS>(degree, around, t, rows),
        }
        work(rows)
    })
}

/// Raises the basis from degree 0 to `degree`, with both derivatives. `around`: the `2 · degree` knots about the span.
#[inline(always)]
fn fill<const ROWS: usize>(degree: usize, around: &[f64], t: f64, rows: &mut [f64]) {
    let around = &around[..2 * degree];
    // Of files, most spans are Bézier pieces: all their terms have the same quotient.
    match piece(degree, around) {
        Some((left, right)) => {
            let width = right - left;
            raise_piece::<ROWS>(degree, (t - left) / width, width, rows);
        }
        None => raise_all::<ROWS>(degree, rows, |k, i| {
            let (left, right) = (around[degree - k + i], around[degree + i]);
            let width = right - left;
            ((t - left) / width, width)
        }),
    }
}

/// The ends of a span if its polynomial is a Bézier piece: all `degree` knots up to it are one, and all from it on.
/// `around` has these knots.
#[inline(always)]
fn piece(degree: usize, around: &[f64]) -> Option<(f64, f64)> {
    let (left, right) = (around[degree - 1], around[degree]);
    (around[0] == left && around[2 * degree - 1] == right).then_some((left, right))
}

/// Writes the matrix `m` of Bézier extraction: Bézier point `j` of `[a, b]` (inside `span`) is
/// `Σ_i m[j · (degree + 1) + i] · c[span - degree + i]`.
///
/// Row `j` holds the blossom of every basis function at `degree - j` times `a` and `j` times `b`.
fn extraction(degree: usize, knots: &[f64], span: usize, a: f64, b: f64, matrix: &mut Vec<f64>) {
    let n = degree + 1;
    matrix.clear();
    matrix.resize(n * n, 0.0);
    for (j, row) in matrix.chunks_exact_mut(n).enumerate() {
        row[0] = 1.0;
        for k in 1..=degree {
            let t = if k <= degree - j { a } else { b };
            let mut carry = 0.0;
            for i in 0..k {
                let left = knots[span + 1 + i - k];
                let right = knots[span + 1 + i];
                let x = (t - left) / (right - left);
                let old = row[i];
                row[i] = carry + (1.0 - x) * old;
                carry = x * old;
            }
            row[k] = carry;
        }
    }
}

/// A segment shorter than this share of the range may be rounding, with noise for derivatives: ends come from
/// projections good to 1e-10, knots from files with as few as ten digits.
const SLIVER: f64 = 1e-9;

/// A segment shorter than [`SLIVER`] is dropped only if its net, too, is smaller than this share of the whole net's
/// extent. At even speed its share is about [`SLIVER`]. With knots a billion times further apart elsewhere, any segment
/// is that short in the parameter.
const SLIVER_IN_SPACE: f64 = 1e-7;

/// Converts control rows over knots to Bézier rows over `range`, clamped to the domain. Knots closer than [`SLIVER`]
/// and [`SLIVER_IN_SPACE`] count as one.
///
/// `rows` has `width` homogeneous points per control row. Returns the segment borders and, segment by segment,
/// `degree + 1` rows of `width` points. Adjacent segments share their border row bit for bit.
pub(crate) fn to_bezier(
    degree: usize,
    knots: &[f64],
    rows: &[DVec4],
    width: usize,
    range: (f64, f64),
) -> (Vec<f64>, Vec<DVec4>) {
    let (k0, k1) = domain(degree, knots);
    let (a, b) = (range.0.clamp(k0, k1), range.1.clamp(k0, k1));
    let n = degree + 1;
    let mut matrix = Vec::new();
    let mut append = |from: f64, to: f64, net: &mut Vec<DVec4>| {
        let span = span(degree, knots, 0.5 * (from + to));
        let source = &rows[(span - degree) * width..(span + 1) * width];
        let shared = usize::from(!net.is_empty());
        net.extend_from_within(net.len() - shared * width..);
        extraction(degree, knots, span, from, to, &mut matrix);
        let first = net.len();
        net.resize(first + (n - shared) * width, DVec4::ZERO);
        for (sums, factors) in net[first..].chunks_exact_mut(width).zip(matrix.chunks_exact(n).skip(shared)) {
            for (&f, row) in factors.iter().zip(source.chunks_exact(width)).filter(|(f, _)| **f != 0.0) {
                sums.iter_mut().zip(row).for_each(|(sum, &point)| *sum += point * f);
            }
        }
    };
    let least = LazyCell::new(|| SLIVER_IN_SPACE * extent(rows.iter()));
    let mut is_long = |from: f64, to: f64| {
        to - from > SLIVER * (b - a)
            || to > from && {
                let mut net = Vec::with_capacity(n * width);
                append(from, to, &mut net);
                (0..width).any(|line| extent(net[line..].iter().step_by(width)) > *least)
            }
    };
    let breaks = breaks(degree, knots);
    let mut borders = Vec::with_capacity(breaks.len() + 1);
    borders.push(a);
    for k in breaks {
        if k < b && is_long(borders[borders.len() - 1], k) && is_long(k, b) {
            borders.push(k);
        }
    }
    borders.push(b);
    let mut net: Vec<DVec4> = Vec::with_capacity((borders.len() - 1) * n * width);
    for ends in borders.windows(2) {
        append(ends[0], ends[1], &mut net);
    }
    (borders, net)
}

/// Longest side of the box around homogeneous points.
fn extent<'a>(points: impl Iterator<Item = &'a DVec4>) -> f64 {
    let [low, high] = around(points.map(|p| p.truncate() / p.w));
    (high - low).max_element()
}

/// Repeats a periodic spline until it covers `range`. Unchanged if the domain already covers it.
///
/// The ends must coincide. Copies are joined by a knot of multiplicity `degree`; at most [`MOST_TURNS`] are added on
/// either side. Rational nets are scaled from copy to copy so that the weights agree at the joints.
pub(crate) fn unroll(
    degree: usize,
    knots: &[f64],
    rows: &[DVec4],
    width: usize,
    range: (f64, f64),
) -> (Vec<f64>, Vec<DVec4>) {
    let (k0, k1) = domain(degree, knots);
    let period = k1 - k0;
    // A range that overshoots by rounding takes no further copy.
    let turns = |miss: f64| (miss / period - 1e-9).ceil().clamp(0.0, MOST_TURNS);
    let (before, after) = (turns(k0 - range.0), turns(range.1 - k1));
    if before + after == 0.0 {
        return (knots.to_vec(), rows.to_vec());
    }
    let count = knots.len() - degree - 1;
    let clamped = knots[0] == k0 && knots[knots.len() - 1] == k1;
    let (inner, rows) = if clamped {
        (knots[degree + 1..count].to_vec(), rows.to_vec())
    } else {
        let (borders, pieces) = to_bezier(degree, knots, rows, width, (k0, k1));
        let joints = borders[1..borders.len() - 1].iter().flat_map(|&k| std::iter::repeat_n(k, degree)).collect();
        let joined = pieces.chunks_exact((degree + 1) * width).enumerate();
        (joints, joined.flat_map(|(i, piece)| piece[if i == 0 { 0 } else { width }..].to_vec()).collect())
    };
    let scale = rows[rows.len() - width].w / rows[0].w;
    let mut out_knots = vec![k0 - before * period; degree + 1];
    let mut out_rows: Vec<DVec4> = Vec::new();
    let mut copy = -before;
    while copy <= after {
        // The original copy keeps its end knots to the last bit.
        let end = if copy < 0.0 { k0 + (copy + 1.0) * period } else { k1 + copy * period };
        out_knots.extend(inner.iter().map(|k| k + copy * period));
        out_knots.extend(std::iter::repeat_n(end, if copy == after { degree + 1 } else { degree }));
        let factor = libm::pow(scale, copy);
        let skipped = if out_rows.is_empty() { 0 } else { width };
        out_rows.extend(rows[skipped..].iter().map(|&p| if factor == 1.0 { p } else { p * factor }));
        copy += 1.0;
    }
    (out_knots, out_rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Knots of a spline whose domain is the middle one of three Bézier pieces.
    fn bezier_knots(degree: usize) -> Vec<f64> {
        [-1.0, 0.25, 0.7, 3.0].into_iter().flat_map(|k| std::iter::repeat_n(k, degree)).collect()
    }

    #[test]
    fn bases_of_bezier_pieces_are_those_of_any_spline() {
        for degree in [1, 2, 3, 5, 22] {
            let knots = bezier_knots(degree);
            let around = &knots[degree..3 * degree];
            for t in [0.25, 0.3, 0.5, 0.699, 0.7] {
                let (mut rows, mut general) = (vec![0.0; 3 * (degree + 1)], vec![0.0; 3 * (degree + 1)]);
                fill::<3>(degree, around, t, &mut rows);
                raise_all::<3>(degree, &mut general, |k, i| {
                    let (left, right) = (around[degree - k + i], around[degree + i]);
                    ((t - left) / (right - left), right - left)
                });
                let bits = |rows: &[f64]| rows.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&rows), bits(&general), "degree {degree} at {t}");
            }
        }
    }

    #[test]
    fn whole_bezier_pieces_have_their_control_points() {
        for degree in [1, 2, 3, 5] {
            let knots = bezier_knots(degree);
            let mut matrix = Vec::new();
            extraction(degree, &knots, 2 * degree - 1, 0.25, 0.7, &mut matrix);
            let n = degree + 1;
            assert!(matrix.iter().enumerate().all(|(k, &f)| f == f64::from(u8::from(k % n == k / n))), "{matrix:?}");
            let count = (knots.len() - n) as u32;
            let rows: Vec<DVec4> = (0..2 * count)
                .map(|k| DVec4::new((0.3 * f64::from(k)).sin(), -0.0, f64::from(k), 1.0 + 0.1 * f64::from(k)))
                .collect();
            let (borders, net) = to_bezier(degree, &knots, &rows, 2, (-9.0, 9.0));
            assert_eq!((borders, &net[..]), (vec![0.25, 0.7], &rows[2 * (degree - 1)..2 * (degree - 1 + n)]));
        }
    }

    #[test]
    fn a_closed_spline_goes_round_as_often_as_asked() {
        // A closed polygon.
        let rows = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]].map(|[x, y]| DVec4::new(x, y, 0.0, 1.0));
        let knots = [0.0, 0.0, 1.0, 2.0, 3.0, 3.0];
        let (unrolled, points) = unroll(1, &knots, &rows, 1, (-60.0, 300.0));
        assert_eq!((domain(1, &unrolled), points.len()), ((-60.0, 300.0), 361));
        assert!((0..3).all(|k| points.iter().skip(k).step_by(3).all(|p| *p == rows[k])));
    }
}
