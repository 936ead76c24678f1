//! Two curves in space -> the stretches along which they coincide within a tolerance, whatever their parameters,
//! degrees, knots and directions; a pcurve in the parameter of one -> the same pcurve in the parameter of the other.
//!
//! A stretch ends where one of the curves ends, or at a knot beyond which they part. Between two such places the curves
//! coincide if points of each have feet on the other that are near, inside, and in order. Curves with the same control
//! points need no feet: they are nowhere further apart than their control points.
//!
//! A parameter of the other curve corresponds to the foot of its point. Cubics between these are halved until they fit.

use crate::math::boxes::{Aabb, Tree, around, distance_squared};
use crate::math::solve::{equal_pieces, foot};
use crate::model::{Edge, NurbsCurve3};
use crate::prepare::surface::decompose::BezierSpline3;
use crate::prepare::uv::uv_curve::{SampledCurve, UvSample};
use glam::{DVec3, DVec4};
use std::sync::OnceLock;

/// Largest tolerance, as a share of the shorter curve's length: a larger one would merge neighbours.
const SHORT: f64 = 0.125;

/// Minimum samples per Bézier piece and per curve from which a foot is searched.
const SEEDS: usize = 4;
const LEAST_SEEDS: usize = 16;

/// Share of a curve's length within which its ends coincide, and control points are the same.
const ROUNDING: f64 = 1e-9;

/// Newton's method stops at steps of this share of the distance between seeds.
const CONVERGED: f64 = 1e-12;

/// Sine of the angle above which curves cross rather than run along each other.
const ACROSS: f64 = 0.1;

/// Minimum points per Bézier piece and per stretch whose feet are checked.
const PLACES: usize = 3;
const LEAST_PLACES: usize = 5;

/// An edge's curve over its range, with samples for nearest-point queries.
pub(crate) struct CurveQuery {
    spline: BezierSpline3,
    /// The box around the control points.
    hull: Aabb,
    /// Made at the first query. Curves with the same control points are compared without them.
    seeds: OnceLock<Seeds>,
}

/// Samples of a curve.
struct Seeds {
    /// Parameters and points, in order.
    all: Vec<(f64, DVec3)>,
    /// Their points. Neighbours along the curve are near each other.
    tree: Tree<Aabb>,
    /// Length of the polyline through them.
    length: f64,
}

impl Seeds {
    fn of(spline: &BezierSpline3) -> Self {
        let each = SEEDS.max(LEAST_SEEDS.div_ceil(spline.segments()));
        let ts = equal_pieces(&spline.breaks, each).chain([spline.range().1]);
        let mut all: Vec<(f64, DVec3)> = Vec::with_capacity(each * spline.segments() + 1);
        all.extend(ts.map(|t| (t, spline.point(t))));
        let length = all.windows(2).map(|w| w[0].1.distance(w[1].1)).sum();
        let leaves = all.iter().map(|seed| [seed.1; 2]).collect();
        Self { tree: Tree::new(leaves, |of| around(of.as_flattened().iter().copied())), all, length }
    }
}

/// A stretch that two curves have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Overlap {
    /// From and to, in the first curve's parameter; increasing.
    pub(crate) a: [f64; 2],
    /// The same places in the second curve's: decreasing if it runs the other way.
    pub(crate) b: [f64; 2],
    /// Largest distance between the two.
    pub(crate) width: f64,
}

impl CurveQuery {
    /// The curve of a sound edge.
    pub(crate) fn new(edge: &Edge) -> Self {
        Self::over(&edge.curve, edge.range)
    }

    pub(crate) fn over(curve: &NurbsCurve3, range: (f64, f64)) -> Self {
        let spline = BezierSpline3::new(curve, range);
        let hull = around(spline.control.iter().map(|c| c.truncate() / c.w));
        Self { spline, hull, seeds: OnceLock::new() }
    }

