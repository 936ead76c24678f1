//! B-spline curves -> pieces, joined curves, curves of higher degree, nearest points; arcs of hyperbolas and parabolas
//! -> exact quadratic B-splines.
//!
//! Knots are inserted by Boehm's rule; degrees are raised per Bézier piece. Arcs are constructed classically: end
//! points, and the intersection of the end tangents, weighted with the hyperbolic cosine of half the span (1 for the
//! parabola).

use crate::math::boxes::{around, distance_squared};
use crate::math::solve::foot;
use crate::model::{NurbsCurve3, NurbsSurface, euclidean, homogeneous, of_pieces, to_bezier};
use glam::{DVec3, DVec4};
use smallvec::SmallVec;

/// Indices of the remaining control points, and the remaining knots.
type ReducedKnots = (Vec<usize>, Vec<f64>);

/// Removes knots of too high multiplicity and their control points: inner knots of multiplicity `degree + 1` or more,
/// if `joins` says that both sides of the break are one point, and end knots above `degree + 1`. `None` if there are
/// none. Linear in the number of knots.
///
/// # Errors
/// The first break whose sides differ.
pub(super) fn without_breaks(
    knots: &[f64],
    degree: usize,
    joins: impl Fn(usize, usize) -> bool,
) -> Result<Option<ReducedKnots>, f64> {
    let (mut first, mut last) = (0, knots.len() - degree - 1);
    while last - first > degree + 1 && knots[first] == knots[first + degree + 1] {
        first += 1;
    }
    while last - first > degree + 1 && knots[last - 1] == knots[last + degree] {
        last -= 1;
    }
    let (mut points, mut left) = (Vec::new(), Vec::new());
    for i in first..last {
        // Knots i ..= i + degree equal: the control points before and at i are the two sides of a break.
        let inner = points.len() > degree && i + 1 < last;
        if let Some(&before) = points.last().filter(|_| inner && knots[i] == knots[i + degree]) {
            if !joins(before, i) {
                return Err(knots[i]);
            }
        } else {
            points.push(i);
            left.push(knots[i]);
        }
    }
    left.extend_from_slice(&knots[last..=last + degree]);
    Ok((left.len() < knots.len()).then_some((points, left)))
}

/// Inserts the knot `t`, which lies in the domain, up to multiplicity `degree`.
fn saturate(degree: usize, knots: &mut Vec<f64>, points: &mut Vec<DVec4>, t: f64) {
    let present = knots.iter().filter(|k| **k == t).count();
    for _ in present..degree {
        // The last knot ≤ t; t < domain end or t already saturates a clamped end.
        let last = knots.partition_point(|k| *k <= t) - 1;
        let multiplicity = knots.iter().filter(|k| **k == t).count();
        let first = last + 1 - degree;
        let mut fresh = Vec::with_capacity(points.len() + 1);
        fresh.extend_from_slice(&points[..first]);
        for i in first..=last - multiplicity {
            let a = (t - knots[i]) / (knots[i + degree] - knots[i]);
            fresh.push(points[i - 1] * (1.0 - a) + points[i] * a);
        }
        fresh.extend_from_slice(&points[last - multiplicity..]);
        *points = fresh;
        knots.insert(last + 1, t);
    }
}

/// The part over `[from, to]` within the domain, as a clamped curve. The whole curve if that range is empty.
pub(super) fn piece(curve: &NurbsCurve3, from: f64, to: f64) -> NurbsCurve3 {
    let p = curve.degree;
    let (a, b) = curve.domain();
    // In this order, NaN becomes an end of the domain.
    let (from, to) = (from.max(a).min(b), to.max(a).min(b));
    let (from, to) = if from < to { (from, to) } else { (a, b) };
    let (mut knots, mut points) = (curve.knots.clone(), homogeneous(&curve.points, &curve.weights));
    saturate(p, &mut knots, &mut points, from);
    saturate(p, &mut knots, &mut points, to);
    let start = knots.partition_point(|k| *k <= from) - 1;
    let end = knots.partition_point(|k| *k < to);
    let mut cut = vec![from; p + 1];
    cut.extend_from_slice(&knots[start + 1..end]);
    cut.extend(std::iter::repeat_n(to, p + 1));
    let (points, weights) = euclidean(&points[start - p..end], !curve.weights.is_empty());
    NurbsCurve3 { degree: p, knots: cut, points, weights }
}

