//! Trim arcs of a tile to critical parameters: tessellants without which coarse polylines could cross.
//!
//! If the hulls of two arcs' Bézier points are disjoint, so are the polylines through their ends and any points between
//! (Li et al., JCDE 13(1), 2026, lemma on critical parameters). Arcs whose hulls meet are halved until they do not.
//! Arcs that share an end are apart when the cones that they fill, seen from that end, are. Where arcs meet for good, the
//! point becomes a common one of both: the faces beyond either edge then share it, and nothing has to be split later.
//!
//! Arcs of edges in space are halved at their samples first. There the hull of points, wider by how far the cubics between
//! them bulge, bounds every polyline that a tolerance may ask for; below samples, Bézier points do. Pcurves are good to a few
//! millionths of a face, so arcs that cannot be told apart touch. Arcs of free trims are exact and meet at their ends only: they
//! are halved as far as it takes.

use super::draft::{DraftAlong, DraftTile, DraftUse};
use super::meeting::{Meeting, beside, meet, weld};
use super::uv_curve::SAME_SHARE;
use super::{UvCurve, UvSample};
use glam::DVec2;
use std::f64::consts::TAU;

/// Halvings of one arc. Arcs that still meet after 8 touch, to 1/256 of their length: then no finite set of points
/// keeps their polylines apart, and the trim stage resolves what crosses.
const MAX_DEPTH: u32 = 8;

/// Halvings of a cubic between two samples, however short it is: where an image hooks, samples are dense.
const MAX_DEPTH_BELOW: u32 = 6;

/// Halvings of one arc of a free trim: two that run side by side at a billionth of the domain are apart.
const MAX_DEPTH_EXACT: u32 = 16;

/// The same for those that touch at a common end. No edge has so many segments that it gets more points in the last ones, of
/// a 4096th of an arc, so that polylines fan out from there.
const MAX_DEPTH_TANGENT: u32 = 12;

/// Points of arcs looked at per tile: so many, and so many for each point that the arcs have. Real faces need up to 440 for
/// each; a crowd of overlapping loops, or noise, must not cost quadratic time.
const WORK: usize = 1 << 20;
const WORK_PER_POINT: usize = 1000;

/// The same for free trims: circles at a distance of 10⁻⁸ need half of it.
const WORK_EXACT: usize = 1 << 25;

/// Points that looking for the meeting of two stretches counts for, curved or straight.
const WORK_PER_MEETING: [usize; 2] = [1000, 10];

/// Rounds of looking for places where arcs meet. Real faces need one; where arcs meet, each of the others finds what the
/// one before could not tell apart from it.
const ROUNDS: usize = 7;

/// Pairs of stretches, halved below samples, of which one may still meet the other: around one crossing. More of them run along
/// each other, and halving only makes points of them.
const MAX_UNRESOLVED: usize = 4;

/// Points at which the loops of one tile meet, of those that become common points. Real faces have a handful; a crowd of
/// loops that cross each other is left to the trim stage.
const MAX_MEETINGS: usize = 2000;

/// An arc between two mandatory parameters.
pub(super) struct Arc {
    pub(super) edge: u32,
    /// Loop of the tile and use within the loop.
    pub(super) of: (usize, usize),
    pub(super) points: Vec<(f64, DVec2)>,
    /// What stands for its hull: its Bézier points, three for each of `points` but the last, or these themselves.
    hull: Vec<DVec2>,
    /// Whether it is the former.
    exact: bool,
    /// If it is the latter, and it is not straight: what lies between each of `points` and the next.
    pieces: Vec<Piece>,
    /// The largest bulge of these.
    most: f64,
    low: DVec2,
    high: DVec2,
}

/// A cubic between two points of an arc.
struct Piece {
    /// Derivatives at both ends, over its range.
    steps: [DVec2; 2],
    /// How far it may be from its chord.
    bulge: f64,
}

/// A stretch of an arc's points.
#[derive(Clone, Copy)]
pub(super) struct Span<'a> {
    pub(super) arc: &'a Arc,
    from: usize,
    to: usize,
    /// A part of the stretch between two neighbours of the arc's points.
    fine: Option<Fine>,
}

