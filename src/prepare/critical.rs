//! Trim arcs of a tile to critical parameters: tessellants without which coarse polylines could cross.
//!
//! If the hulls of two arcs are disjoint, so are the polylines through their ends and through any refinement of them
//! (Li et al., JCDE 13(1), 2026, lemma on critical parameters). Arcs whose hulls meet are halved until they do not.
//! Arcs that share an end are apart when the cones that they fill, seen from that end, are. Where arcs meet for good, the
//! point becomes a common one of both: the faces beyond either edge then share it, and nothing has to be split later.

use super::UvCurve;
use super::face::{DraftAlong, DraftTile, DraftUse};
use super::meeting::{Meeting, beside, meet, weld};
use super::uv_curve::SAME_SHARE;
use glam::DVec2;
use std::f64::consts::TAU;

/// Halvings of one arc. Arcs that still meet after 8 touch, to 1/256 of their length: then no finite set of points
/// keeps their polylines apart, and the trim stage resolves what crosses.
const MAX_DEPTH: u32 = 8;

/// Points of arcs looked at per tile: so many, and so many for each point that the arcs have. Real faces need up to 440 for
/// each; a crowd of overlapping loops, or noise, must not cost quadratic time.
const WORK: usize = 1 << 22;
const WORK_PER_POINT: usize = 2000;

/// Points that looking for the meeting of two stretches counts for, curved or straight.
const WORK_PER_MEETING: [usize; 2] = [1000, 10];

/// Rounds of looking for places where arcs meet, or for want of points seem to. Real faces need one; each of the others
/// halves what is left.
const ROUNDS: usize = 7;

/// Pairs of stretches for which more points are looked for. More of them run along each other.
const MAX_WANTING: usize = 64;

/// Points at which the loops of one tile meet, of those that become common points. Real faces have a handful; a crowd of
/// loops that cross each other is left to the trim stage.
const MAX_MEETINGS: usize = 2000;

/// An arc between two mandatory parameters.
pub(super) struct Arc {
    pub(super) edge: u32,
    /// Loop of the tile and use within the loop.
    pub(super) of: (usize, usize),
    pub(super) points: Vec<(f64, DVec2)>,
    low: DVec2,
    high: DVec2,
}

/// A stretch of an arc's points.
#[derive(Clone, Copy)]
pub(super) struct Span<'a> {
    pub(super) arc: &'a Arc,
    from: usize,
    to: usize,
}

/// Pairs of stretches that cannot be told apart.
type Close<'a> = Vec<(Span<'a>, Span<'a>)>;

/// What is left of the work on a tile, in points.
struct Work(usize);

impl Work {
    /// Whether there is so much left, and takes it.
    fn takes(&mut self, points: usize) -> bool {
        self.0 = self.0.saturating_sub(points);
        self.0 > 0
    }
}

/// Appends to `breaks` the parameters (edge, t) that the tile's edges must contain, and returns where its loops meet
/// themselves or each other other than at common ends: the pcurves have a common sample there now. Also whether that is all
/// of it, and not just what was found until the work was too much.
pub(super) fn critical(tile: &mut DraftTile, breaks: &mut Vec<(u32, f64)>) -> (Vec<Meeting>, bool) {
    let mut meetings = Vec::new();
    let mut more = Vec::new();
    let mut work: Option<Work> = None;
    for round in 1..=ROUNDS {
        let arcs = arcs(tile, &meetings, &more);
        let points: usize = arcs.iter().map(|a| a.points.len()).sum();
        let work = work.get_or_insert_with(|| Work(WORK + WORK_PER_POINT * points));
        let mut found = Vec::new();
        let mut close = Vec::new();
        separate_all(&arcs, &mut found, &mut close, work);
        let mut new: Vec<Meeting> = Vec::new();
        for &(a, b) in &close {
            for m in meet(tile, a, b) {
                let known = new.iter().any(|n| n.is(&m)) || meetings.iter().any(|n| n.blurs(&m, tile));
                if !known && meetings.len() + new.len() < MAX_MEETINGS {
                    new.push(m);
                }
            }
        }
        if work.0 == 0 {
            // Where so much comes near to so much, no set of points keeps it apart.
            return (meetings, false);
        }
        let between = midway(&close);
        if round == ROUNDS || (new.is_empty() && between.is_empty()) {
            breaks.extend(found);
            break;
        }
        if new.is_empty() {
            more.extend(between);
        } else {
            weld(tile, &new);
            meetings.extend(new);
            more.extend(beside(tile, &meetings));
        }
    }
    (meetings, true)
}

