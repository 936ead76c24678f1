//! Stretches of pcurves -> bounds of every polyline through their points, and whether two stretches are disjoint.
//!
//! A stretch of several samples is bounded by their hull, widened by the bulge of the cubics between them. A stretch of
//! one cubic is bounded by its Bézier points, or by its exact extent across a line.

use super::draft::{DraftAlong, DraftUse};
use crate::math::boxes::around;
use crate::math::lanes::{larger, smaller};
use crate::prepare::uv::uv_curve::{SAME_SHARE, UvCurve, UvSample};
use glam::DVec2;
use smallvec::SmallVec;
use std::f64::consts::TAU;

/// Maximum halvings of one arc. Arcs that still meet after 8 touch, to 1/256 of their length. Then no finite set of
/// points keeps their polylines apart, and the trim stage resolves crossings.
pub(crate) const MAX_DEPTH: u32 = 8;

/// Maximum halvings of a cubic between two samples. Arcs side by side, two micrometres apart, take two. Arcs that
/// barely touch take all, and each adds a point to an edge: with 6, an assembly of 12 532 sound faces has 7 % more
/// triangles.
const MAX_DEPTH_BELOW: u32 = 3;

/// An arc between two mandatory parameters.
pub(crate) struct PcurveArc {
    pub(crate) edge: u32,
    /// Loop of the tile and use within the loop.
    pub(crate) of: (usize, usize),
    pub(crate) points: SmallVec<[(f64, DVec2); 2]>,
    /// Points that bound it. If `exact`, Bézier points, three for each of `points` but the last; otherwise `points`.
    hull: SmallVec<[DVec2; 2]>,
    /// Whether `hull` holds Bézier points: the arc is of a free trim.
    pub(crate) exact: bool,
    /// The cubics between consecutive `points`; empty if `exact` or straight.
    pieces: Vec<ArcPiece>,
    /// The largest bulge of `pieces`.
    most: f64,
    pub(crate) low: DVec2,
    pub(crate) high: DVec2,
}

/// A cubic between two points of an arc.
pub(crate) struct ArcPiece {
    /// Derivatives at both ends, times the length of its range.
    steps: [DVec2; 2],
    /// Upper bound of its distance from the chord.
    bulge: f64,
}

/// A stretch of an arc's points.
#[derive(Clone, Copy)]
pub(crate) struct ArcSpan<'a> {
    pub(crate) arc: &'a PcurveArc,
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// Set if it is a part of the cubic between two neighbouring points.
    pub(crate) fine: Option<Fine>,
}

/// A stretch of a cubic.
#[derive(Clone, Copy)]
pub(crate) struct Fine {
    range: [f64; 2],
    hull: [DVec2; 4],
}