/// A stretch of a cubic.
#[derive(Clone, Copy)]
struct Fine {
    range: [f64; 2],
    hull: [DVec2; 4],
}

type Pair<'a> = (Span<'a>, Span<'a>);

/// Pairs of stretches that cannot be told apart, and the parts of them that cannot.
type Close<'a> = Vec<(Pair<'a>, Vec<Pair<'a>>)>;

/// What is left of the work on a tile, in points.
struct Work(usize);

impl Work {
    /// Whether there is so much left, and takes it.
    fn takes(&mut self, points: usize) -> bool {
        self.0 = self.0.saturating_sub(points);
        self.0 > 0
    }
}

/// What came of separating arcs.
struct Found<'a, 'w> {
    /// Edges, and parameters that they must contain.
    breaks: Vec<(u32, f64)>,
    close: Close<'a>,
    work: &'w mut Work,
}

/// Appends to `breaks` the parameters (edge, t) that the tile's edges must contain, and returns where its loops meet
/// themselves or each other other than at common ends: the pcurves have a common sample there now. Also whether that is all
/// of it, and not just what was found until the work was too much. `exact`: they are free trims, which do not meet.
pub(super) fn critical(tile: &mut DraftTile, exact: bool, breaks: &mut Vec<(u32, f64)>) -> (Vec<Meeting>, bool) {
    let mut meetings = Vec::new();
    let mut more = Vec::new();
    let mut work: Option<Work> = None;
    for round in 1..=ROUNDS {
        let arcs = arcs(tile, &meetings, &more, exact);
        let points: usize = arcs.iter().map(|a| a.points.len()).sum();
        let least = if exact { WORK_EXACT } else { WORK };
        let work = work.get_or_insert_with(|| Work(least + WORK_PER_POINT * points));
        let Found { breaks: found, close, .. } = separate_all(&arcs, work);
        if exact {
            breaks.extend(found);
            return (meetings, work.0 > 0);
        }
        let mut new: Vec<Meeting> = Vec::new();
        for (pair, parts) in &close {
            for m in meet_near(tile, *pair, parts) {
                let known =
                    new.iter().any(|n| n.is(&m) || n.blurs(&m, tile)) || meetings.iter().any(|n| n.blurs(&m, tile));
                if !known && meetings.len() + new.len() < MAX_MEETINGS {
                    new.push(m);
                }
            }
        }
        if work.0 == 0 {
            // Where so much comes near to so much, no set of points keeps it apart.
            return (meetings, false);
        }
        if round == ROUNDS || new.is_empty() {
            breaks.extend(found);
            break;
        }
        weld(tile, &new);
        meetings.extend(new);
        more.extend(beside(tile, &meetings));
    }
    (meetings, true)
}

/// Where two stretches meet: where they touch, or else where parts of them do.
fn meet_near(tile: &DraftTile, (a, b): Pair<'_>, parts: &[Pair<'_>]) -> Vec<Meeting> {
    let mut found = meet(tile, a, b);
    if !found.iter().any(|m| m.tangent) {
        found.extend(parts.iter().flat_map(|&(a, b)| meet(tile, a, b)));
    }
    found
}

/// The parts of the tile's loops along edges, cut where they meet, in order of their least u. `more`: parameters at which
/// they may be cut besides samples and the middles between them.
fn arcs(tile: &DraftTile, meetings: &[Meeting], more: &[((usize, usize), f64)], exact: bool) -> Vec<Arc> {
    let scale = (tile.max - tile.min).recip();
    let mut arcs = Vec::new();
    for (l, uses) in tile.loops.iter().enumerate() {
        for (k, u) in uses.iter().enumerate() {
            let mut stops = vec![u.from.min(u.to)];
            stops.extend(meetings.iter().flat_map(|m| m.at).filter(|at| at.0 == (l, k)).map(|at| at.1));
            stops.push(u.from.max(u.to));
            stops.sort_by(f64::total_cmp);
            stops.dedup();
            let more: Vec<f64> = more.iter().filter(|at| at.0 == (l, k)).map(|at| at.1).collect();
            arcs.extend(stops.windows(2).filter_map(|w| arc(u, (l, k), (w[0], w[1]), &more, (tile.min, scale), exact)));
        }
    }
    arcs.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
    arcs
}