    fn seeds(&self) -> &Seeds {
        self.seeds.get_or_init(|| Seeds::of(&self.spline))
    }

    /// Its length, along chords.
    pub(crate) fn length(&self) -> f64 {
        self.seeds().length
    }

    pub(crate) fn range(&self) -> [f64; 2] {
        self.spline.range().into()
    }

    pub(crate) fn point(&self, t: f64) -> DVec3 {
        self.spline.point(t)
    }

    /// Points along it, ends included.
    pub(crate) fn samples(&self) -> impl Iterator<Item = DVec3> {
        self.seeds().all.iter().map(|seed| seed.1)
    }

    pub(crate) fn slope(&self, t: f64) -> DVec3 {
        let [_, slope] = self.spline.tangent(t);
        slope
    }

    /// The parameter of the point nearest to `p`, and its distance.
    pub(crate) fn foot(&self, p: DVec3) -> (f64, f64) {
        let Seeds { all, tree, length } = self.seeds();
        let (k, last) = (tree.nearest(|node| distance_squared(*node, p)), all.len() - 1);
        let found = self.foot_from(k, p);
        // A closed curve is as near at its end as at its start.
        let closed = || all[0].1.distance(all[last].1) <= ROUNDING * length;
        if (k == 0 || k == last) && closed() {
            let other = self.foot_from(last - k, p);
            return if other.1 < found.1 { other } else { found };
        }
        found
    }

    /// The foot between the neighbours of seed `k`.
    fn foot_from(&self, k: usize, p: DVec3) -> (f64, f64) {
        let seeds = &self.seeds().all;
        let (low, high) = (seeds[k.saturating_sub(1)].0, seeds[(k + 1).min(seeds.len() - 1)].0);
        let (seed, point) = seeds[k];
        let t = foot(seed, (low, high), CONVERGED * (high - low), |t| {
            let [point, slope] = self.spline.tangent(t);
            let square = slope.length_squared();
            [(point - p).dot(slope), square, square]
        });
        let (off, off_seed) = (self.point(t).distance(p), point.distance(p));
        if off < off_seed { (t, off) } else { (seed, off_seed) }
    }

    /// Whether the curve between two parameters is no more than a point.
    pub(crate) fn one_place(&self, s: f64, t: f64, tolerance: f64) -> bool {
        let [p, q, middle] = [s, t, 0.5 * (s + t)].map(|t| self.point(t));
        s == t || p.distance(q) <= 2.0 * tolerance && middle.distance(p) <= 2.0 * tolerance
    }

    /// Parameters strictly between two others: the knots, and evenly spaced ones in each Bézier piece.
    fn places(&self, from: f64, to: f64) -> Vec<f64> {
        let mut stops = vec![from];
        let margin = 1e-9 * (to - from);
        let breaks = &self.spline.breaks;
        let first = breaks.partition_point(|&t| t <= from + margin);
        stops.extend(breaks[first..].iter().copied().take_while(|&t| t < to - margin));
        stops.push(to);
        let each = PLACES.max(LEAST_PLACES.div_ceil(stops.len() - 1)) + 1;
        equal_pieces(&stops, each).skip(1).collect()
    }

