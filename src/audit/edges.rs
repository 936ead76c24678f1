//! Edge polylines -> distances to the exact curves, and of the curves to them.

use super::foot::{search_curve, walk_curve};
use super::report::{EdgePlace, Tally};
use crate::mesh::FrameView;
use crate::prepare::Prepared;
use crate::prepare::internals::{BezierSpline3, EdgeShape, PreparedEdge};
use glam::DVec3;

/// Inner samples per segment in each direction. Odd, to include the middle.
const SAMPLES: u32 = 5;
/// Starts per Bézier segment of a search along a curve, if following the polyline did not find the foot point.
const STARTS: u32 = 32;

/// Fraction of the chord tolerance within which a tessellant counts as on its curve.
const ON_CURVE: f64 = 1e-3;

/// Measures all edges: ratios of distances to the chord tolerance of their part, and the worst place of each edge.
pub(super) fn measure(prepared: &Prepared, mesh: &FrameView<'_>, chords: &[f64]) -> (Tally, Vec<EdgePlace>) {
    let mut tally = Tally::default();
    let mut places = Vec::new();
    for line in mesh.edge_lines {
        let edge = prepared.parts.get(line.part.index()).and_then(|part| part.edges.get(line.edge.index()));
        let (Some(edge), Some(&chord)) = (edge, chords.get(line.part.index())) else { continue };
        let EdgeShape::Curve(curve) = &edge.shape else { continue };
        let mut place = EdgePlace { part: line.part, edge: line.edge, point: DVec3::ZERO, over_tolerance: -1.0 };
        let (start, end) = curve.range();
        let stride = (end - start) / (line.points.len().max(2) - 1) as f64;
        Follower { edge, curve, chord, stride }.measure(&line.points, &mut |distance, point| {
            let ratio = distance / chord;
            tally.add(ratio);
            if ratio > place.over_tolerance {
                place = EdgePlace { point, over_tolerance: ratio, ..place };
            }
        });
        if place.over_tolerance >= 0.0 {
            places.push(place);
        }
    }
    (tally, places)
}

/// Maximum distance in the file between the vertices of an edge and the ends of its curve.
pub(super) fn miss(edge: &PreparedEdge) -> f64 {
    match &edge.shape {
        EdgeShape::Curve(curve) => ends_missed(edge, curve).into_iter().fold(0.0, f64::max),
        EdgeShape::Point(_) => 0.0,
    }
}

/// Distances between vertices and curve at the first and the last parameter.
fn ends_missed(edge: &PreparedEdge, curve: &BezierSpline3) -> [f64; 2] {
    [edge.breaks.first(), edge.breaks.last()].map(|end| end.map_or(0.0, |end| end.point.distance(curve.point(end.t))))
}

/// Follows a curve along its polyline. Polylines have no parameters, so they are recovered: at breaks exactly, between
/// them by walking from the last sample.
struct Follower<'a> {
    edge: &'a PreparedEdge,
    curve: &'a BezierSpline3,
    chord: f64,
    /// Mean parameter length of a segment.
    stride: f64,
}

impl Follower<'_> {
    fn measure(&self, points: &[DVec3], add: &mut impl FnMut(f64, DVec3)) {
        let (t0, t1) = self.curve.range();
        let [start, end] = ends_missed(self.edge, self.curve);
        let breaks = &self.edge.breaks;
        let mut next_break = 1;
        let mut from = t0;
        for (k, ends) in points.windows(2).enumerate() {
            let limit = breaks.get(next_break).map_or(t1, |b| b.t);
            // Vertices may be off the curve in the file, which affects the first and the last segment.
            let first = if k == 0 { start } else { 0.0 };
            let last = if k + 2 == points.len() { end } else { 0.0 };
            let gap = first.max(last);
            let mut t = from;
            for i in 1..=SAMPLES {
                let p = ends[0].lerp(ends[1], f64::from(i) / f64::from(SAMPLES + 1));
                let (distance, at) = self.foot(p, t, (from, limit), self.chord + gap);
                t = at;
                add((distance - gap).max(0.0), p);
            }
            let to = if breaks.get(next_break).is_some_and(|b| b.point == ends[1]) {
                next_break += 1;
                limit
            } else {
                // A tessellant is on its curve. A point that is merely near may be on another leg of a curve that turns
                // back.
                self.foot(ends[1], t, (from, limit), ON_CURVE * self.chord + gap).1
            };
            for i in 1..=SAMPLES {
                let p = self.curve.point(from + (to - from) * f64::from(i) / f64::from(SAMPLES + 1));
                add((distance_to_segment(p, ends[0], ends[1]) - gap).max(0.0), p);
            }
            from = to;
        }
    }

    /// Distance from `p` to the curve within `range`, and the parameter of the foot point. Walks from `t`; searches the
    /// whole range if the result is farther than `near`.
    fn foot(&self, p: DVec3, t: f64, range: (f64, f64), near: f64) -> (f64, f64) {
        let enough = 1e-4 * self.chord;
        let found = walk_curve(self.curve, p, t, range, enough);
        if found.distance <= near {
            return (found.distance, found.at);
        }
        // A walk may stop at a sharp turn. Search nearby first, because another part of the curve may come as close.
        let segments = u32::try_from(self.curve.segments()).unwrap_or(u32::MAX).min(64);
        let (low, high) = range;
        let mut best = (found.distance, found.at);
        for end in [low + 4.0 * self.stride, low + 64.0 * self.stride, high] {
            let searched = search_curve(self.curve, p, (low, end.min(high)), STARTS * segments, enough);
            if searched.distance < best.0 {
                best = (searched.distance, searched.at);
            }
            if best.0 <= near {
                break;
            }
        }
        best
    }
}

/// Distance from `p` to the segment from `a` to `b`. Infinite if a point is not finite.
fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let squared = along.length_squared();
    let s = if squared > 0.0 { ((p - a).dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    let distance = p.distance(a + along * s);
    if distance.is_nan() { f64::INFINITY } else { distance }
}