/// Parameters in the middle of stretches that could not be told apart for want of points, though they have no end in common.
fn midway(close: &[(Span<'_>, Span<'_>)]) -> Vec<((usize, usize), f64)> {
    let wanting = |(a, b): &&(Span<'_>, Span<'_>)| {
        let joined = a.ends().iter().any(|p| b.ends().iter().any(|q| p.distance(*q) <= SAME_SHARE));
        let curved = |s: &Span<'_>| s.arc.points.len() > 2;
        !joined && !a.can_split() && !b.can_split() && (curved(a) || curved(b))
    };
    let pairs: Vec<_> = close.iter().filter(wanting).take(MAX_WANTING + 1).collect();
    if pairs.len() > MAX_WANTING {
        return Vec::new();
    }
    let curved = pairs.into_iter().flat_map(|&(a, b)| [a, b]).filter(|s| s.arc.points.len() > 2);
    curved.map(|s| (s.arc.of, 0.5 * (s.range()[0] + s.range()[1]))).collect()
}

/// The parts of the tile's loops along edges, cut where they meet, in order of their least u. `more`: parameters at which
/// they may be cut besides samples and the middles between them.
fn arcs(tile: &DraftTile, meetings: &[Meeting], more: &[((usize, usize), f64)]) -> Vec<Arc> {
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
            arcs.extend(stops.windows(2).filter_map(|w| arc(u, (l, k), (w[0], w[1]), &more, (tile.min, scale))));
        }
    }
    arcs.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
    arcs
}

/// Separates arcs from themselves and each other; those that cannot be are appended to `close`.
fn separate_all<'a>(arcs: &'a [Arc], breaks: &mut Vec<(u32, f64)>, close: &mut Close<'a>, work: &mut Work) {
    arcs.iter().filter(|a| a.points.len() > 2).for_each(|a| separate_from_itself(a, breaks, close, work));
    for (i, a) in arcs.iter().enumerate() {
        for b in &arcs[i + 1..] {
            if b.low.x > a.high.x || work.0 == 0 {
                break;
            }
            if b.low.y > a.high.y || a.low.y > b.high.y {
                continue;
            }
            if a.points.len() == 2 && b.points.len() == 2 {
                if !a.only_joins(b) {
                    keep((Span::of(a), Span::of(b)), close, work);
                }
            } else if !a.runs_along(b) {
                separate(Span::of(a), Span::of(b), 0, breaks, close, work);
            }
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
) -> Option<Arc> {
    let (DraftAlong::Edge(edge), UvCurve::Hermite(samples)) = (u.along, &u.uv) else { return None };
    let mut ts = vec![a];
    for w in samples.windows(2) {
        ts.extend([w[0].t, 0.5 * (w[0].t + w[1].t)].into_iter().filter(|&t| t > a && t < b));
    }
    ts.push(b);
    if !more.is_empty() {
        ts.extend(more.iter().copied().filter(|&t| t > a && t < b));
        ts.sort_by(f64::total_cmp);
        ts.dedup();
    }
    let mut hint = 0;
    let mut points: Vec<(f64, DVec2)> =
        ts.into_iter().map(|t| (t, (u.uv.point(t, &mut hint) - origin) * scale)).collect();
    let (p, q) = (points[0].1, points[points.len() - 1].1);
    let chord = q - p;
    let length = chord.length();
    if length > 0.0 && points.iter().all(|x| chord.perp_dot(x.1 - p).abs() <= 1e-9 * length) {
        points = vec![points[0], points[points.len() - 1]];
    }
    let (low, high) =
        points.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(p.1), high.max(p.1)));
    Some(Arc { edge, of, points, low, high })
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
        Self { arc, from: 0, to: arc.points.len() - 1 }
    }

    fn len(&self) -> usize {
        self.to - self.from + 1
    }

    fn points(&self) -> impl Iterator<Item = DVec2> + Clone + 'a {
        self.arc.points[self.from..=self.to].iter().map(|p| p.1)
    }

    pub(super) fn ends(&self) -> [DVec2; 2] {
        [self.arc.points[self.from].1, self.arc.points[self.to].1]
    }

    /// Parameters at its ends.
    pub(super) fn range(&self) -> [f64; 2] {
        [self.arc.points[self.from].0, self.arc.points[self.to].0]
    }

    fn can_split(&self) -> bool {
        self.to - self.from >= 2
    }

    fn split(&self) -> (usize, [Self; 2]) {
        let mid = usize::midpoint(self.from, self.to);
        (mid, [Self { to: mid, ..*self }, Self { from: mid, ..*self }])
    }

    /// Largest distance of the points from the chord.
    fn fatness(&self) -> f64 {
        let [a, b] = self.ends();
        let n = (b - a).perp().normalize_or_zero();
        self.points().map(|p| n.dot(p - a).abs()).fold(0.0, f64::max)
    }
}