    /// Largest distance between the control points of both curves, and whether they are in opposite order. `None` if
    /// degrees, knots or weights differ, or if the distance exceeds `tolerance`.
    fn same_net(&self, other: &Self, tolerance: f64) -> Option<(f64, bool)> {
        let [a, b] = [&self.spline, &other.spline];
        if a.degree != b.degree || a.segments() != b.segments() {
            return None;
        }
        let share = |s: &BezierSpline3, k: usize| {
            let (from, to) = s.range();
            (s.breaks[k] - from) / (to - from)
        };
        let distance = |(p, q): (DVec4, DVec4)| (p.truncate() / p.w).distance(q.truncate() / q.w);
        [false, true].into_iter().find_map(|against| {
            let (last, count) = (a.segments(), a.control.len());
            let pair = |k: usize| (a.control[k], b.control[if against { count - 1 - k } else { k }]);
            // Most curves that are compared start elsewhere.
            if distance(pair(0)) > tolerance {
                return None;
            }
            let alike = (0..=last).all(|k| {
                let of_b = if against { 1.0 - share(b, last - k) } else { share(b, k) };
                (share(a, k) - of_b).abs() <= 1e-12
            });
            if !alike {
                return None;
            }
            // Weights may differ by a factor per piece. If their ratios differ, so do the parameters.
            let per = a.degree + 1;
            let ratios_alike = (0..count).all(|k| {
                let ((p, q), (p0, q0)) = (pair(k), pair(k - k % per));
                (p.w * q0.w - q.w * p0.w).abs() <= 1e-12 * (p.w * q0.w).abs()
            });
            let off = (0..count).map(pair).map(distance).fold(0.0, f64::max);
            (ratios_alike && off <= tolerance).then_some((off, against))
        })
    }

    /// The stretches in common with another curve that are longer than 4 tolerances. The tolerance is at most an eighth
    /// of either curve's length.
    pub(crate) fn common(&self, other: &Self, tolerance: f64) -> Vec<Overlap> {
        let tolerance = tolerance.min(SHORT * self.length().min(other.length()));
        if let Some((width, against)) = self.same_net(other, tolerance) {
            let [from, to] = other.range();
            let b = if against { [to, from] } else { [from, to] };
            return vec![Overlap { a: self.range(), b, width }];
        }
        let mut marks: Vec<f64> = Vec::new();
        self.mark(other, &self.range(), &other.range(), tolerance, &mut marks);
        let Some(&first) = marks.first() else { return Vec::new() };
        if marks.iter().all(|&t| self.one_place(first, t, tolerance)) && self.crosses(other, first) {
            return Vec::new();
        }
        let inner = |s: &BezierSpline3| s.breaks[1..s.segments()].to_vec();
        self.mark(other, &inner(&self.spline), &inner(&other.spline), tolerance, &mut marks);
        marks.sort_by(f64::total_cmp);
        let end = self.range()[1];
        marks.dedup_by(|t, before| {
            let one = self.one_place(*before, *t, tolerance);
            if one && *t == end {
                *before = end;
            }
            one
        });
        let mut out: Vec<Overlap> = Vec::new();
        for w in marks.windows(2) {
            let Some(found) = self.coincides(other, [w[0], w[1]], tolerance) else { continue };
            let along = |s: &Overlap| s.b[1] > s.b[0];
            match out.last_mut() {
                Some(before)
                    if before.a[1] == found.a[0]
                        && along(before) == along(&found)
                        && other.one_place(before.b[1], found.b[0], tolerance) =>
                {
                    (before.a[1], before.b[1]) = (found.a[1], found.b[1]);
                    before.width = before.width.max(found.width);
                }
                _ => out.push(found),
            }
        }
        out
    }

    /// Whether another curve crosses this one at a common point.
    fn crosses(&self, other: &Self, at: f64) -> bool {
        let (a, b) = (self.slope(at), other.slope(other.foot(self.point(at)).0));
        a.cross(b).length() > ACROSS * a.length() * b.length()
    }

    /// Appends the parameters `own`, and the feet of `of_other`, at which the other curve is within `tolerance`.
    fn mark(&self, other: &Self, own: &[f64], of_other: &[f64], tolerance: f64, marks: &mut Vec<f64>) {
        marks.extend(own.iter().copied().filter(|&t| other.near_foot(self.point(t), tolerance).is_some()));
        marks.extend(of_other.iter().filter_map(|&t| self.near_foot(other.point(t), tolerance)));
    }