/// The arc of a use between two parameters, in the unit square of the tile; two points if it is straight. `more`:
/// further parameters to split at. `None` for borders and isoparametric pcurves.
pub(crate) fn arc(
    u: &DraftUse,
    of: (usize, usize),
    (a, b): (f64, f64),
    more: &[f64],
    (origin, scale): (DVec2, DVec2),
    exact: bool,
) -> Option<PcurveArc> {
    let (DraftAlong::Edge(edge), UvCurve::Hermite(samples)) = (u.along, &u.uv) else { return None };
    let middle = 0.5 * (a + b);
    let mut points: Vec<(f64, DVec2)> = Vec::with_capacity(2 * samples.len() + more.len());
    let mut stop = |t: f64| points.push((t, DVec2::ZERO));
    stop(a);
    for w in samples.windows(2) {
        // Two samples at one place mark a break of the tangent.
        if w[1].t - w[0].t > SAME_SHARE * (b - a) {
            [w[0].t, 0.5 * (w[0].t + w[1].t)].into_iter().filter(|&t| t > a && t < b).for_each(&mut stop);
        }
    }
    if points.len() == 1 && !exact && middle > a && middle < b {
        // Two points would look like a straight line.
        points.push((middle, DVec2::ZERO));
    }
    points.push((b, DVec2::ZERO));
    if !more.is_empty() {
        points.extend(more.iter().filter(|&&t| t > a && t < b).map(|&t| (t, DVec2::ZERO)));
        points.sort_by(|p, q| p.0.total_cmp(&q.0));
        points.dedup_by_key(|p| p.0);
    }
    let at = |k: usize, t: f64| UvSample::at(&samples[k], &samples[k + 1], t);
    let mut piece = 0;
    let mut hull: Vec<DVec2> = Vec::with_capacity(if exact { 3 * points.len() } else { points.len() });
    let mut pieces = Vec::with_capacity(if exact { 0 } else { points.len() });
    let mut from = at(samples.partition_point(|s| s.t <= a).clamp(1, samples.len() - 1) - 1, a);
    from.uv = (from.uv - origin) * scale;
    points[0].1 = from.uv;
    hull.push(from.uv);
    for k in 1..points.len() {
        let ends = [points[k - 1].0, points[k].0];
        while piece + 2 < samples.len() && samples[piece + 1].t <= ends[0] {
            piece += 1;
        }
        if samples[piece].t == ends[0] {
            // The tangent may break here.
            from.d = samples[piece].d;
        }
        let next = samples[piece + 1];
        let mut to = if next.t == ends[1] { next } else { at(piece, ends[1]) };
        to.uv = (to.uv - origin) * scale;
        let steps = [from.d, to.d].map(|d| d * scale * (ends[1] - ends[0]));
        if exact {
            hull.extend([from.uv + steps[0] / 3.0, to.uv - steps[1] / 3.0]);
        } else {
            pieces.push(ArcPiece { steps, bulge: bulge([from.uv, to.uv], steps) });
        }
        points[k].1 = to.uv;
        hull.push(to.uv);
        from = to;
    }
    let (p, q) = (points[0].1, points[points.len() - 1].1);
    let chord = q - p;
    let length = chord.length();
    if length > 0.0 && hull.iter().all(|x| chord.perp_dot(*x - p).abs() <= SAME_SHARE * length) {
        points.drain(1..points.len() - 1);
        hull.clear();
        let twice = if exact { 2 } else { 1 };
        hull.extend([p, q].into_iter().flat_map(|end| std::iter::repeat_n(end, twice)));
        pieces.clear();
    }
    let [low, high] = around(hull.iter().copied());
    let most = pieces.iter().fold(0.0, |most, s| s.bulge.max(most));
    Some(PcurveArc {
        edge,
        of,
        points: points.into(),
        hull: hull.into(),
        exact,
        pieces,
        most,
        low: low - DVec2::splat(most),
        high: high + DVec2::splat(most),
    })
}

/// Upper bound of the distance between a cubic and its chord; `steps` are its derivatives at both ends.
fn bulge([p, q]: [DVec2; 2], steps: [DVec2; 2]) -> f64 {
    let chord = q - p;
    let [a, b] = steps.map(|step| step - chord);
    // The inner Bézier points are off the chord's own by a third of `a` and `b`, and their weights sum to at most 3/4.
    0.25 * a.length_squared().max(b.length_squared()).sqrt()
}

impl PcurveArc {
    /// Whether two straight arcs share an end, to the bit, and meet nowhere else.
    pub(crate) fn only_joins(&self, other: &Self) -> bool {
        let ([p, q], [r, s]) = (ArcSpan::of(self).ends(), ArcSpan::of(other).ends());
        let (d, e) = (q - p, s - r);
        (p == r || p == s || q == r || q == s) && d.perp_dot(e).abs() > SAME_SHARE * d.length() * e.length()
    }

    /// Whether both are the same stretch of one edge, used there and back or by a repeated loop: one polyline.
    pub(crate) fn runs_along(&self, other: &Self) -> bool {
        let ends = |a: &Self| [a.points[0], a.points[a.points.len() - 1]];
        self.edge == other.edge && ends(self) == ends(other)
    }
}

impl<'a> ArcSpan<'a> {
    pub(crate) fn of(arc: &'a PcurveArc) -> Self {
        Self { arc, from: 0, to: arc.points.len() - 1, fine: None }
    }

    pub(crate) fn len(&self) -> usize {
        self.points().len()
    }

    /// Points whose hull contains it once widened by its [`bulge`](Self::bulge).
    fn points(&self) -> &[DVec2] {
        let step = if self.arc.exact { 3 } else { 1 };
        self.fine.as_ref().map_or(&self.arc.hull[step * self.from..=step * self.to], |fine| &fine.hull)
    }

    /// From its first point to its last.
    pub(crate) fn chord(&self) -> DVec2 {
        let [first, last] = self.ends();
        last - first
    }

