//! Edges whose curves end off their vertices, or whose tangents break -> how their images go there.

use crate::model::Edge;
use glam::DVec3;

/// Lengths of a gap between a curve and a vertex over which the image goes over from one to the other.
const LEAD: f64 = 16.0;

/// Takes the image of an edge from a vertex off its curve to the curve.
pub(crate) struct Lead {
    off: DVec3,
    from: f64,
    /// In the edge's parameter, negative from its end.
    length: f64,
}

impl Lead {
    /// How far the image's point is off the curve's, and the derivative of that.
    pub(crate) fn at(&self, t: f64) -> [DVec3; 2] {
        let s = (t - self.from) / self.length;
        if s >= 1.0 {
            return [DVec3::ZERO; 2];
        }
        [self.off * (1.0 - s * s * (3.0 - 2.0 * s)), self.off * (6.0 * s * (s - 1.0) / self.length)]
    }
}

/// How an edge whose curve ends off its vertices gets there.
pub(crate) fn leads(edge: &Edge, ends: [DVec3; 2], tolerance: f64) -> [Option<Lead>; 2] {
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
            Lead { off, from, length: (to - from) * share.min(0.5) }
        })
    })
}

/// A curve's point at an end of an edge; most curves start and end in their first and last control points, which costs nothing.
fn curve_end(edge: &Edge, t: f64) -> DVec3 {
    let (curve, count) = (&edge.curve, edge.curve.degree + 1);
    let all_there = |knots: Option<&[f64]>| knots.is_some_and(|knots| knots.iter().all(|&k| k == t));
    let first = all_there(curve.knots.get(..count)).then(|| curve.points.first()).flatten();
    let last = || {
        all_there(curve.knots.len().checked_sub(count).and_then(|k| curve.knots.get(k..))).then(|| curve.points.last())
    };
    first.or_else(|| last().flatten()).copied().unwrap_or_else(|| curve.point(t))
}

/// Parameters just before those at which a curve's tangent breaks: there the image has one slope, and at the break another.
pub(crate) fn before_breaks(edge: &Edge) -> impl Iterator<Item = f64> + '_ {
    /// Share of the edge before a break: points as near as that are one.
    const BEFORE: f64 = 1e-10;
    /// Share of the longer tangent by which both may differ: cubics follow that.
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
