//! Trim arcs of a tile -> critical parameters: tessellants without which coarse polylines could cross.
//!
//! If the hulls of two arcs' Bézier points are disjoint, so are the polylines through their ends and any points
//! between (Li et al., JCDE 13(1), 2026, lemma on critical parameters). Arcs whose hulls meet are halved until they do
//! not. Arcs that share an end are apart if their cones from that end are disjoint. Where arcs really meet, the point
//! becomes a common point of both: the faces beyond either edge then share it, and nothing has to be split later.
//!
//! Arcs of edges in space are first halved at their samples. There the hull of points, widened by the bulge of the
//! cubics between them, bounds every polyline that a tolerance may ask for. Below samples, Bézier points do. Pcurves
//! are accurate to a few millionths of a face, so arcs that cannot be separated touch. Arcs of free trims are exact and
//! meet at their ends only, so they are halved as often as it takes.

use super::arcs::{ArcSpan, MAX_DEPTH, PcurveArc, apart, arc, exactly_apart, shared_ends};
use super::draft::DraftTile;
use super::meeting::{Meeting, WorkLeft, beside, by_use, chords_meet, meet, weld};
use glam::DVec2;
use smallvec::{SmallVec, smallvec};

/// Maximum halvings of one arc of a free trim. They separate arcs side by side, a billionth of the domain apart.
const MAX_DEPTH_EXACT: u32 = 16;

/// The same for arcs that touch at a common end. No edge has enough segments for more points in the last pieces, a
/// 4096th of an arc, so polylines fan out from there.
const MAX_DEPTH_TANGENT: u32 = 12;

/// Budget of arc points visited per tile: a constant, plus so many per point of the arcs. Real faces need up to 440 per
/// point. A crowd of overlapping loops, or noise, must not cost quadratic time.
const WORK: usize = 1 << 19;
const WORK_PER_POINT: usize = 1000;

/// Halving two arcs may take one of so many shares of the budget that is left. Then one alone is tried.
const SHARE_OF_BOTH: usize = 4;
/// The same for the attempt to halve one alone.
const SHARE_ALONE: usize = 8;

/// The constant for free trims: circles at a distance of 10⁻⁸ need half of it.
const WORK_EXACT: usize = 1 << 25;

/// Charge to the budget for finding the meeting of two stretches: if one is curved, or both are straight.
const WORK_PER_MEETING: [usize; 2] = [1000, 10];

/// Maximum breaks from separating arcs, per use of an edge. Three arcs side by side, a thousandth of their length
/// apart, ask for 750. Noise asks for tens of thousands, and every one is a point of an edge.
const MAX_BREAKS: usize = 512;

/// Maximum rounds of finding places where arcs meet. Real faces need one. Where arcs meet, each further round finds
/// meetings that the previous one could not separate. No file of the corpus needs a fourth.
const ROUNDS: usize = 3;

/// Maximum pairs of stretches that may still meet after halving below samples: those around one crossing. Arcs with
/// more pairs run along each other, and halving only adds points.
const MAX_UNRESOLVED: usize = 4;

/// Maximum meetings of a tile's loops that become common points. Real faces have a handful. A crowd of loops that cross
/// each other is left to the trim stage.
const MAX_MEETINGS: usize = 2000;

/// The same per use of an edge. More meetings cannot be distinguished.
const MAX_MEETINGS_PER_USE: usize = 32;

/// Maximum pairs of stretches of a tile that are kept to find their meetings. Few pairs lead to each of
/// [`MAX_MEETINGS`]; a crowd of edges on top of each other has a quadratic number.
const MAX_CLOSE: usize = 1 << 15;

/// Maximum comparisons of boxes per arc, of a tile's arcs on average.
const MAX_BOXES_PER_ARC: usize = 4096;

type Pair<'a> = (ArcSpan<'a>, ArcSpan<'a>);

/// Pairs of stretches that cannot be separated, each with its parts that cannot.
type UnresolvedPairs<'a> = Vec<(Pair<'a>, Vec<Pair<'a>>)>;