    pub(crate) fn ends(&self) -> [DVec2; 2] {
        let points = self.points();
        [points[0], points[points.len() - 1]]
    }

    /// Parameters at its ends.
    pub(crate) fn range(&self) -> [f64; 2] {
        self.fine.map_or([self.arc.points[self.from].0, self.arc.points[self.to].0], |fine| fine.range)
    }

    pub(crate) fn can_split(&self) -> bool {
        self.to - self.from >= 2 || (self.arc.exact && self.is_curved())
    }

    pub(crate) fn is_curved(&self) -> bool {
        self.arc.points.len() > 2
    }

    /// The cubics between its points; empty if it is a part of one of them, straight, or exact.
    fn pieces(&self) -> &'a [ArcPiece] {
        if self.fine.is_some() { &[] } else { self.arc.pieces.get(self.from..self.to).unwrap_or(&[]) }
    }

    /// Upper bound of its distance from the hull of its points.
    fn bulge(&self) -> f64 {
        self.pieces().iter().fold(0.0, |most, piece| piece.bulge.max(most))
    }

    /// The piece after its point `k`, by its Bézier points.
    fn cubic(&self, k: usize) -> Option<Self> {
        let steps = self.pieces().get(k)?.steps;
        let from = self.from + k;
        let [(a, p), (b, q)] = [from, from + 1].map(|k| self.arc.points[k]);
        let hull = [p, p + steps[0] / 3.0, q - steps[1] / 3.0, q];
        Some(Self { from, to: from + 1, fine: Some(Fine { range: [a, b], hull }), ..*self })
    }

    /// A stretch between two neighbouring points as a cubic by its Bézier points; any other stretch unchanged.
    pub(crate) fn by_cubic(self) -> Self {
        if self.to - self.from == 1 { self.cubic(0).unwrap_or(self) } else { self }
    }

    /// The least and largest coordinate of its points along `n`.
    fn range_along(&self, n: DVec2) -> (f64, f64) {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for x in self.points().iter().map(|x| n.dot(*x)) {
            (low, high) = (smaller(x, low), larger(x, high));
        }
        (low, high)
    }

    /// The same of a cubic itself. Its Bézier points extend beyond it, which would take more halvings.
    fn exact_range_along(&self, n: DVec2) -> (f64, f64) {
        let Some(fine) = &self.fine else {
            let ((low, high), bulge) = (self.range_along(n), self.bulge());
            return (low - bulge, high + bulge);
        };
        let c = fine.hull.map(|x| n.dot(x));
        let ends = (c[0].min(c[3]), c[0].max(c[3]));
        if c[1].min(c[2]) >= ends.0 && c[1].max(c[2]) <= ends.1 {
            return ends;
        }
        let [x, y] = turns(c);
        (ends.0.min(x).min(y), ends.1.max(x).max(y))
    }

    /// The same of its samples, which lie on it; of a stretch without pieces, all of it.
    fn sampled_along(&self, n: DVec2) -> (f64, f64) {
        if self.pieces().is_empty() { self.exact_range_along(n) } else { self.range_along(n) }
    }

    /// The largest coordinate along `n` of all cubics between its points. `sampled`: that of its samples.
    fn most_along(&self, n: DVec2, sampled: f64) -> f64 {
        let cubics = (0..self.pieces().len()).filter_map(|k| self.cubic(k));
        cubics.fold(sampled, |most, cubic| most.max(cubic.exact_range_along(n).1))
    }

    /// Whether a line along its chord separates it from another stretch.
    pub(super) fn is_beyond(&self, other: Self) -> bool {
        let n = directions(*self)[0];
        let (here, there) = (self.sampled_along(n), other.sampled_along(n));
        // Where samples overlap, the stretches do. Elsewhere only the sides that face each other can meet.
        let (n, here, there) = if here.1 < there.0 {
            (n, here.1, there.0)
        } else if there.1 < here.0 {
            (-n, -here.0, -there.1)
        } else {
            return false;
        };
        self.most_along(n, here) < -other.most_along(-n, -there)
    }

    /// Its point at a parameter, on a chord between two of its points.
    pub(super) fn at(&self, t: f64) -> DVec2 {
        let points = &self.arc.points[self.from..=self.to];
        let k = points.partition_point(|p| p.0 <= t).clamp(1, points.len() - 1);
        let [(a, p), (b, q)] = [points[k - 1], points[k]];
        p.lerp(q, (t - a) / (b - a))
    }

    /// The parameter of its nearest point to `x`, on chords between its points times `size`, and the distance. Where it
    /// is within `same` of one of these, the parameter of that one: other halvings end there, too. `None` at its ends.
    pub(super) fn nearest(&self, x: DVec2, size: DVec2, same: f64) -> Option<(f64, f64)> {
        let [from, to] = self.range();
        let (mut at, mut least) = (from, f64::INFINITY);
        for w in self.arc.points[self.from..=self.to].windows(2) {
            let [(a, p), (b, q)] = [w[0], w[1]].map(|(t, p)| (t, p * size));
            let chord = q - p;
            let share = ((x - p).dot(chord) / chord.length_squared()).clamp(0.0, 1.0);
            let foot = p.lerp(q, share);
            let distance = x.distance(foot);
            if distance < least {
                let nearer = if share < 0.5 { (a, p) } else { (b, q) };
                let end = Some(nearer).filter(|end| end.1.distance(foot) < same);
                (at, least) = (end.map_or(a + share * (b - a), |end| end.0), distance);
            }
        }
        (at > from && at < to).then_some((at, least))
    }

    /// Whether it may be halved further below samples: up to [`MAX_DEPTH_BELOW`] times.
    pub(crate) fn can_be_halved(&self) -> bool {
        let [a, b] = self.range();
        let width = self.arc.points[self.to].0 - self.arc.points[self.from].0;
        let least = width / f64::from(1 << MAX_DEPTH_BELOW);
        let mid = 0.5 * (a + b);
        self.is_curved() && b - a > least && mid > a && mid < b
    }

    /// Its halves, and the parameter between them.
    pub(crate) fn split(&self) -> (f64, [Self; 2]) {
        if self.to - self.from >= 2 {
            let mid = usize::midpoint(self.from, self.to);
            return (self.arc.points[mid].0, [Self { to: mid, ..*self }, Self { from: mid, ..*self }]);
        }
        let [a, b] = self.range();
        let mid = 0.5 * (a + b);
        let points = self.points();
        let [p, q, r, s] = [points[0], points[1], points[2], points[3]];
        let [pq, qr, rs] = [p.midpoint(q), q.midpoint(r), r.midpoint(s)];
        let [pqr, qrs] = [pq.midpoint(qr), qr.midpoint(rs)];
        let middle = pqr.midpoint(qrs);
        let half = |range, hull| Self { fine: Some(Fine { range, hull }), ..*self };
        (mid, [half([a, mid], [p, pq, pqr, middle]), half([mid, b], [middle, qrs, rs, s])])
    }

    /// Whether another arc, at most twice as long, lies on the concave side of this one. Halving this one moves its
    /// chord away from there; halving the other changes nothing between them.
    pub(crate) fn has_inside(&self, other: Self) -> bool {
        if self.arc.exact || !self.is_curved() {
            return false;
        }
        let middle = |s: &Self| match s.fine {
            Some(fine) => fine.hull[1].midpoint(fine.hull[2]),
            None => s.points()[s.len() / 2],
        };
        let (here, there) = (middle(self), middle(&other));
        let ([a, b], [c, d]) = (self.ends(), other.ends());
        let across = (b - a).perp();
        c.distance(d) <= 2.0 * a.distance(b) && across.dot(here - a) * across.dot(there - here) < 0.0
    }

    /// Largest distance of the points from the chord; for a closed free trim, from its end.
    pub(crate) fn fatness(&self) -> f64 {
        let [a, b] = self.ends();
        let off = |p: &DVec2| match (b - a).perp().try_normalize() {
            Some(n) => n.dot(*p - a).abs(),
            None if self.arc.exact => p.distance(a),
            None => 0.0,
        };
        self.points().iter().map(off).fold(0.0, f64::max)
    }
}