/// Cuts an arc where it has turned by a third of a circle; if stretches of it meet, the cuts become breaks and the
/// stretches are separated like arcs.
fn separate_from_itself<'a>(arc: &'a Arc, breaks: &mut Vec<(u32, f64)>, close: &mut Close<'a>, work: &mut Work) {
    const TURN: f64 = TAU / 3.0;
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
    let spans: Vec<Span<'a>> = cuts.windows(2).map(|w| Span { arc, from: w[0], to: w[1] }).collect();
    let pairs = || (0..spans.len()).flat_map(|i| (i + 1..spans.len()).map(move |j| (i, j)));
    if spans.len() > 64
        || !work.takes(spans.len() * arc.points.len())
        || pairs().all(|(i, j)| apart(spans[i], spans[j]))
    {
        return;
    }
    breaks.extend(cuts[1..cuts.len() - 1].iter().map(|&k| (arc.edge, arc.points[k].0)));
    for (i, j) in pairs() {
        separate(spans[i], spans[j], 0, breaks, close, work);
    }
}

/// Adds a pair to those that cannot be told apart: looking for its meeting is work to come.
fn keep<'a>(pair: (Span<'a>, Span<'a>), close: &mut Close<'a>, work: &mut Work) {
    let straight = [pair.0, pair.1].iter().all(|s| s.arc.points.len() == 2);
    if work.takes(WORK_PER_MEETING[usize::from(straight)]) {
        close.push(pair);
    }
}

/// Halves two arcs until their hulls are apart; each halving becomes a break. What cannot be told apart is `close`.
fn separate<'a>(
    a: Span<'a>,
    b: Span<'a>,
    depth: u32,
    breaks: &mut Vec<(u32, f64)>,
    close: &mut Close<'a>,
    work: &mut Work,
) {
    if !work.takes(a.len() + b.len()) || apart(a, b) {
        return;
    }
    if depth >= 2 * MAX_DEPTH {
        keep((a, b), close, work);
        return;
    }
    let (fat_a, fat_b) = (a.fatness(), b.fatness());
    let split_a = a.can_split() && (fat_a >= fat_b || !b.can_split());
    if !split_a && !b.can_split() {
        keep((a, b), close, work);
        return;
    }
    let (halved, other) = if split_a { (a, b) } else { (b, a) };
    let (mid, halves) = halved.split();
    breaks.push((halved.arc.edge, halved.arc.points[mid].0));
    for half in halves {
        separate(half, other, depth + 1, breaks, close, work);
    }
}

/// Whether a line separates two arcs, or a wedge at an end that they share.
fn apart(a: Span<'_>, b: Span<'_>) -> bool {
    let others = b.ends();
    let is_shared = |p: &DVec2| others.iter().any(|q| p.distance_squared(*q) <= SAME_SHARE * SAME_SHARE);
    let mut shared = a.ends().into_iter().filter(is_shared);
    match (shared.next(), shared.next()) {
        (None, _) => separated_by_line(a, b) || separated_by_line(b, a),
        (Some(p), None) => cones_apart(a, b, p),
        _ => false,
    }
}

/// Whether the direction across `a`'s chord, or along it, keeps the arcs apart.
fn separated_by_line(a: Span<'_>, b: Span<'_>) -> bool {
    let [p, q] = a.ends();
    let along = (q - p).normalize_or_zero();
    [along.perp(), along].into_iter().any(|n| {
        let range = |s: Span<'_>| {
            s.points().map(|x| n.dot(x)).fold((f64::INFINITY, f64::NEG_INFINITY), |r, x| (r.0.min(x), r.1.max(x)))
        };
        let (ra, rb) = (range(a), range(b));
        ra.1 < rb.0 || rb.1 < ra.0
    })
}

/// Whether the directions from `p` to the points of two arcs fill disjoint cones.
fn cones_apart(a: Span<'_>, b: Span<'_>, p: DVec2) -> bool {
    let cone = |s: Span<'_>| {
        let mut directions = s.points().map(|x| x - p).filter(|d| d.length() > SAME_SHARE);
        let first = directions.next()?;
        // Angles relative to the first direction; an arc that turns back around `p` fills everything.
        let (lo, hi) = directions.fold((0.0_f64, 0.0_f64), |r, d| {
            let angle = first.angle_to(d);
            (r.0.min(angle), r.1.max(angle))
        });
        Some((first.to_angle(), lo, hi))
    };
    let (Some((fa, la, ha)), Some((fb, lb, hb))) = (cone(a), cone(b)) else { return true };
    if ha - la > 3.0 || hb - lb > 3.0 {
        return false;
    }
    // Middle directions further apart than both half widths.
    let (ma, mb) = (fa + 0.5 * (la + ha), fb + 0.5 * (lb + hb));
    let between = (ma - mb) - TAU * ((ma - mb) / TAU).round();
    between.abs() > 0.5 * (ha - la) + 0.5 * (hb - lb)
}