/// Result of separating arcs.
struct Separation<'a, 'w> {
    /// Edges, and parameters that they must contain.
    breaks: Vec<(u32, f64)>,
    /// Maximum number of breaks.
    most: usize,
    /// Further breaks, next to those of the opposite edge. They separate nothing, and are left out where there are
    /// many.
    opposite: Vec<(u32, f64)>,
    /// Size of the tile, by which its unit square is scaled.
    size: DVec2,
    close: UnresolvedPairs<'a>,
    work: &'w mut WorkLeft,
}

/// Appends to `breaks` the parameters (edge, t) that the tile's edges must contain.
///
/// Returns where loops meet themselves or each other, other than at common ends, and gives both pcurves a common sample
/// there. Also returns whether the search was complete rather than stopped by its budget. `exact`: the loops are free
/// trims, which do not meet.
pub(crate) fn critical(tile: &mut DraftTile, exact: bool, breaks: &mut Vec<(u32, f64)>) -> (Vec<Meeting>, bool) {
    let mut meetings = Vec::new();
    let mut more = Vec::new();
    let mut work: Option<WorkLeft> = None;
    let uses: usize = tile.loops.iter().map(Vec::len).sum();
    for round in 1..=ROUNDS {
        let arcs = arcs(tile, &meetings, &more, exact);
        let points: usize = arcs.iter().map(|a| a.points.len()).sum();
        let least = if exact { WORK_EXACT } else { WORK };
        let work = work.get_or_insert_with(|| WorkLeft(least + WORK_PER_POINT * points));
        let Separation { breaks: found, close, .. } = separate_all(&arcs, MAX_BREAKS * uses, tile.max - tile.min, work);
        if exact {
            breaks.extend(found);
            return (meetings, work.0 > 0);
        }
        let mut new: Vec<Meeting> = Vec::new();
        for (pair, parts) in &close {
            if meetings.len() + new.len() >= MAX_MEETINGS {
                break;
            }
            for m in meet_near(tile, *pair, parts) {
                let known =
                    new.iter().any(|n| n.is(&m) || n.blurs(&m, tile)) || meetings.iter().any(|n| n.blurs(&m, tile));
                if !known && meetings.len() + new.len() < MAX_MEETINGS {
                    new.push(m);
                }
            }
        }
        if work.0 == 0 || meetings.len() + new.len() > MAX_MEETINGS_PER_USE * uses {
            // No set of points separates arcs in such a crowd.
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

/// Where two stretches meet. Unless they touch side by side, also where parts of them meet.
fn meet_near(tile: &DraftTile, (a, b): Pair<'_>, parts: &[Pair<'_>]) -> Vec<Meeting> {
    let mut found = meet(tile, a, b);
    if !found.iter().any(|m| m.tangent) {
        found.extend(parts.iter().flat_map(|&(a, b)| meet(tile, a, b)));
    }
    found
}

/// The parts of the tile's loops along edges, cut where they meet, in order of their least u. `more`: parameters at
/// which they may be halved, besides samples and the middles between them.
fn arcs(tile: &DraftTile, meetings: &[Meeting], more: &[((usize, usize), f64)], exact: bool) -> Vec<PcurveArc> {
    let scale = (tile.max - tile.min).recip();
    let (met, more) = (by_use(meetings.iter().flat_map(|m| m.at)), by_use(more.iter().copied()));
    let mut arcs = Vec::new();
    for (l, uses) in tile.loops.iter().enumerate() {
        for (k, u) in uses.iter().enumerate() {
            let mut stops: SmallVec<[f64; 4]> = smallvec![u.from.min(u.to)];
            stops.extend(met.get(&(l, k)).into_iter().flatten().copied());
            stops.push(u.from.max(u.to));
            stops.sort_by(f64::total_cmp);
            stops.dedup();
            let more = more.get(&(l, k)).map_or(&[][..], Vec::as_slice);
            arcs.extend(stops.windows(2).filter_map(|w| arc(u, (l, k), (w[0], w[1]), more, (tile.min, scale), exact)));
        }
    }
    arcs.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
    arcs
}

/// Separates arcs from themselves and each other, those of edges in space with at most `most` breaks. `size`: of the
/// tile.
fn separate_all<'a, 'w>(arcs: &'a [PcurveArc], most: usize, size: DVec2, work: &'w mut WorkLeft) -> Separation<'a, 'w> {
    let most = if arcs.iter().any(|a| a.exact) { usize::MAX } else { most };
    let mut found = Separation { breaks: Vec::new(), most, opposite: Vec::new(), size, close: Vec::new(), work };
    arcs.iter().filter(|a| a.points.len() > 2).for_each(|a| separate_from_itself(a, &mut found));
    let mut boxes = MAX_BOXES_PER_ARC * arcs.len();
    for (i, a) in arcs.iter().enumerate() {
        for b in &arcs[i + 1..] {
            boxes = boxes.saturating_sub(1);
            if boxes == 0 {
                found.work.0 = 0;
            }
            if b.low.x > a.high.x || found.work.0 == 0 {
                break;
            }
            if b.low.y > a.high.y || a.low.y > b.high.y {
                continue;
            }
            if a.points.len() == 2 && b.points.len() == 2 {
                let pair = (ArcSpan::of(a), ArcSpan::of(b));
                let may_meet = !a.exact && !a.only_joins(b) && !a.runs_along(b);
                if may_meet && !chords_meet(pair.0, pair.1).is_empty() {
                    found.keep(pair, Vec::new());
                }
            } else if !a.runs_along(b) {
                separate_by_few(ArcSpan::of(a), ArcSpan::of(b), &mut found);
            }
        }
    }
    if found.breaks.len() + found.opposite.len() <= found.most {
        found.breaks.append(&mut found.opposite);
    }
    found
}

impl<'a> Separation<'a, '_> {
    /// Halves a stretch, and adds a break there.
    fn halve(&mut self, span: &ArcSpan<'a>) -> [ArcSpan<'a>; 2] {
        let (mid, halves) = span.split();
        self.breaks.push((span.arc.edge, mid));
        halves
    }

    /// [`separate`] with one of `shares` of the budget that is left. Whether that was enough.
    fn separate_within(&mut self, [a, b]: [ArcSpan<'a>; 2], shares: usize) -> bool {
        let kept = self.work.0 - self.work.0 / shares;
        self.work.0 -= kept;
        separate(a, b, 0, self);
        let is_enough = self.work.0 > 0;
        self.work.0 += kept;
        is_enough
    }

    /// Whether there are more breaks than may be.
    fn is_full(&self) -> bool {
        self.breaks.len() > self.most
    }

    /// Adds a pair that cannot be separated, with its parts that cannot, and charges the budget for finding its
    /// meeting. Skips free trims.
    fn keep(&mut self, pair: Pair<'a>, parts: Vec<Pair<'a>>) {
        let straight = [pair.0, pair.1].iter().all(|s| s.arc.points.len() == 2);
        let work = WORK_PER_MEETING[usize::from(straight)] * (1 + parts.len());
        if !pair.0.arc.exact && self.work.takes(work) {
            self.close.push((pair, parts));
            if self.close.len() >= MAX_CLOSE {
                self.work.0 = 0;
            }
        }
    }
}

/// Cuts an arc where it has turned by a third of a circle. If its stretches meet, the cuts become breaks, and the
/// stretches are separated like arcs.
fn separate_from_itself<'a>(arc: &'a PcurveArc, found: &mut Separation<'a, '_>) {
    /// Cosine of a third of a turn.
    const COSINE: f64 = -0.5;
    let most = if arc.exact { 512 } else { 64 };
    let mut cuts: SmallVec<[usize; 8]> = smallvec![0];
    let mut start: Option<DVec2> = None;
    for (k, w) in arc.points.windows(2).enumerate() {
        let direction = w[1].1 - w[0].1;
        let from = *start.get_or_insert(direction);
        let lengths = (from.length_squared() * direction.length_squared()).sqrt();
        if from.dot(direction) / lengths <= COSINE {
            cuts.push(k);
            start = Some(direction);
        }
    }
    cuts.push(arc.points.len() - 1);
    cuts.dedup();
    let spans: SmallVec<[ArcSpan<'a>; 4]> =
        cuts.windows(2).map(|w| ArcSpan { arc, from: w[0], to: w[1], fine: None }).collect();
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
    if found.is_full() {
        found.work.0 = 0;
    }
}

/// Separates two arcs. If that takes halvings of both, tries halvings of one alone, which may be fewer: of two arcs
/// side by side, chords of the inner one never come near the outer one. If it takes too many breaks of both, and of
/// each alone, nothing of the budget is left.
fn separate_by_few<'a>(a: ArcSpan<'a>, b: ArcSpan<'a>, found: &mut Separation<'a, '_>) {
    let (before, close) = (found.breaks.len(), found.close.len());
    let may_be_alone = !a.arc.exact && a.arc.edge != b.arc.edge;
    // Halving both may take long where halving one does not.
    let is_done = found.separate_within([a, b], if may_be_alone { SHARE_OF_BOTH } else { 1 }) || !may_be_alone;
    let is_full = found.is_full();
    let by_both = found.breaks.split_off(before);
    let on = |s: ArcSpan<'a>| by_both.iter().any(|&(edge, _)| edge == s.arc.edge);
    let may_be_fewer = may_be_alone && (is_full || !is_done || found.close.len() == close && on(a) && on(b));
    let is_usable = is_done && !is_full;
    let mut most = if is_usable { by_both.len() } else { found.most - before };
    let mut fewest = is_usable.then_some(by_both);
    for (halved, other) in [(a, b), (b, a)] {
        if may_be_fewer {
            let mut alone = Vec::with_capacity(most);
            // A long search for fewer breaks must not end that for meetings.
            let mut share = WorkLeft(if is_full { found.work.0 } else { found.work.0 / SHARE_ALONE });
            let given = share.0;
            if separate_alone(halved, other, &mut alone, most, &mut share) {
                most = alone.len();
                fewest = Some(alone);
            }
            found.work.0 -= given - share.0;
        }
    }
    if !is_usable {
        // One alone is apart from all of the other.
        found.close.truncate(close);
    }
    if fewest.is_none() && !is_full {
        found.separate_within([a, b], 1);
        let by_both = found.breaks.split_off(before);
        fewest = (before + by_both.len() <= found.most).then_some(by_both);
    }
    let Some(mut fewest) = fewest else {
        found.work.0 = 0;
        return;
    };
    if may_be_alone {
        for (halved, other) in [(a, b), (b, a)] {
            // Not for more than the search itself may still take.
            if other.len() * fewest.len() < found.work.0 {
                found.opposite.extend(opposite(halved, other, &fewest, found.size));
            }
        }
    }
    found.breaks.append(&mut fewest);
}

/// The parameters of `b` next to those breaks that `a` has, where `b` runs along there. With the same chords on both
/// sides, a strip between them keeps its width; with long chords on one side, it would be as wide as the tolerance
/// allows.
fn opposite<'a>(a: ArcSpan<'a>, b: ArcSpan<'a>, breaks: &[(u32, f64)], size: DVec2) -> Vec<(u32, f64)> {
    /// Maximum width of the strip, as a share of the shorter chord of `a` next to the break. In wider ones, arcs turn
    /// by half a radian from one break to the next.
    const NARROW: f64 = 0.0625;
    let mut ts: Vec<f64> = breaks.iter().filter(|at| at.0 == a.arc.edge).map(|at| at.1).collect();
    if ts.is_empty() {
        return Vec::new();
    }
    ts.extend(a.range());
    ts.sort_by(f64::total_cmp);
    ts.dedup();
    let points: Vec<DVec2> = ts.iter().map(|t| a.at(*t) * size).collect();
    let [low, high] = [b.arc.low, b.arc.high].map(|corner| corner * size);
    let next_to = |w: &[DVec2]| {
        let close = NARROW * w[0].distance(w[1]).min(w[1].distance(w[2]));
        if w[1].distance(w[1].clamp(low, high)) > close {
            return None;
        }
        let (t, width) = b.nearest(w[1], size, close)?;
        (width < close).then_some((b.arc.edge, t))
    };
    points.windows(3).filter_map(next_to).collect()
}