/// Separates arcs from themselves and each other.
fn separate_all<'a, 'w>(arcs: &'a [Arc], work: &'w mut Work) -> Found<'a, 'w> {
    let mut found = Found { breaks: Vec::new(), close: Vec::new(), work };
    arcs.iter().filter(|a| a.points.len() > 2).for_each(|a| separate_from_itself(a, &mut found));
    for (i, a) in arcs.iter().enumerate() {
        for b in &arcs[i + 1..] {
            if b.low.x > a.high.x || found.work.0 == 0 {
                break;
            }
            if b.low.y > a.high.y || a.low.y > b.high.y {
                continue;
            }
            if a.points.len() == 2 && b.points.len() == 2 {
                if !a.exact && !a.only_joins(b) {
                    found.keep((Span::of(a), Span::of(b)), Vec::new());
                }
            } else if !a.runs_along(b) {
                separate(Span::of(a), Span::of(b), 0, &mut found);
            }
        }
    }
    found
}

impl<'a> Found<'a, '_> {
    /// Adds a pair to those that cannot be told apart, with the parts of it that cannot if these are few: looking for its meeting
    /// is work to come.
    fn keep(&mut self, pair: Pair<'a>, parts: Vec<Pair<'a>>) {
        let straight = [pair.0, pair.1].iter().all(|s| s.arc.points.len() == 2);
        let work = WORK_PER_MEETING[usize::from(straight)] * (1 + parts.len());
        if !pair.0.arc.exact && self.work.takes(work) {
            self.close.push((pair, parts));
        }
    }
}

/// Points along a use from one parameter to another, in the unit square of the tile; two for a straight one.
fn arc(
    u: &DraftUse,
    of: (usize, usize),
    (a, b): (f64, f64),
    more: &[f64],
    (origin, scale): (DVec2, DVec2),
    exact: bool,
) -> Option<Arc> {
    let (DraftAlong::Edge(edge), UvCurve::Hermite(samples)) = (u.along, &u.uv) else { return None };
    let mut ts = vec![a];
    for w in samples.windows(2) {
        // Two samples at a place say how the tangent breaks there.
        if w[1].t - w[0].t > SAME_SHARE * (b - a) {
            ts.extend([w[0].t, 0.5 * (w[0].t + w[1].t)].into_iter().filter(|&t| t > a && t < b));
        }
    }
    let middle = 0.5 * (a + b);
    if ts.len() == 1 && !exact && middle > a && middle < b {
        // Two points say nothing of what is between.
        ts.push(middle);
    }
    ts.push(b);
    if !more.is_empty() {
        ts.extend(more.iter().copied().filter(|&t| t > a && t < b));
        ts.sort_by(f64::total_cmp);
        ts.dedup();
    }
    let at = |k: usize, t: f64| UvSample::at(&samples[k], &samples[k + 1], t);
    let mut piece = 0;
    let mut hull: Vec<DVec2> = Vec::with_capacity(if exact { 3 * ts.len() } else { ts.len() });
    let mut pieces = Vec::with_capacity(if exact { 0 } else { ts.len() });
    let mut from = at(samples.partition_point(|s| s.t <= a).clamp(1, samples.len() - 1) - 1, a);
    from.uv = (from.uv - origin) * scale;
    hull.push(from.uv);
    for w in ts.windows(2) {
        while piece + 2 < samples.len() && samples[piece + 1].t <= w[0] {
            piece += 1;
        }
        if samples[piece].t == w[0] {
            // Where the tangent breaks, it is another one than before.
            from.d = samples[piece].d;
        }
        let mut to = at(piece, w[1]);
        to.uv = (to.uv - origin) * scale;
        let steps = [from.d, to.d].map(|d| d * scale * (w[1] - w[0]));
        if exact {
            hull.extend([from.uv + steps[0] / 3.0, to.uv - steps[1] / 3.0]);
        } else {
            pieces.push(Piece { steps, bulge: bulge([from.uv, to.uv], steps) });
        }
        hull.push(to.uv);
        from = to;
    }
    let step = if exact { 3 } else { 1 };
    let mut points: Vec<(f64, DVec2)> = ts.iter().zip(hull.iter().step_by(step)).map(|(&t, &p)| (t, p)).collect();
    let (p, q) = (points[0].1, points[points.len() - 1].1);
    let chord = q - p;
    let length = chord.length();
    if length > 0.0 && hull.iter().all(|x| chord.perp_dot(*x - p).abs() <= 1e-9 * length) {
        points = vec![points[0], points[points.len() - 1]];
        hull = if exact { vec![p, p, q, q] } else { vec![p, q] };
        pieces.clear();
    }
    let (low, high) =
        hull.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    let most = pieces.iter().fold(0.0, |most, s| s.bulge.max(most));
    Some(Arc {
        edge,
        of,
        points,
        hull,
        exact,
        pieces,
        most,
        low: low - DVec2::splat(most),
        high: high + DVec2::splat(most),
    })
}