/// Points at which two arcs both end. Those of free trims must be equal to the bit.
pub(crate) fn shared_ends(a: ArcSpan<'_>, b: ArcSpan<'_>) -> [Option<DVec2>; 2] {
    let others = b.ends();
    let near = if a.arc.exact { 0.0 } else { SAME_SHARE * SAME_SHARE };
    let mut shared = a.ends().into_iter().filter(|p| others.iter().any(|q| p.distance_squared(*q) <= near));
    [shared.next(), shared.next()]
}

/// Whether a line separates two arcs or, if they share one end, whether their cones from there are disjoint.
pub(crate) fn apart(a: ArcSpan<'_>, b: ArcSpan<'_>, shared: [Option<DVec2>; 2]) -> bool {
    match shared {
        [None, _] => separated_by_line(a, b) || separated_by_line(b, a),
        [Some(p), None] => cones_apart(a, b, p),
        _ => false,
    }
}

/// Whether the arcs' extents across `a`'s chord, or along it, are disjoint.
fn separated_by_line(a: ArcSpan<'_>, b: ArcSpan<'_>) -> bool {
    directions(a).into_iter().any(|n| {
        let (ra, rb) = (a.range_along(n), b.range_along(n));
        let apart = (rb.0 - ra.1).max(ra.0 - rb.1);
        apart > 0.0 && (apart > a.arc.most + b.arc.most || apart > a.bulge() + b.bulge())
    })
}