/// Halves one of two arcs, fewer than `most` times, until lines separate its pieces from the other. Whether they do.
fn separate_alone<'a>(
    a: ArcSpan<'a>,
    b: ArcSpan<'a>,
    breaks: &mut Vec<(u32, f64)>,
    most: usize,
    work: &mut WorkLeft,
) -> bool {
    if !work.takes(a.len() + b.len()) {
        return false;
    }
    if a.is_beyond(b) {
        return true;
    }
    let whole = a.can_split();
    if breaks.len() + 1 >= most || !whole && !a.by_cubic().can_be_halved() {
        return false;
    }
    let (mid, halves) = if whole { a.split() } else { a.by_cubic().split() };
    breaks.push((a.arc.edge, mid));
    halves.into_iter().all(|half| separate_alone(half, b, breaks, most, work))
}

/// Halves two arcs until their hulls are disjoint. Each halving becomes a break. Keeps pairs that cannot be separated.
fn separate<'a>(a: ArcSpan<'a>, b: ArcSpan<'a>, depth: u32, found: &mut Separation<'a, '_>) {
    let shared = shared_ends(a, b);
    if found.is_full() || !found.work.takes(a.len() + b.len()) || apart(a, b, shared) {
        return;
    }
    let most = match (a.arc.exact, shared[0]) {
        (false, _) => MAX_DEPTH,
        (true, None) => MAX_DEPTH_EXACT,
        (true, Some(_)) => MAX_DEPTH_TANGENT,
    };
    let can_split = [a, b].map(|s| s.can_split());
    if depth >= 2 * most || can_split == [false; 2] {
        separate_below_samples((a, b), shared[0].is_some(), found);
        return;
    }
    let [halved, other] = halved_first([a, b], can_split, shared[0].is_some());
    for half in found.halve(&halved) {
        separate(half, other, depth + 1, found);
    }
}