/// How far a cubic may be from its chord at most; `steps` are its derivatives at both ends.
fn bulge([p, q]: [DVec2; 2], steps: [DVec2; 2]) -> f64 {
    let chord = q - p;
    let [a, b] = steps.map(|step| step - chord);
    // Two thirds of what its inner Bézier points are off the chord's own, and no more than three quarters of the farther one.
    0.25 * a.length_squared().max(b.length_squared()).sqrt()
}

impl Arc {
    /// Whether two straight arcs that have an end in common, to the bit, meet nowhere else.
    fn only_joins(&self, other: &Self) -> bool {
        let ([p, q], [r, s]) = (Span::of(self).ends(), Span::of(other).ends());
        let (d, e) = (q - p, s - r);
        (p == r || p == s || q == r || q == s) && d.perp_dot(e).abs() > SAME_SHARE * d.length() * e.length()
    }

    /// Whether both are the same stretch of one edge: there and back, or a loop given twice. Their polylines are one.
    fn runs_along(&self, other: &Self) -> bool {
        let ends = |a: &Self| [a.points[0], a.points[a.points.len() - 1]];
        self.edge == other.edge && ends(self) == ends(other)
    }
}

impl<'a> Span<'a> {
    fn of(arc: &'a Arc) -> Self {
        Self { arc, from: 0, to: arc.points.len() - 1, fine: None }
    }

    fn len(&self) -> usize {
        self.points().len()
    }

    /// Points whose hull contains it, or stands for one that does.
    fn points(&self) -> &[DVec2] {
        let step = if self.arc.exact { 3 } else { 1 };
        self.fine.as_ref().map_or(&self.arc.hull[step * self.from..=step * self.to], |fine| &fine.hull)
    }

    pub(super) fn ends(&self) -> [DVec2; 2] {
        let points = self.points();
        [points[0], points[points.len() - 1]]
    }

    /// Parameters at its ends.
    pub(super) fn range(&self) -> [f64; 2] {
        self.fine.map_or([self.arc.points[self.from].0, self.arc.points[self.to].0], |fine| fine.range)
    }

    fn can_split(&self) -> bool {
        self.to - self.from >= 2 || (self.arc.exact && self.is_curved())
    }

    fn is_curved(&self) -> bool {
        self.arc.points.len() > 2
    }