/// The part of a surface over `u` × `v` within its domain, as a clamped surface.
pub(super) fn patch(net: &NurbsSurface, u: (f64, f64), v: (f64, f64)) -> NurbsSurface {
    let along_v = cut_rows(net, v);
    cut_rows(&along_v.transposed(), u).transposed()
}

/// Cuts every row of the net along v.
fn cut_rows(net: &NurbsSurface, v: (f64, f64)) -> NurbsSurface {
    let width = net.count_v();
    let (mut points, mut weights, mut knots_v) = (Vec::new(), Vec::new(), Vec::new());
    for (i, row) in net.points.chunks(width).enumerate() {
        let weights_of_row = net.weights.get(i * width..(i + 1) * width).unwrap_or_default().to_vec();
        let curve = NurbsCurve3 {
            degree: net.degree_v,
            knots: net.knots_v.clone(),
            points: row.to_vec(),
            weights: weights_of_row,
        };
        let cut = piece(&curve, v.0, v.1);
        points.extend(cut.points);
        weights.extend(cut.weights);
        knots_v = cut.knots;
    }
    NurbsSurface { knots_v, points, weights, knots_u: net.knots_u.clone(), ..*net }
}

/// Drops the control points of a long curve that have no influence on a short range. Points in the range stay the same;
/// the result is not clamped. Other curves are returned unchanged.
///
/// Otherwise every edge on a part of one curve would hold the whole curve.
pub(super) fn window(curve: NurbsCurve3, (from, to): (f64, f64)) -> NurbsCurve3 {
    /// Minimum number of control points of a long curve.
    const LONG: usize = 64;
    let (p, count) = (curve.degree, curve.points.len());
    // The spans that hold the two ends.
    let last = curve.knots.partition_point(|k| *k < to).clamp(p + 1, count);
    let first = curve.knots.partition_point(|k| *k <= from).saturating_sub(1).clamp(p, last - 1);
    if count < LONG || 2 * (last - first) > count {
        return curve;
    }
    NurbsCurve3 {
        degree: p,
        knots: curve.knots[first - p..=last + p].to_vec(),
        points: curve.points[first - p..last].to_vec(),
        weights: curve.weights.get(first - p..last).unwrap_or_default().to_vec(),
    }
}

/// Ends of a closed curve that are nearer to each other than this share of its size are one: files round each by
/// itself.
pub(super) const ROUNDED: f64 = 1e-5;

/// Parameters of a curve that differ by no more than this share of its domain are one.
pub(super) const SAME_PARAMETER: f64 = 1e-9;

/// Moves the start of a closed curve to the inner parameter `s`, or to the knot at it; the domain becomes
/// `[s, s + period]`.
pub(super) fn restart(curve: &NurbsCurve3, s: f64) -> NurbsCurve3 {
    let (a, b) = curve.domain();
    // The shift of the parameters may round a shorter span to nothing.
    let s = curve.knots.iter().copied().find(|knot| (knot - s).abs() <= SAME_PARAMETER * (b - a)).unwrap_or(s);
    if !(a < s && s < b) {
        return curve.clone();
    }
    append(piece(curve, s, b), &piece(curve, a, s))
}

/// Appends a clamped curve of the same degree that starts at the end of `curve`; its parameters are shifted.
fn append(mut curve: NurbsCurve3, next: &NurbsCurve3) -> NurbsCurve3 {
    let p = curve.degree;
    let shift = curve.domain().1 - next.domain().0;
    if !curve.weights.is_empty() || !next.weights.is_empty() {
        curve.weights.resize(curve.points.len(), 1.0);
        let weight = |i: usize| next.weights.get(i).copied().unwrap_or(1.0);
        // A common factor of all weights does not change a curve; it makes the weights agree at the joint.
        let factor = curve.weights.last().copied().unwrap_or(1.0) / weight(0);
        curve.weights.extend((1..next.points.len()).map(|i| weight(i) * factor));
    }
    curve.points.extend_from_slice(&next.points[1..]);
    curve.knots.pop();
    curve.knots.extend(next.knots[p + 1..].iter().map(|k| k + shift));
    curve
}

/// Joins curves end to end, raised to the highest degree among them. `None` without curves.
pub(super) fn join(curves: &[NurbsCurve3]) -> Option<NurbsCurve3> {
    let degree = curves.iter().map(|c| c.degree).max()?;
    curves.iter().map(|c| raise(c, degree)).reduce(|all, next| append(all, &next))
}