/// The same of cubics themselves, for either's chord.
pub(crate) fn exactly_apart(a: ArcSpan<'_>, b: ArcSpan<'_>) -> bool {
    [a, b].into_iter().flat_map(directions).any(|n| {
        let (ra, rb) = (a.exact_range_along(n), b.exact_range_along(n));
        ra.1 < rb.0 || rb.1 < ra.0
    })
}

fn directions(s: ArcSpan<'_>) -> [DVec2; 2] {
    let [p, q] = s.ends();
    let along = (q - p).normalize_or_zero();
    [along.perp(), along]
}

/// Values of a cubic, given by its Bézier coefficients, at its extremes between the ends.
fn turns(c: [f64; 4]) -> [f64; 2] {
    // A third of the derivative by s: d0 + 2 s q + s² p.
    let [d0, d1, d2] = [c[1] - c[0], c[2] - c[1], c[3] - c[2]];
    let (p, q) = (d0 - 2.0 * d1 + d2, d1 - d0);
    let root = (q * q - p * d0).max(0.0).sqrt();
    let far = -(q + root.copysign(q));
    [far / p, d0 / far].map(|s| {
        let s = if s > 0.0 && s < 1.0 { s } else { 0.0 };
        let r = 1.0 - s;
        c[0] * (r * r * r) + c[1] * (3.0 * r * r * s) + c[2] * (3.0 * r * s * s) + c[3] * (s * s * s)
    })
}

/// Whether two arcs that end at `p` lie in disjoint cones from there.
///
/// The cones of arcs of edges contain samples only. The cones of all points would touch however often they are halved,
/// if two arcs leave `p` in one direction but are apart beyond it.
fn cones_apart(a: ArcSpan<'_>, b: ArcSpan<'_>, p: DVec2) -> bool {
    if on_both_sides(a, b, p) {
        return true;
    }
    let (Some((fa, la, ha)), Some((fb, lb, hb))) = (cone(a, p), cone(b, p)) else { return true };
    if ha - la > 3.0 || hb - lb > 3.0 {
        return false;
    }
    // Middle directions further apart than both half widths.
    let (ma, mb) = (fa + 0.5 * (la + ha), fb + 0.5 * (lb + hb));
    let between = (ma - mb) - TAU * ((ma - mb) / TAU).round();
    between.abs() > 0.5 * (ha - la) + 0.5 * (hb - lb)
}

/// Whether the line through `p` across the bisector of both arcs keeps them well apart. Most corners need no angles.
fn on_both_sides(a: ArcSpan<'_>, b: ArcSpan<'_>, p: DVec2) -> bool {
    /// Least sine of angles to the line. Cones on both sides are narrower than the widest that count.
    const CLEAR: f64 = 0.1;
    // Towards the first point that is not at `p`.
    let first = |s: &ArcSpan<'_>| s.points().iter().map(|x| *x - p).find(|d| d.length() > SAME_SHARE);
    let (Some(d), Some(e)) = (first(&a), first(&b)) else { return false };
    let Some(across) = (d / d.length() - e / e.length()).try_normalize() else { return false };
    let is_clear = |d: DVec2, side: DVec2| {
        let (rise, length) = (side.dot(d), d.length());
        rise > CLEAR * length || length <= SAME_SHARE
    };
    a.points().iter().all(|x| is_clear(*x - p, across)) && b.points().iter().all(|x| is_clear(*x - p, -across))
}