    /// The cubics between its points; none where it is one of them, straight, or exact.
    fn pieces(&self) -> &'a [Piece] {
        if self.fine.is_some() { &[] } else { self.arc.pieces.get(self.from..self.to).unwrap_or(&[]) }
    }

    /// How far it may be from the hull of its points.
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

    /// A stretch between two neighbouring points by its Bézier points; any other as it is.
    fn by_cubic(self) -> Self {
        if self.to - self.from == 1 { self.cubic(0).unwrap_or(self) } else { self }
    }

    /// The least and largest coordinate of its points along `n`.
    fn range_along(&self, n: DVec2) -> (f64, f64) {
        let points = self.points().iter().map(|x| n.dot(*x));
        points.fold((f64::INFINITY, f64::NEG_INFINITY), |r, x| (r.0.min(x), r.1.max(x)))
    }

    /// The same of a cubic itself: what its Bézier points have beyond it would have to be halved away.
    fn exact_range_along(&self, n: DVec2) -> (f64, f64) {
        let Some(fine) = &self.fine else {
            let ((low, high), bulge) = (self.range_along(n), self.bulge());
            return (low - bulge, high + bulge);
        };
        let c = fine.hull.map(|x| n.dot(x));
        let [x, y] = turns(c);
        (c[0].min(c[3]).min(x).min(y), c[0].max(c[3]).max(x).max(y))
    }

    /// Whether it may be halved below samples: as far as one arc is halved, or [`MAX_DEPTH_BELOW`] times.
    fn can_be_halved(&self) -> bool {
        let [a, b] = self.range();
        let width = |from: usize, to: usize| self.arc.points[to].0 - self.arc.points[from].0;
        let least = (width(0, self.arc.points.len() - 1) / f64::from(1 << MAX_DEPTH))
            .min(width(self.from, self.to) / f64::from(1 << MAX_DEPTH_BELOW));
        let mid = 0.5 * (a + b);
        self.is_curved() && b - a > least && mid > a && mid < b
    }

    /// Its halves, and the parameter between them.
    fn split(&self) -> (f64, [Self; 2]) {
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

    /// Whether another arc, which is not longer, lies on the side to which this one is hollow. Halving this one takes its chord
    /// away from there; halving the other changes nothing between them.
    fn has_inside(&self, other: Self) -> bool {
        let middle = |s: &Self| s.fine.map(|fine| fine.hull[1].midpoint(fine.hull[2]));
        let (Some(here), Some(there)) = (middle(self), middle(&other)) else { return false };
        let ([a, b], [c, d]) = (self.ends(), other.ends());
        let across = (b - a).perp();
        c.distance(d) <= 2.0 * a.distance(b) && across.dot(here - a) * across.dot(there - here) < 0.0
    }

    /// Largest distance of the points from the chord; of a closed free trim's from its end.
    fn fatness(&self) -> f64 {
        let [a, b] = self.ends();
        let off = |p: &DVec2| match (b - a).perp().try_normalize() {
            Some(n) => n.dot(*p - a).abs(),
            None if self.arc.exact => p.distance(a),
            None => 0.0,
        };
        self.points().iter().map(off).fold(0.0, f64::max)
    }
}

/// Cuts an arc where it has turned by a third of a circle; if stretches of it meet, the cuts become breaks and the
/// stretches are separated like arcs.
fn separate_from_itself<'a>(arc: &'a Arc, found: &mut Found<'a, '_>) {
    const TURN: f64 = TAU / 3.0;
    let most = if arc.exact { 512 } else { 64 };
    let mut cuts = vec![0];
    let mut start: Option<DVec2> = None;
    for (k, w) in arc.points.windows(2).enumerate() {
        let direction = w[1].1 - w[0].1;
        let from = *start.get_or_insert(direction);
        if from.angle_to(direction).abs() > TURN {
            cuts.push(k);
            start = Some(direction);
        }
    }
    cuts.push(arc.points.len() - 1);
    cuts.dedup();
    let spans: Vec<Span<'a>> = cuts.windows(2).map(|w| Span { arc, from: w[0], to: w[1], fine: None }).collect();
    let pairs = || (0..spans.len()).flat_map(|i| (i + 1..spans.len()).map(move |j| (i, j)));
    if spans.len() > most
        || !found.work.takes(spans.len() * arc.points.len())
        || pairs().all(|(i, j)| apart(spans[i], spans[j], shared_ends(spans[i], spans[j])))
    {
        return;
    }
    found.breaks.extend(cuts[1..cuts.len() - 1].iter().map(|&k| (arc.edge, arc.points[k].0)));
    for (i, j) in pairs() {
        separate(spans[i], spans[j], 0, found);
    }
}