/// Raises the degree of a curve, as a clamped chain of Bézier pieces.
fn raise(curve: &NurbsCurve3, degree: usize) -> NurbsCurve3 {
    let (a, b) = curve.domain();
    let whole = piece(curve, a, b);
    if whole.degree == degree {
        return whole;
    }
    let rows = homogeneous(&whole.points, &whole.weights);
    let (breaks, mut pieces) = to_bezier(whole.degree, &whole.knots, &rows, 1, (a, b));
    for p in whole.degree..degree {
        let raised = |bezier: &[DVec4], i: usize| {
            let share = i as f64 / (p + 1) as f64;
            bezier[i.saturating_sub(1)] * share + bezier[i.min(p)] * (1.0 - share)
        };
        pieces = pieces.chunks_exact(p + 1).flat_map(|bezier| (0..p + 2).map(move |i| raised(bezier, i))).collect();
    }
    of_pieces(degree, &breaks, &pieces, !whole.weights.is_empty())
}

/// A sample of a curve.
struct CurveSample {
    t: f64,
    /// From the point whose foot is searched.
    distance_squared: f64,
    /// The steps to the samples around it: at a knot, spans may differ in length.
    steps: [f64; 2],
}

/// The parameter of the curve point nearest to `p`: samples, `degree + 2` per span, that are nearer than those next to
/// them, refined by Newton's method. If no foot is next to `p`, eight times as many are tried: a curve that bends a lot
/// within a span may pass through `p` between two samples that are far from it.
pub(super) fn nearest(curve: &NurbsCurve3, p: DVec3) -> f64 {
    /// A foot this near to `p` ends the search. In shares of the way to the next sample.
    const BESIDE: f64 = 1e-3;
    let (a, b) = curve.domain();
    let mut found = (a, f64::INFINITY);
    for samples in [1, 8].map(|density| density * (curve.degree + 2)) {
        let mut minima = least_samples(curve, p, samples);
        minima.sort_by(|m, n| m.distance_squared.total_cmp(&n.distance_squared));
        let least = minima.first().map_or(0.0, |best| best.distance_squared);
        for (k, sample) in minima.iter().enumerate() {
            let CurveSample { t, distance_squared, steps: [before, after] } = *sample;
            let foot = foot(t, ((t - before).max(a), (t + after).min(b)), 1e-15 * (b - a), |t| {
                let d = curve.derivatives(t);
                let (away, square) = (d.point - p, d.d1.length_squared());
                [away.dot(d.d1), square + away.dot(d.d2), square]
            });
            for (t, off) in [(foot, curve.point(foot).distance_squared(p)), (t, distance_squared)] {
                if off < found.1 {
                    found = (t, off);
                }
            }
            // On a closed curve, the foot of a point near the start may lie just before the end, and vice versa.
            let has_twin = minima.get(k + 1).is_some_and(|next| next.distance_squared <= least);
            let [_, tangent] = curve.tangent(found.0);
            if !has_twin && found.1.sqrt() <= BESIDE * before.max(after) * tangent.length() {
                return found.0;
            }
        }
    }
    found.0
}