    /// The parameter of the point nearest to `p`, if it is within `tolerance`.
    fn near_foot(&self, p: DVec3, tolerance: f64) -> Option<f64> {
        /// Multiple of the tolerance beyond which nothing of the curve is near. More than 1, for rounding.
        const ROOM: f64 = 1.001;
        // Most points are far off. The curve lies in the box.
        if distance_squared(self.hull, p).sqrt() > ROOM * tolerance {
            return None;
        }
        let (foot, off) = self.foot(p);
        (off <= tolerance).then_some(foot)
    }

    /// The stretch between two parameters, if the curves coincide there.
    fn coincides(&self, other: &Self, a: [f64; 2], tolerance: f64) -> Option<Overlap> {
        let places = self.places(a[0], a[1]);
        let mut width = 0.0_f64;
        let mut feet = Vec::with_capacity(places.len() + 2);
        for &t in &places {
            let (foot, off) = other.foot(self.point(t));
            if off > tolerance {
                return None;
            }
            width = width.max(off);
            feet.push(foot);
        }
        let rising = feet[feet.len() - 1] > feet[0];
        let ends = other.range();
        let end = |t: f64, inner: f64, before: bool| -> Option<f64> {
            let p = self.point(t);
            // The ends of a closed curve are one point; take the end that this side runs to.
            let own = ends.into_iter().filter(|&s| other.point(s).distance(p) <= 2.0 * tolerance);
            let foot = Some(other.foot(p)).filter(|f| f.1 <= tolerance).map(|f| f.0);
            let foot = foot.filter(|&f| ends.iter().all(|&s| !other.one_place(s, f, tolerance)));
            let on_side = own.chain(foot).filter(|&s| s != inner && (s < inner) == (before == rising));
            on_side.min_by(|s, t| (s - inner).abs().total_cmp(&(t - inner).abs()))
        };
        let from = end(a[0], feet[0], true)?;
        let to = end(a[1], feet[feet.len() - 1], false)?;
        feet.insert(0, from);
        feet.push(to);
        if !feet.windows(2).all(|w| (w[1] > w[0]) == rising && w[0] != w[1]) {
            return None;
        }
        // The feet of the other curve's points must lie inside, too.
        for w in feet.windows(2) {
            let (back, off) = self.foot(other.point(0.5 * (w[0] + w[1])));
            if off > tolerance || back <= a[0] || back >= a[1] {
                return None;
            }
            width = width.max(off);
        }
        let length: f64 = feet.windows(2).map(|w| other.point(w[0]).distance(other.point(w[1]))).sum();
        (length > 4.0 * tolerance).then_some(Overlap { a, b: [from, to], width })
    }
}

/// Tolerance of the cubic pieces, as a share of the pcurve's extent.
const FIT: f64 = 1e-8;

/// Maximum halvings between two samples.
const MAX_DEPTH: u32 = 7;