/// Halves two arcs until their hulls are apart; each halving becomes a break. What cannot be told apart is close.
fn separate<'a>(a: Span<'a>, b: Span<'a>, depth: u32, found: &mut Found<'a, '_>) {
    let shared = shared_ends(a, b);
    if !found.work.takes(a.len() + b.len()) || apart(a, b, shared) {
        return;
    }
    let most = match (a.arc.exact, shared[0]) {
        (false, _) => MAX_DEPTH,
        (true, None) => MAX_DEPTH_EXACT,
        (true, Some(_)) => MAX_DEPTH_TANGENT,
    };
    let (fat_a, fat_b) = (a.fatness(), b.fatness());
    let split_a = a.can_split() && (fat_a >= fat_b || !b.can_split());
    if depth >= 2 * most || (!split_a && !b.can_split()) {
        separate_below_samples(a, b, found);
        return;
    }
    let (halved, other) = if split_a { (a, b) } else { (b, a) };
    let (mid, halves) = halved.split();
    found.breaks.push((halved.arc.edge, mid));
    for half in halves {
        separate(half, other, depth + 1, found);
    }
}

/// The same for arcs of edges in space that cannot be halved at samples. Where they run along each other, nothing is gained by
/// breaks, and the two are close as they are.
fn separate_below_samples<'a>(a: Span<'a>, b: Span<'a>, found: &mut Found<'a, '_>) {
    if a.arc.exact || (!a.is_curved() && !b.is_curved()) {
        found.keep((a, b), Vec::new());
        return;
    }
    let before = found.breaks.len();
    let mut left = Vec::new();
    halve([a.by_cubic(), b.by_cubic()], &mut left, found);
    if left.is_empty() {
        return;
    }
    found.breaks.truncate(before);
    // Arcs that touch at a common end are not apart however often they are halved.
    left.retain(|(a, b)| shared_ends(*a, *b)[0].is_none());
    if left.len() > MAX_UNRESOLVED {
        left.clear();
    }
    found.keep((a, b), left);
}

/// Halves cubics until their hulls are apart. Those that are not are `left`; halving ends when these are too many.
fn halve<'a>([a, b]: [Span<'a>; 2], left: &mut Vec<Pair<'a>>, found: &mut Found<'a, '_>) {
    let shared = shared_ends(a, b);
    let done = left.len() > MAX_UNRESOLVED || !found.work.takes(a.len() + b.len());
    if done || if shared[0].is_none() { exactly_apart(a, b) } else { apart(a, b, shared) } {
        return;
    }
    let can_split = [a, b].map(|s| s.can_be_halved());
    if can_split == [false; 2] {
        left.push((a, b));
        return;
    }
    let hollow = [shared[0].is_none() && a.has_inside(b), shared[0].is_none() && b.has_inside(a)];
    let first = if can_split == [true; 2] && hollow[0] == hollow[1] {
        a.fatness() >= b.fatness()
    } else {
        can_split[0] && (hollow[0] || !can_split[1])
    };
    let (halved, other) = if first { (a, b) } else { (b, a) };
    let (mid, halves) = halved.split();
    found.breaks.push((halved.arc.edge, mid));
    for half in halves {
        halve([half.by_cubic(), other], left, found);
    }
}

/// Points at which two arcs both end: of free trims, to the bit.
fn shared_ends(a: Span<'_>, b: Span<'_>) -> [Option<DVec2>; 2] {
    let others = b.ends();
    let near = if a.arc.exact { 0.0 } else { SAME_SHARE * SAME_SHARE };
    let mut shared = a.ends().into_iter().filter(|p| others.iter().any(|q| p.distance_squared(*q) <= near));
    [shared.next(), shared.next()]
}

/// Whether a line separates two arcs, or a wedge at an end that they share.
fn apart(a: Span<'_>, b: Span<'_>, shared: [Option<DVec2>; 2]) -> bool {
    match shared {
        [None, _] => separated_by_line(a, b) || separated_by_line(b, a),
        [Some(p), None] => cones_apart(a, b, p),
        _ => false,
    }
}