/// Directions from `p` to the points of an arc that ends there: the angle of one of them, and the least and largest
/// angle from it. `None` if all points are at `p`.
fn cone(s: ArcSpan<'_>, p: DVec2) -> Option<(f64, f64, f64)> {
    let mut first: Option<DVec2> = None;
    // The outermost directions as the first one sees them, each with what increases with its angle.
    let (mut low, mut high) = ((DVec2::X, 0.0), (DVec2::X, 0.0));
    for d in s.points().iter().map(|x| *x - p).filter(|d| d.length() > SAME_SHARE) {
        // Angles relative to the first direction; an arc that turns back around `p` fills everything.
        let zero = *first.get_or_insert(d);
        let seen = DVec2::new(zero.dot(d), zero.perp_dot(d));
        let rise = seen.y / (seen.x.abs() + seen.y.abs());
        let order = if seen.x < 0.0 { 2.0_f64.copysign(rise) - rise } else { rise };
        if order < low.1 {
            low = (seen, order);
        }
        if order > high.1 {
            high = (seen, order);
        }
    }
    let angle = |d: DVec2| libm::atan2(d.y, d.x);
    first.map(|zero| (angle(zero), angle(low.0), angle(high.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;

    #[test]
    fn arcs_on_both_sides_of_a_line_have_disjoint_cones() {
        let mut draw = SplitMix(4);
        let mut count = 0;
        for _ in 0..2000 {
            let p = DVec2::new(draw.unit(), draw.unit());
            let mut chain = |points: usize| {
                let towards = DVec2::from_angle(draw.range(0.0, TAU));
                let mut place = |k: usize| p + (towards * k as f64 + 0.3 * DVec2::from_angle(draw.range(0.0, TAU)));
                let hull: SmallVec<[DVec2; 2]> = (0..points).map(|k| if k == 0 { p } else { place(k) }).collect();
                let points = hull.iter().enumerate().map(|(k, uv)| (k as f64, *uv)).collect();
                let [low, high] = around(hull.iter().copied());
                PcurveArc { edge: 0, of: (0, 0), points, hull, exact: false, pieces: Vec::new(), most: 0.0, low, high }
            };
            let (a, b) = (chain(2), chain(4));
            let [a, b] = [ArcSpan::of(&a), ArcSpan::of(&b)];
            if on_both_sides(a, b, p) {
                let [(fa, la, ha), (fb, lb, hb)] = [a, b].map(|arc| cone(arc, p).expect("points"));
                let (ma, mb) = (fa + 0.5 * (la + ha), fb + 0.5 * (lb + hb));
                let between = (ma - mb) - TAU * ((ma - mb) / TAU).round();
                assert!(ha - la <= 3.0 && hb - lb <= 3.0);
                assert!(between.abs() > 0.5 * (ha - la) + 0.5 * (hb - lb));
                count += 1;
            }
        }
        assert!((500..2000).contains(&count), "{count}");
    }

    #[test]
    fn one_cubic_is_a_chord_only_if_it_is_straight() {
        let at = |t: f64, x: f64, slope: f64| UvSample { t, uv: DVec2::new(x, 1.0), d: DVec2::new(4.0, slope) };
        for (slopes, count) in [([0.0, 0.0], 2), ([1e-10, -1e-10], 2), ([1e-3, -1e-3], 3)] {
            // At uneven speed, and cut within the cubic.
            let uv = UvCurve::Hermite([at(0.0, 0.0, slopes[0]), at(2.0, 5.0, slopes[1])].into());
            for (from, to) in [(0.0, 2.0), (0.5, 1.5)] {
                let used = DraftUse { along: DraftAlong::Edge(3), from: to, to: from, uv: uv.clone() };
                let made = arc(&used, (0, 1), (from, to), &[], (DVec2::ZERO, DVec2::ONE), false).expect("an edge");
                assert_eq!(
                    (made.points.len(), made.pieces.len()),
                    (count, if count == 2 { 0 } else { 2 }),
                    "{slopes:?}"
                );
                let ends = [made.points[0].0, made.points[count - 1].0];
                assert_eq!(
                    (ends, made.low.x, made.most > 0.0),
                    ([from, to], made.points[0].1.x - made.most, count > 2)
                );
            }
        }
    }
}