/// Reparametrizes a pcurve from the curve `own` to `kept`, which coincides with it within `width`; `against`: in the
/// opposite direction. The ends keep their (u,v) to the bit.
pub(crate) fn carry(
    samples: &[UvSample],
    own: &CurveQuery,
    kept: &CurveQuery,
    against: bool,
    width: f64,
) -> Vec<UvSample> {
    let ([a, b], [from, to]) = (own.range(), kept.range());
    let is_same = |tolerance: f64| own.same_net(kept, tolerance).is_some_and(|(_, turned)| turned == against);
    if is_same(width) || is_same(width + ROUNDING * own.length()) {
        // The parameters differ by a linear map only.
        let rate = (to - from) / (b - a) * if against { -1.0 } else { 1.0 };
        let [at_a, at_b] = if against { [to, from] } else { [from, to] };
        let moved = |s: &UvSample| {
            let t = match s.t {
                t if t == a => at_a,
                t if t == b => at_b,
                t => at_a + (t - a) * rate,
            };
            UvSample { t, uv: s.uv, d: s.d / rate }
        };
        let mut out: Vec<UvSample> = samples.iter().map(moved).collect();
        if against {
            out.reverse();
        }
        return out;
    }
    let [at_from, at_to] = if against { [b, a] } else { [a, b] };
    let sample = |t: f64| {
        let foot = match t {
            _ if t == from => at_from,
            _ if t == to => at_to,
            _ => own.foot(kept.point(t)).0,
        };
        let there = UvSample::on(samples, foot);
        let (of_own, of_kept) = (own.slope(foot), kept.slope(t));
        UvSample { t, uv: there.uv, d: there.d * (of_kept.dot(of_own) / of_own.length_squared()) }
    };
    let [low, high] = around(samples.iter().map(|s| s.uv));
    let mut stops = vec![from, to];
    stops.extend(samples[1..samples.len() - 1].iter().map(|s| kept.foot(own.point(s.t)).0));
    stops.retain(|&t| t >= from && t <= to);
    stops.sort_by(f64::total_cmp);
    stops.dedup_by(|t, before| *t - *before <= 1e-9 * (to - from));
    if let Some(last) = stops.last_mut() {
        *last = to;
    }
    let curve = SampledCurve {
        sample,
        place: |t| (t, sample(t).uv),
        tolerance: FIT * (high - low).length(),
        max_depth: MAX_DEPTH,
    };
    let mut out = vec![sample(from)];
    for w in stops.windows(2) {
        let before = out[out.len() - 1];
        curve.follow([w[0], w[1]], [&before, &sample(w[1])], 0, &mut out);
    }
    straighten(samples, &mut out);
    out
}

/// Replaces slopes that are not finite, where one of the curves has no speed, by those of the chords. Along a line of
/// constant parameter, limits slopes that would make cubics turn back.
fn straighten(stated: &[UvSample], samples: &mut [UvSample]) {
    let constants = UvSample::constants(stated);
    let chord = |a: &UvSample, b: &UvSample| (b.uv - a.uv) / (b.t - a.t);
    let last = samples.len() - 1;
    for k in 0..=last {
        let beside = [k.saturating_sub(1), k].map(|k| k.min(last - 1));
        let chords = beside.map(|k| chord(&samples[k], &samples[k + 1]));
        let s = &mut samples[k];
        if !s.d.is_finite() {
            s.d = 0.5 * (chords[0] + chords[1]);
        }
        for axis in 0..2 {
            if let Some(constant) = constants[axis] {
                (s.uv[axis], s.d[axis]) = (constant, 0.0);
            } else if constants[1 - axis].is_some() {
                // Fritsch & Carlson's bound for monotone cubics.
                let [c, d] = chords.map(|c| c[axis]);
                let most = 3.0 * c.abs().min(d.abs());
                s.d[axis] = if c * d <= 0.0 { 0.0 } else { (s.d[axis] * c.signum()).clamp(0.0, most) * c.signum() };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn far_points_have_no_feet_and_near_ones_those_of_the_search() {
        let points = (0..8).map(|k| DVec3::new(f64::from(k), (1.7 * f64::from(k)).sin(), 0.2 * f64::from(k)));
        let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 5.0, 5.0];
        let curve = NurbsCurve3 { degree: 3, knots: knots.to_vec(), points: points.collect(), weights: Vec::new() };
        let query = CurveQuery::over(&curve, (0.0, 5.0));
        for (k, tolerance) in (0..400).zip([0.01, 0.3, 2.0].into_iter().cycle()) {
            let turn = DVec2::from_angle(f64::from(k));
            let p = query.point(0.0125 * f64::from(k)) + 0.5 * DVec3::new(turn.x, turn.y, turn.x * turn.y);
            let (foot, off) = query.foot(p);
            assert_eq!(query.near_foot(p, tolerance), (off <= tolerance).then_some(foot));
            let [point, slope] = query.spline.tangent(foot);
            let all = query.spline.derivatives(foot);
            assert_eq!([point, slope], [all.point, all.d1]);
        }
    }
}