/// The same for arcs of edges in space that cannot be halved at samples. If they run along each other, breaks gain
/// nothing, and the pair is kept as it is. `joined`: whether they have a common end.
fn separate_below_samples<'a>((a, b): (ArcSpan<'a>, ArcSpan<'a>), joined: bool, found: &mut Separation<'a, '_>) {
    // If they leave a common end side by side, each halving would only ask for the next.
    if a.arc.exact || joined || (!a.is_curved() && !b.is_curved()) {
        found.keep((a, b), Vec::new());
        return;
    }
    let before = found.breaks.len();
    let mut left = Vec::new();
    halve([a.by_cubic(), b.by_cubic()], &mut left, found);
    if left.is_empty() || found.is_full() {
        return;
    }
    found.breaks.truncate(before);
    // Arcs that touch at a common end stay close however often they are halved.
    left.retain(|(a, b)| shared_ends(*a, *b)[0].is_none());
    if left.len() > MAX_UNRESOLVED {
        left.clear();
    }
    found.keep((a, b), left);
}

/// Two arcs, the one to halve first: the one with the other on its concave side, or else the fatter one.
fn halved_first<'a>([a, b]: [ArcSpan<'a>; 2], can_split: [bool; 2], joined: bool) -> [ArcSpan<'a>; 2] {
    let hollow = [!joined && a.has_inside(b), !joined && b.has_inside(a)];
    let is_first = if can_split == [true; 2] && hollow[0] == hollow[1] {
        a.fatness() >= b.fatness()
    } else {
        can_split[0] && (hollow[0] || !can_split[1])
    };
    if is_first { [a, b] } else { [b, a] }
}

/// Halves cubics until they are disjoint. Appends pairs that are not to `left`, and stops if these are too many.
fn halve<'a>([a, b]: [ArcSpan<'a>; 2], left: &mut Vec<Pair<'a>>, found: &mut Separation<'a, '_>) {
    let shared = shared_ends(a, b);
    let done = left.len() > MAX_UNRESOLVED || found.is_full() || !found.work.takes(a.len() + b.len());
    if done || if shared[0].is_none() { exactly_apart(a, b) } else { apart(a, b, shared) } {
        return;
    }
    let can_split = [a, b].map(|s| s.can_be_halved());
    if can_split == [false; 2] {
        left.push((a, b));
        return;
    }
    let [halved, other] = halved_first([a, b], can_split, shared[0].is_some());
    for half in found.halve(&halved) {
        halve([half.by_cubic(), other], left, found);
    }
}
