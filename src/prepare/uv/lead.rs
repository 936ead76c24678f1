//! Edges whose curves end off their vertices -> blends from vertex to curve; curves -> the parameters at which their
//! images are sampled first, among them kinks.

use crate::math::solve::equal_pieces;
use crate::model::{CurveKind, Edge};
use glam::DVec3;
use smallvec::SmallVec;

/// Length of the blend from a vertex to the curve, in multiples of the gap between both.
const LEAD: f64 = 16.0;

/// A smooth offset that moves the end of an edge's curve to its vertex and fades along the edge.
pub(super) struct EndBlend {
    off: DVec3,
    from: f64,
    /// In the edge's parameter, negative from its end.
    length: f64,
}

impl EndBlend {
    /// The offset to add to the curve's point at `t`, and its derivative.
    pub(super) fn at(&self, t: f64) -> [DVec3; 2] {
        let s = (t - self.from) / self.length;
        if s >= 1.0 {
            return [DVec3::ZERO; 2];
        }
        [self.off * (1.0 - s * s * (3.0 - 2.0 * s)), self.off * (6.0 * s * (s - 1.0) / self.length)]
    }
}

/// The blends at both ends of an edge; `None` where the curve ends within `tolerance` of the vertex.
pub(super) fn leads(edge: &Edge, ends: [DVec3; 2], tolerance: f64) -> [Option<EndBlend>; 2] {
    let (t0, t1) = edge.range;
    [(ends[0], t0, t1), (ends[1], t1, t0)].map(|(end, from, to)| {
        let off = end - curve_end(edge, from);
        let far = |share: f64| edge.curve.point(from + (to - from) * share).distance(end);
        let reach = LEAD * off.length();
        (off.length() > tolerance).then(|| {
            let mut share = 1e-3;
            while share < 0.5 && far(share) < reach {
                share *= 1.5;
            }
            EndBlend { off, from, length: (to - from) * share.min(0.5) }
        })
    })
}

/// A curve's point at an end of an edge. Most curves are clamped there: the control point is taken without evaluation.
pub(crate) fn curve_end(edge: &Edge, t: f64) -> DVec3 {
    let (curve, count) = (&edge.curve, edge.curve.degree + 1);
    let all_there = |knots: Option<&[f64]>| knots.is_some_and(|knots| knots.iter().all(|&k| k == t));
    let first = all_there(curve.knots.get(..count)).then(|| curve.points.first()).flatten();
    let last = || {
        all_there(curve.knots.len().checked_sub(count).and_then(|k| curve.knots.get(k..))).then(|| curve.points.last())
    };
    first.or_else(|| last().flatten()).copied().unwrap_or_else(|| curve.point(t))
}

/// Distance of a sample before a kink from the kink, as a share of the edge: points that close are one.
const BEFORE: f64 = 1e-10;

/// Parameters just before the kinks of an edge's curve. A sample there has the slope of the piece that ends, one at the
/// kink that of the piece that starts.
fn before_breaks(edge: &Edge) -> impl Iterator<Item = f64> + '_ {
    /// Tangents that differ by less than this share of the longer one are no kink: cubics follow them.
    const SAME: f64 = 1e-3;
    let (t0, t1) = edge.range;
    let (knots, degree) = (&edge.curve.knots, edge.curve.degree);
    let inner = knots.chunk_by(|a, b| a == b).filter(move |same| same.len() >= degree).map(|same| same[0]);
    inner.filter_map(move |t| {
        let before = t - (BEFORE * (t1 - t0)).max(8.0 * f64::EPSILON * t.abs());
        let margin = 1e-9 * (t1 - t0);
        if t <= t0 + margin || t >= t1 - margin {
            return None;
        }
        let [[_, left], [_, right]] = [before, t].map(|t| edge.curve.tangent(t));
        ((left - right).length() > SAME * left.length().max(right.length())).then_some(before)
    })
}

/// Parameters of an edge between which its image is refined: its ends, kinks, and even pieces of its spans. `is_exact`:
/// the image is the line between the ends.
pub(super) fn first_parameters(edge: &Edge, is_exact: bool) -> Vec<f64> {
    let (t0, t1) = edge.range;
    let margin = 1e-9 * (t1 - t0);
    let knots = edge.curve.knots.iter().copied().filter(|&k| k > t0 + margin && k < t1 - margin);
    let mut ts: SmallVec<[f64; 16]> = std::iter::once(t0).chain(knots).chain([t1]).collect();
    ts.dedup();
    let pieces = match edge.kind {
        CurveKind::Line if is_exact => 1,
        CurveKind::Line | CurveKind::Circle | CurveKind::Conic => 2,
        CurveKind::Polyline => 1,
        CurveKind::Spline if ts.len() > 32 => 1,
        CurveKind::Spline => (8 / (ts.len() - 1).max(1)).max(2),
    };
    let mut fine = Vec::with_capacity(pieces * (ts.len() - 1) + 1);
    fine.extend(equal_pieces(&ts, pieces));
    if matches!(edge.kind, CurveKind::Spline | CurveKind::Polyline) {
        fine.extend(before_breaks(edge));
        fine.sort_by(f64::total_cmp);
    }
    fine.push(t1);
    fine
}

/// The next parameter on the side on which `ts[k]` bounds a piece, if there is only one: for ends, and for both
/// parameters of a kink.
pub(super) fn only_neighbour(ts: &[f64], k: usize) -> Option<f64> {
    let last = ts.len() - 1;
    let is_kink = |a: usize, b: usize| (ts[b] - ts[a]).abs() <= 4.0 * BEFORE * (ts[last] - ts[0]).abs();
    let has = [k > 0 && !is_kink(k - 1, k), k < last && !is_kink(k, k + 1)];
    match has {
        [true, false] => Some(ts[k - 1]),
        [false, true] => Some(ts[k + 1]),
        _ => None,
    }
}