/// Whether the direction across `a`'s chord, or along it, keeps the arcs apart.
fn separated_by_line(a: Span<'_>, b: Span<'_>) -> bool {
    directions(a).into_iter().any(|n| {
        let (ra, rb) = (a.range_along(n), b.range_along(n));
        let apart = (rb.0 - ra.1).max(ra.0 - rb.1);
        apart > 0.0 && (apart > a.arc.most + b.arc.most || apart > a.bulge() + b.bulge())
    })
}

/// The same of cubics themselves, for either's chord.
fn exactly_apart(a: Span<'_>, b: Span<'_>) -> bool {
    [a, b].into_iter().flat_map(directions).any(|n| {
        let (ra, rb) = (a.exact_range_along(n), b.exact_range_along(n));
        ra.1 < rb.0 || rb.1 < ra.0
    })
}

fn directions(s: Span<'_>) -> [DVec2; 2] {
    let [p, q] = s.ends();
    let along = (q - p).normalize_or_zero();
    [along.perp(), along]
}

/// Values of a cubic, given by its Bézier coefficients, where it turns between its ends.
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

/// Whether the directions from `p`, where both end, to the points of two arcs fill disjoint cones.
fn cones_apart(a: Span<'_>, b: Span<'_>, p: DVec2) -> bool {
    let (Some((fa, la, ha)), Some((fb, lb, hb))) = (cone(a.by_cubic(), p), cone(b.by_cubic(), p)) else { return true };
    if ha - la > 3.0 || hb - lb > 3.0 {
        return false;
    }
    // Middle directions further apart than both half widths.
    let (ma, mb) = (fa + 0.5 * (la + ha), fb + 0.5 * (lb + hb));
    let between = (ma - mb) - TAU * ((ma - mb) / TAU).round();
    between.abs() > 0.5 * (ha - la) + 0.5 * (hb - lb)
}

/// Directions from `p` in which an arc that ends there is seen: one of them, and the least and largest angle from it; none if
/// all of the arc is at `p`.
fn cone(s: Span<'_>, p: DVec2) -> Option<(f64, f64, f64)> {
    let points = s.points();
    let mut first: Option<DVec2> = None;
    let (mut low, mut high, mut wider) = (0.0_f64, 0.0_f64, 0.0_f64);
    // Of directions within a right angle of the first, the outermost; of others their angles. An arc that turns back around `p`
    // fills everything.
    let mut outermost = [DVec2::ZERO; 2];
    let mut see = |d: DVec2| {
        let first = *first.get_or_insert_with(|| {
            outermost = [d; 2];
            d
        });
        if first.dot(d) <= 0.0 {
            let angle = first.angle_to(d);
            (low, high) = (low.min(angle), high.max(angle));
        } else if outermost[0].perp_dot(d) < 0.0 {
            outermost[0] = d;
        } else if outermost[1].perp_dot(d) > 0.0 {
            outermost[1] = d;
        }
    };
    let pieces = s.pieces();
    let mut near = f64::INFINITY;
    for (k, x) in points.iter().enumerate() {
        let length = (*x - p).length();
        if length > SAME_SHARE {
            see(*x - p);
        }
        // The piece between this point and the one before: beside `p` by its Bézier points, elsewhere by how far it bulges.
        if let Some(piece) = k.checked_sub(1).and_then(|before| pieces.get(before)) {
            let least = near.min(length);
            if least > SAME_SHARE {
                wider = wider.max(piece.bulge / least);
            } else if let Some(Fine { hull, .. }) = s.cubic(k - 1).and_then(|cubic| cubic.fine) {
                hull[1..3].iter().map(|q| *q - p).filter(|d| d.length() > SAME_SHARE).for_each(&mut see);
            }
        }
        near = length;
    }
    let first = first?;
    let [low, high] = [low.min(first.angle_to(outermost[0])), high.max(first.angle_to(outermost[1]))];
    // Twice the sine is more than the angle.
    let wider = if wider < 0.5 { 2.0 * wider } else { TAU };
    Some((first.to_angle(), low - wider, high + wider))
}