/// Of so many samples per span, those that are no further from `p` than the ones next to them, in order of their
/// parameters. Leaves out spans that certainly are further away than another sample.
fn least_samples(curve: &NurbsCurve3, p: DVec3, samples: usize) -> SmallVec<[CurveSample; 8]> {
    let (a, _) = curve.domain();
    let spans = curve.knots[curve.degree..=curve.points.len()].windows(2);
    let steps = spans.map(|ends| (ends, (ends[1] - ends[0]) / samples as f64)).enumerate();
    let steps = steps.filter(|(_, (_, step))| *step > 0.0);
    let at = |ends: &[f64], step: f64, i: usize| if i == samples { ends[1] } else { ends[0] + step * i as f64 };
    // A span is no nearer than the box of its control points.
    let hulls = curve.points.windows(curve.degree + 1);
    let floors: Vec<f64> = hulls.map(|hull| distance_squared(around(hull.iter().copied()), p)).collect();
    let first = steps.clone().min_by(|(k, _), (l, _)| floors[*k].total_cmp(&floors[*l]));
    let start = curve.point(a).distance_squared(p);
    let mut least = first.map_or(start, |(_, (ends, step))| {
        (1..=samples).map(|i| curve.point(at(ends, step, i)).distance_squared(p)).fold(start, f64::min)
    });
    let mut minima: SmallVec<[CurveSample; 8]> = SmallVec::new();
    let mut steps = steps.peekable();
    let first_step = steps.peek().map_or(0.0, |(_, (_, step))| *step);
    // The last sample, and whether it is no further than the one before. A span that is left out is further away.
    let mut last = (CurveSample { t: a, distance_squared: start, steps: [0.0, first_step] }, true);
    let mut is_next = true;
    while let Some((k, (ends, step))) = steps.next() {
        // Rounding may put the nearest sample below its lower bound, if it is a corner of the box.
        if floors[k] > least && first.is_none_or(|(first, _)| k != first) {
            is_next = false;
            continue;
        }
        for i in 1..=samples {
            let t = at(ends, step, i);
            let distance_squared = curve.point(t).distance_squared(p);
            let after = steps.peek().filter(|_| i == samples).map_or(step, |(_, (_, next))| *next);
            let before = std::mem::replace(&mut last.0, CurveSample { t, distance_squared, steps: [step, after] });
            let falls = !is_next || distance_squared <= before.distance_squared;
            let fell = std::mem::replace(&mut last.1, falls);
            if fell && (!is_next || before.distance_squared <= distance_squared) {
                minima.push(before);
            }
            (least, is_next) = (least.min(distance_squared), true);
        }
    }
    if last.1 {
        minima.push(last.0);
    }
    minima
}

/// Maximum number of spans of a hyperbolic arc. Files need one or two; a hostile one could ask for any number.
const MAX_SPANS: f64 = 64.0;

/// `C + x cosh t + y sinh t` for `t0 < t < t1`. Knots are values of t; spans are equal and at most 1 long, up to 64
/// spans.
pub(super) fn hyperbolic_arc(centre: DVec3, x: DVec3, y: DVec3, (t0, t1): (f64, f64)) -> NurbsCurve3 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 1 and 64")]
    let spans = ((t1 - t0).ceil().clamp(1.0, MAX_SPANS) as usize).max(1);
    let step = (t1 - t0) / spans as f64;
    let weight = libm::cosh(0.5 * step);
    let at = |t: f64| x * libm::cosh(t) + y * libm::sinh(t);
    let mut curve = NurbsCurve3 { degree: 2, knots: vec![t0; 3], points: vec![centre + at(t0)], weights: vec![1.0] };
    for span in 0..spans {
        let from = t0 + step * span as f64;
        let to = if span + 1 == spans { t1 } else { from + step };
        curve.points.extend([centre + at(0.5 * (from + to)) / weight, centre + at(to)]);
        curve.weights.extend([weight, 1.0]);
        curve.knots.extend([to, to]);
    }
    curve.knots.push(t1);
    curve
}

/// `C + x t² + 2 y t` for `t0 < t < t1`, as a polynomial curve.
pub(super) fn parabolic_arc(centre: DVec3, x: DVec3, y: DVec3, (t0, t1): (f64, f64)) -> NurbsCurve3 {
    let at = |t: f64| centre + x * (t * t) + y * (2.0 * t);
    NurbsCurve3 {
        degree: 2,
        knots: vec![t0, t0, t0, t1, t1, t1],
        points: vec![at(t0), centre + x * (t0 * t1) + y * (t0 + t1), at(t1)],
        weights: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Frame3;
    use std::f64::consts::TAU;

    fn circle() -> NurbsCurve3 {
        NurbsCurve3::arc(&Frame3::WORLD, 2.0, 1.0, 0.0, TAU)
    }

    #[test]
    fn a_restarted_curve_is_the_same_curve() {
        let (whole, moved) = (circle(), restart(&circle(), 1.0));
        assert_eq!(moved.domain(), (1.0, 1.0 + TAU));
        for i in 0..=100 {
            let t = 1.0 + TAU * f64::from(i) / 100.0;
            let expected = whole.point(if t > TAU { t - TAU } else { t });
            assert!(moved.point(t).distance(expected) < 1e-12, "at {t}");
        }
    }

    #[test]
    fn a_curve_restarted_beside_a_knot_has_no_shorter_span() {
        let knots = circle().knots;
        for s in knots.iter().flat_map(|&knot| [knot.next_down(), knot, knot.next_up()]) {
            let moved = restart(&circle(), s);
            assert!(moved.check().is_ok() && (moved.domain().1 - moved.domain().0 - TAU).abs() < 1e-12, "at {s}");
        }
        assert_eq!(restart(&circle(), 1e-17).knots, knots);
    }

    #[test]
    fn a_piece_of_an_unclamped_curve_is_clamped() {
        let points: Vec<DVec3> = (0..7).map(|i| DVec3::new(f64::from(i), f64::from(i * i % 5), 0.3)).collect();
        let curve = NurbsCurve3 { degree: 3, knots: (0..11).map(f64::from).collect(), points, weights: vec![] };
        let cut = piece(&curve, 3.0, 5.5);
        assert_eq!(cut.domain(), (3.0, 5.5));
        assert!(cut.points[0].distance(curve.point(3.0)) < 1e-14);
        for i in 0..=20 {
            let t = 3.0 + 2.5 * f64::from(i) / 20.0;
            assert!(cut.point(t).distance(curve.point(t)) < 1e-13, "at {t}");
        }
    }

    #[test]
    fn a_line_joins_an_arc() {
        let arc = NurbsCurve3::arc(&Frame3::WORLD, 1.0, 1.0, 0.0, 1.0);
        let line = NurbsCurve3::line(DVec3::new(3.0, 0.0, 0.0), DVec3::X);
        let both = join(&[line, arc.clone()]).expect("two curves");
        assert_eq!((both.degree, both.domain()), (2, (0.0, 2.0)));
        for i in 0..=10 {
            let t = f64::from(i) / 10.0;
            assert!(both.point(t).distance(DVec3::X * (3.0 - 2.0 * t)) < 1e-14);
            assert!(both.point(1.0 + t).distance(arc.point(t)) < 1e-14);
        }
    }

    /// A curve of uneven spans with double knots.
    fn wavy(degree: usize, count: usize) -> NurbsCurve3 {
        let point = |i: usize| DVec3::new(i as f64, (i * i % 7) as f64, (i * 3 % 5) as f64);
        let mut knots = vec![0.0; degree + 1];
        knots.extend((0..count - degree - 1).map(|i| (i - i % 3 / 2) as f64 + 1.0));
        knots.extend(vec![count as f64; degree + 1]);
        NurbsCurve3 { degree, knots, points: (0..count).map(point).collect(), weights: vec![] }
    }

    #[test]
    fn a_raised_curve_is_the_same_curve() {
        for (from, to) in [(2, 3), (2, 5), (3, 4)] {
            let curve = wavy(from, 20);
            let raised = raise(&curve, to);
            assert!(raised.degree == to && raised.check().is_ok() && raised.domain() == curve.domain());
            for i in 0..=200 {
                let t = 20.0 * f64::from(i) / 200.0;
                assert!(raised.point(t).distance(curve.point(t)) < 1e-12, "degree {from} to {to} at {t}");
            }
        }
    }

    #[test]
    fn a_window_has_the_same_numbers() {
        let long = wavy(3, 500);
        for range in [(0.0, 0.5), (0.0, 1.0), (7.25, 7.5), (7.25, 90.0), (498.5, 500.0), (10.0, 12.0)] {
            let cut = window(long.clone(), range);
            assert!(cut.points.len() < 110 && cut.check().is_ok(), "{range:?}: {}", cut.points.len());
            for i in 0..=50 {
                let t = range.0 + (range.1 - range.0) * f64::from(i) / 50.0;
                assert!(cut.point(t).distance(long.point(t)) < 1e-12, "{range:?} at {t}");
            }
        }
        assert_eq!(window(long.clone(), (10.0, 400.0)), long);
    }

    #[test]
    fn skipping_spans_changes_no_foot() {
        let curve = wavy(3, 60);
        for i in 0..100 {
            let p = DVec3::new(0.7 * f64::from(i) - 3.0, f64::from(i % 9), f64::from(i % 4));
            let found = curve.point(nearest(&curve, p)).distance(p);
            let sampled = (0..=6000).map(|k| curve.point(f64::from(k) / 100.0).distance(p));
            assert!(found <= sampled.fold(f64::INFINITY, f64::min) + 1e-2, "{p}: {found}");
        }
    }

    #[test]
    fn nearest_finds_an_end_that_is_a_corner_of_its_box() {
        for i in 0..500 {
            let scale = 1.0 / (3.0 + f64::from(i));
            let points = [[0.0, 0.0, 99.0], [30.0, 1.0, 2.0], [20.0, 5.0, 9.0], [40.0, 6.0, 11.0], [42.0, 7.0, 13.0]];
            let points = points.map(|p| DVec3::from(p) * scale).to_vec();
            let weights = vec![1.0, 0.9, 1.0, 0.9, 0.923_879_532_511];
            let knots = vec![0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0];
            let curve = NurbsCurve3 { degree: 2, knots, points, weights };
            let end = curve.points[4];
            // Outside the box of the last span, next to its corner.
            let p = end + DVec3::splat(1e-4);
            let found = curve.point(nearest(&curve, p)).distance(p);
            assert!(found <= end.distance(p) + 1e-12, "{scale}: {found}");
        }
    }

    #[test]
    fn a_foot_in_the_longer_of_two_spans_is_found_from_the_knot_between_them() {
        let points = [[0.0, 0.0], [0.14, 0.01], [2.8, 0.2], [5.5, 1.5], [8.4, 4.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let knots = vec![-0.4, -0.4, -0.4, -0.4, 0.0, 8.0, 8.0, 8.0, 8.0];
        let curve = NurbsCurve3 { degree: 3, knots, points: points.to_vec(), weights: Vec::new() };
        let mut reversed = curve.clone();
        reversed.points.reverse();
        reversed.knots = curve.knots.iter().rev().map(|t| -t).collect();
        for curve in [curve, reversed] {
            let (a, b) = curve.domain();
            for i in 0..=2000 {
                let p = curve.point(a + (b - a) * f64::from(i) / 2000.0);
                assert!(curve.point(nearest(&curve, p)).distance(p) < 1e-9, "{i}");
            }
        }
    }

    #[test]
    fn a_foot_is_found_where_another_branch_of_one_bent_span_is_nearer_to_the_samples() {
        let points = [
            [3.659_851_55, 0.0],
            [11.577_966_876, 10.892_677_685],
            [-29.919_895_196, -22.964_755_59],
            [60.936_095_56, 62.574_520_513],
            [-101.769_081_425, -80.959_866_87],
            [82.907_715_64, 72.012_858_79],
            [-45.453_516_257, -53.820_264_679],
            [15.661_607_349, 11.335_765_123],
            [3.659_851_55, 0.0],
        ];
        let points = points.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        let knots = [[0.0; 9], [1.0; 9]].concat();
        let curve = NurbsCurve3 { degree: 8, knots, points, weights: Vec::new() };
        for i in 0..=1000 {
            let p = curve.point(f64::from(i) / 1000.0);
            assert!(curve.point(nearest(&curve, p)).distance(p) < 1e-9, "{i}");
        }
    }

    #[test]
    fn nearest_finds_the_foot() {
        let curve = circle();
        for i in 0..50 {
            let t = TAU * f64::from(i) / 50.0 + 0.01;
            let d = curve.derivatives(t);
            let beside = d.point + DVec3::Z * 0.3;
            assert!(curve.point(nearest(&curve, beside)).distance(d.point) < 1e-9);
        }
    }

    #[test]
    fn arcs_lie_on_their_conics() {
        let c = DVec3::new(1.0, -2.0, 0.5);
        let hyperbola = hyperbolic_arc(c, DVec3::X * 3.0, DVec3::Y * 2.0, (-1.7, 2.4));
        let parabola = parabolic_arc(c, DVec3::X * 3.0, DVec3::Y * 3.0, (-2.0, 1.5));
        for i in 0..=40 {
            let s = f64::from(i) / 40.0;
            let p = hyperbola.point(-1.7 + 4.1 * s) - c;
            assert!(((p.x / 3.0).powi(2) - (p.y / 2.0).powi(2) - 1.0).abs() < 1e-11, "{p}");
            let q = parabola.point(-2.0 + 3.5 * s) - c;
            assert!((q.x / 3.0 - (q.y / 6.0).powi(2)).abs() < 1e-12, "{q}");
        }
        assert!((hyperbola.point(2.4) - c).distance(DVec3::new(3.0 * 2.4f64.cosh(), 2.0 * 2.4f64.sinh(), 0.0)) < 1e-12);
    }
}
