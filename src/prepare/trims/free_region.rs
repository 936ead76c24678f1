//! Free trimming curves and a rule -> the region of the domain that they keep, as closed loops of exact arcs.
//!
//! All curves and the border of the domain are cut where they meet. The rule is evaluated just left and just right of
//! each arc's middle, from winding numbers counted along a ray by exact arcs. An arc with the same answer on both sides
//! bounds nothing and is dropped. This removes redundant loops, and stretches that two curves run in opposite
//! directions. The other arcs are linked to loops with the region on their left.

use super::chains::{SpanChain, SpanPlace, StretchPart, TOUCH, copies, green, stretch, whole};
use super::intersect::{SAME, meetings};
use super::spans::{Span, UvDomain};
use crate::control::{Call, Control, Rayon};
use crate::math::boxes::BoxTree;
use crate::math::keyed::sums_by_key;
use crate::model::{FreeTrims, TrimRule, TrimTrouble};
use crate::prepare::report::NoRegion;
use glam::DVec2;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// A curve that meets a ray within this distance of its start runs along the arc on which the ray starts.
const ALONG: f64 = 4.0 * TOUCH;

/// Arcs that a thread takes at a time: a few microseconds each.
const SHARE: usize = 16;

/// Index of the chain that is the border of the domain.
pub(crate) const BORDER: usize = 0;

/// A trimming curve, closed to a loop around the side that it keeps.
#[derive(Clone, Debug)]
struct Wire {
    /// 0 for the border, `k + 1` for curve `k` and its copies across seams.
    owner: usize,
    chain: SpanChain,
    /// Closes an open chain along the border or outside the domain. Counts for winding numbers only.
    closure: Vec<Span>,
    /// Least winding number of a point inside: 1 for counter-clockwise loops, 0 for clockwise ones.
    least: i32,
}

/// The part of a chain between two nodes, or a whole closed chain without nodes.
#[derive(Clone, Debug)]
pub(crate) struct FreeArc {
    pub(crate) chain: usize,
    /// In order of the chain.
    pub(crate) parts: Vec<StretchPart>,
    /// Its start and end; `None` for a whole chain.
    pub(crate) nodes: Option<[usize; 2]>,
    /// Whether its loop runs against the chain.
    pub(crate) reversed: bool,
}

impl FreeArc {
    /// Its nodes in loop order.
    fn ends(&self) -> Option<[usize; 2]> {
        self.nodes.map(|[a, b]| if self.reversed { [b, a] } else { [a, b] })
    }
}

/// The part of a domain that free trims keep.
#[derive(Clone, Debug)]
pub struct FreeRegion {
    pub(crate) domain: UvDomain,
    wires: Vec<Wire>,
    /// In the unit square.
    pub(crate) nodes: Vec<DVec2>,
    pub(crate) loops: Vec<Vec<FreeArc>>,
    /// Curves that leave the domain, cross themselves, or end inside.
    pub notes: Vec<TrimNote>,
}

/// A finding about a trimming curve.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimNote {
    /// Where, in (u,v).
    pub at: DVec2,
    /// The curve and the finding.
    pub what: TrimTrouble,
    /// Whether the curve was changed, because it ended inside the domain.
    pub repaired: bool,
}

impl FreeRegion {
    /// The region that `trims` keep. Its curves must pass [`TrimCurve::check`](crate::model::TrimCurve::check).
    ///
    /// Points closer than a billionth of the domain are one. Closed curves, and those that end one period from their
    /// start, continue across seams of the surface. Other open curves are clipped.
    ///
    /// Cost: about 10 µs for each pair of monotone arcs whose boxes meet, plus one ray per arc between two meetings,
    /// tested against the monotone arcs whose boxes it meets.
    ///
    /// # Errors
    /// [`NoRegion`] where curves are too close to be separated, but not equal either.
    pub fn new(trims: &FreeTrims, domain: &UvDomain) -> Result<Self, NoRegion> {
        Self::of(Call::new(&Rayon, &Control::default()), trims, domain)
    }

    pub(crate) fn of(call: Call<'_>, trims: &FreeTrims, domain: &UvDomain) -> Result<Self, NoRegion> {
        let mut region =
            Self { domain: *domain, wires: vec![border()], nodes: Vec::new(), loops: Vec::new(), notes: Vec::new() };
        for (k, curve) in trims.curves.iter().enumerate() {
            let (chains, complete) = copies(SpanChain::of(curve, domain), domain.periodic);
            for chain in chains {
                let wire = region.wire(k, chain, complete);
                region.wires.push(wire);
            }
        }
        let events = region.events(call);
        let arcs = region.arcs(events);
        let kept = region.kept(call, arcs, trims.rule, trims.curves.is_empty());
        region.loops = region.link(kept)?;
        Ok(region)
    }

    /// Its area in (u,v), by Green's theorem on the exact arcs.
    #[must_use]
    pub fn area(&self) -> f64 {
        let size = self.domain.high - self.domain.low;
        self.loops.iter().flatten().map(|arc| self.green(arc)).sum::<f64>() * size.x * size.y
    }

    /// Whether the trims keep nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.loops.is_empty()
    }

    /// Whether a stretch of the lower or upper side of the domain in coordinate `axis` bounds the region.
    pub(crate) fn reaches(&self, axis: usize, upper: bool) -> bool {
        let side = [[3, 1], [0, 2]][axis][usize::from(upper)];
        let along = |arc: &FreeArc| arc.chain == BORDER && arc.parts.iter().any(|part| part.span == side);
        self.loops.iter().flatten().any(along)
    }

    /// The loops as closed polygons with the region on their left. Straight arcs have one segment, others `per_arc`
    /// segments between extremes of the curve.
    #[must_use]
    pub fn polygons(&self, per_arc: usize) -> Vec<Vec<DVec2>> {
        let of_arc = |arc: &FreeArc| -> Vec<DVec2> {
            let mut points: Vec<DVec2> = Vec::new();
            for part in &arc.parts {
                let span = self.span(arc.chain, part.span);
                let n = if span.control.len() == 2 { 1 } else { per_arc };
                points.extend((0..=n).map(|k| span.point(part.from + (part.to - part.from) * k as f64 / n as f64)));
            }
            if arc.reversed {
                points.reverse();
            }
            points
        };
        let of_loop = |arcs: &Vec<FreeArc>| {
            let mut points: Vec<DVec2> = arcs.iter().flat_map(of_arc).map(|p| self.domain.of_unit(p)).collect();
            points.dedup();
            points
        };
        self.loops.iter().map(of_loop).collect()
    }

    pub(crate) fn span(&self, chain: usize, span: usize) -> &Span {
        &self.wires[chain].chain.spans[span]
    }

    /// Closes a copy of a curve to a loop. `complete`: directions in which other copies cover what leaves the domain.
    fn wire(&mut self, curve: usize, mut chain: SpanChain, complete: [bool; 2]) -> Wire {
        let owner = curve + 1;
        let mut closure = Vec::new();
        let spans = &mut chain.spans;
        let leaves = |p: &DVec2| {
            let beyond = (p.clamp(DVec2::ZERO, DVec2::ONE) - *p).abs();
            (0..2).any(|axis| !complete[axis] && beyond[axis] > TOUCH)
        };
        let outside = spans.iter().flat_map(|s| s.ends).find(leaves);
        if let Some(p) = outside {
            self.notes.push(note(&self.domain, p, TrimTrouble::Clipped { curve }, false));
        }
        if let (false, Some(first), Some(last)) = (chain.closed, spans.first(), spans.last()) {
            let (start, end) = (first.ends[0], last.ends[1]);
            let [from, to] = [end, start].map(on_border);
            let piece = last.piece + 1;
            // In loop order: from the curve's end to the border, then from the border to its start.
            for (p, q, at_end) in [(end, from, true), (to, start, false)] {
                let inner = if at_end { p } else { q };
                let is_inside = inner.cmpgt(DVec2::ZERO).all() && inner.cmplt(DVec2::ONE).all();
                let missing = p.distance(q);
                if missing <= TOUCH {
                    // It ends on the border up to rounding.
                    if at_end {
                        if let Some(last) = spans.last_mut() {
                            last.ends[1] = q;
                        }
                    } else {
                        spans[0].ends[0] = p;
                    }
                } else if is_inside {
                    let what = TrimTrouble::Extended { curve, at_end, missing };
                    self.notes.push(note(&self.domain, inner, what, true));
                    let line = Span::line(p, q, piece + usize::from(!at_end), (0.0, 1.0));
                    if at_end { spans.push(line) } else { spans.insert(0, line) }
                } else {
                    closure.push(Span::line(p, q, piece, (0.0, 1.0)));
                }
            }
            let mut path = vec![from];
            let (a, mut b) = (perimeter(from), perimeter(to));
            if b < a {
                b += 4.0;
            }
            path.extend((1..8).filter(|&k| f64::from(k) > a && f64::from(k) < b).map(|k| CORNERS[k as usize % 4]));
            path.push(to);
            closure.extend(path.windows(2).map(|w| Span::line(w[0], w[1], piece, (0.0, 1.0))));
            return Wire { owner, chain, closure, least: 1 };
        }
        let arc = FreeArc { chain: BORDER, parts: whole(&chain), nodes: None, reversed: false };
        let area: f64 = arc.parts.iter().map(|p| green(&chain.spans[p.span], p)).sum();
        Wire { owner, chain, closure, least: i32::from(area > 0.0) }
    }

    /// The cuts of each chain: places with their nodes.
    fn events(&mut self, call: Call<'_>) -> Vec<Vec<(SpanPlace, usize)>> {
        let chains: Vec<&SpanChain> = self.wires.iter().map(|w| &w.chain).collect();
        let mut places: Vec<(SpanPlace, DVec2)> = Vec::new();
        let mut met_itself = BTreeMap::new();
        for m in meetings(call, &chains) {
            let [owner, other] = m.at.map(|at| self.wires[at.chain].owner);
            if owner == other {
                met_itself.entry(owner).or_insert(m.point);
            }
            places.extend(m.at.map(|p| (p, m.point)));
        }
        for (owner, p) in met_itself {
            let what = TrimTrouble::CrossesItself { curve: owner.saturating_sub(1) };
            self.notes.push(note(&self.domain, p, what, false));
        }
        for (k, chain) in chains.iter().enumerate().filter(|(_, c)| !c.closed && !c.spans.is_empty()) {
            let last = chain.spans.len() - 1;
            places.push((SpanPlace { chain: k, span: 0, s: 0.0 }, chain.spans[0].ends[0]));
            places.push((SpanPlace { chain: k, span: last, s: 1.0 }, chain.spans[last].ends[1]));
        }
        // Sides that are one line of the surface get the same cuts.
        let mut twins: Vec<(SpanPlace, DVec2)> = Vec::new();
        for (_, p) in &places {
            for axis in (0..2).filter(|&axis| self.domain.periodic[axis]) {
                for side in [0.0, 1.0] {
                    if (p[axis] - side).abs() > TOUCH || p[1 - axis] < -TOUCH || p[1 - axis] > 1.0 + TOUCH {
                        continue;
                    }
                    let mut twin = p.clamp(DVec2::ZERO, DVec2::ONE);
                    twin[axis] = 1.0 - side;
                    let span = [[3, 1], [0, 2]][axis][usize::from(side == 0.0)];
                    let along = twin[1 - axis];
                    let s = if span < 2 { along } else { 1.0 - along };
                    twins.push((SpanPlace { chain: BORDER, span, s }, twin));
                }
            }
        }
        places.extend(twins);
        places.sort_by(|a, b| (a.1.x, a.1.y).partial_cmp(&(b.1.x, b.1.y)).unwrap_or(std::cmp::Ordering::Equal));
        let mut events: Vec<Vec<(SpanPlace, usize)>> = vec![Vec::new(); chains.len()];
        let mut open: Vec<usize> = Vec::new();
        let mut found: Vec<DVec2> = Vec::new();
        for (place, p) in places {
            open.retain(|&n| found[n].x + SAME >= p.x);
            let known = open.iter().copied().find(|&n| found[n].distance(p) <= SAME);
            let node = known.unwrap_or_else(|| {
                found.push(p);
                self.nodes.push(p);
                open.push(found.len() - 1);
                found.len() - 1
            });
            // A place on the border sets its node's point, so that the node lies on the border bit for bit.
            if place.chain == BORDER {
                let on = chains[BORDER].spans[place.span].point(place.s);
                let corner = CORNERS.into_iter().find(|c| c.distance(on) <= SAME);
                self.nodes[node] = corner.unwrap_or(on);
            }
            events[place.chain].push((place, node));
        }
        for axis in (0..2).filter(|&axis| self.domain.periodic[axis]) {
            let on =
                |nodes: &[DVec2], side: f64| (0..nodes.len()).filter(|&n| nodes[n][axis] == side).collect::<Vec<_>>();
            let (low, mut high) = (on(&self.nodes, 0.0), on(&self.nodes, 1.0));
            high.sort_by(|&a, &b| self.nodes[a][1 - axis].total_cmp(&self.nodes[b][1 - axis]));
            for a in low {
                let at = self.nodes[a][1 - axis];
                let first = high.partition_point(|&b| self.nodes[b][1 - axis] < at - 2.0 * SAME);
                if let Some(&b) = high.get(first).filter(|&&b| self.nodes[b][1 - axis] <= at + 2.0 * SAME) {
                    self.nodes[b][1 - axis] = at;
                }
            }
        }
        events
    }

    /// Cuts all chains into arcs.
    fn arcs(&self, mut events: Vec<Vec<(SpanPlace, usize)>>) -> Vec<FreeArc> {
        let mut out = Vec::new();
        for (k, cuts) in events.iter_mut().enumerate() {
            let chain = &self.wires[k].chain;
            let count = chain.spans.len();
            for (place, _) in cuts.iter_mut() {
                // The joint of two spans counts as the start of the second.
                if place.s >= 1.0 - 1e-12 && (chain.closed || place.span + 1 < count) {
                    (place.span, place.s) = ((place.span + 1) % count, 0.0);
                }
            }
            cuts.sort_by(|a, b| (a.0.span, a.0.s).partial_cmp(&(b.0.span, b.0.s)).unwrap_or(std::cmp::Ordering::Equal));
            if cuts.is_empty() {
                if count > 0 {
                    out.push(FreeArc { chain: k, parts: whole(chain), nodes: None, reversed: false });
                }
                continue;
            }
            let pairs = if chain.closed { cuts.len() } else { cuts.len() - 1 };
            for i in 0..pairs {
                let ((from, a), (to, b)) = (cuts[i], cuts[(i + 1) % cuts.len()]);
                let round = i + 1 == cuts.len();
                let parts = stretch(chain, from, to, round);
                let short = |p: &StretchPart| {
                    let span = &chain.spans[p.span];
                    span.point(p.from).distance(span.point(p.to)) <= 4.0 * SAME
                };
                if a == b && parts.len() <= 2 && parts.iter().all(short) {
                    continue;
                }
                out.push(FreeArc { chain: k, parts, nodes: Some([a, b]), reversed: false });
            }
        }
        out
    }

    /// The arcs with the region on one side only, oriented so that it is on the left.
    fn kept(&self, call: Call<'_>, arcs: Vec<FreeArc>, rule: TrimRule, everything: bool) -> Vec<FreeArc> {
        let rays = Rays::new(&self.wires);
        let mut leasts = vec![0; self.wires.last().map_or(0, |wire| wire.owner) + 1];
        self.wires.iter().skip(1).for_each(|wire| leasts[wire.owner] = wire.least);
        let demanding = leasts.iter().filter(|&&least| least > 0).count();
        // The winding number of a curve that is not listed is 0.
        let keeps = |w: &[(usize, i32)]| {
            let mut curves = w.iter().filter(|w| w.0 != 0);
            let within = w.iter().any(|&(owner, w)| owner == 0 && w > 0);
            within
                && (everything
                    || match rule {
                        TrimRule::Handedness => {
                            let met = curves.clone().filter(|&&(c, w)| leasts[c] > 0 && w >= leasts[c]).count();
                            met == demanding && curves.all(|&(c, w)| w >= leasts[c])
                        }
                        TrimRule::NonZero => curves.map(|w| w.1).sum::<i32>() != 0,
                        TrimRule::EvenOdd => curves.map(|w| w.1).sum::<i32>() % 2 != 0,
                    })
        };
        let label = |mut arc: FreeArc| -> Option<FreeArc> {
            let length = |p: &StretchPart| {
                let span = self.span(arc.chain, p.span);
                span.point(p.from).distance(span.point(p.to))
            };
            let part = *arc.parts.iter().max_by(|a, b| length(a).total_cmp(&length(b)))?;
            let span = self.span(arc.chain, part.span);
            let [q, d, _] = span.derivatives(0.5 * (part.from + part.to));
            let q = if span.control.len() == 2 { span.point(0.5 * (part.from + part.to)) } else { q };
            // The ray runs across the arc.
            let axis = usize::from(d.x.abs() > d.y.abs());
            let (ahead, along) = rays.windings(&self.wires, q, axis);
            let own = along.iter().find(|a| (a.0, a.1) == (arc.chain, part.span))?.2;
            if along.iter().any(|a| (a.0, a.1) < (arc.chain, part.span)) {
                // Of curves that coincide here, only the first keeps its arc.
                return None;
            }
            let behind =
                sums_by_key(ahead.iter().copied().chain(along.iter().map(|a| (self.wires[a.0].owner, a.2))).collect());
            let (ahead, behind) = (keeps(&ahead), keeps(&behind));
            if ahead == behind {
                return None;
            }
            let left = if own > 0 { behind } else { ahead };
            arc.reversed = !left;
            Some(arc)
        };
        call.each(SHARE, arcs, label).into_iter().flatten().collect()
    }

    /// Joins arcs to loops. At a node it takes the leftmost turn, so that regions that only touch there stay separate.
    fn link(&self, arcs: Vec<FreeArc>) -> Result<Vec<Vec<FreeArc>>, NoRegion> {
        /// Turns back by less than this angle, radians, are taken last: curves that touch each go on along themselves.
        const BACK: f64 = 0.01;
        let mut leaving: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut loops = Vec::new();
        let mut starts = Vec::new();
        let mut arcs: Vec<Option<FreeArc>> = arcs.into_iter().map(Some).collect();
        for (k, slot) in arcs.iter_mut().enumerate() {
            match slot.as_ref().map(FreeArc::ends) {
                Some(Some([from, _])) => {
                    leaving.entry(from).or_default().push(k);
                    starts.push(k);
                }
                _ => loops.extend(slot.take().map(|whole| vec![whole])),
            }
        }
        for start in starts {
            let Some(first) = arcs[start].take() else { continue };
            let Some([from, mut at]) = first.ends() else { continue };
            let mut chain = vec![first];
            while at != from {
                let back = chain.last().map_or(DVec2::ZERO, |arc| self.direction(arc, true));
                let ways = leaving.get(&at).into_iter().flatten().copied();
                let turn = |&k: &usize| {
                    arcs[k].as_ref().map(|arc| {
                        // The angle from the way out to the way back, counter-clockwise. The least leaves no arc in
                        // between.
                        let to = self.direction(arc, false);
                        let wedge = to.angle_to(back).rem_euclid(TAU);
                        if wedge < BACK { TAU } else { wedge }
                    })
                };
                let next = ways.filter_map(|k| turn(&k).map(|angle| (k, angle))).min_by(|a, b| a.1.total_cmp(&b.1));
                let Some(arc) = next.and_then(|(k, _)| arcs[k].take()) else {
                    return Err(NoRegion { at: self.domain.of_unit(self.nodes[at]) });
                };
                at = arc.ends().map_or(from, |ends| ends[1]);
                chain.push(arc);
            }
            loops.push(chain);
        }
        Ok(loops)
    }

    /// The direction into an arc from its start in loop order, or from its end if `at_end`.
    fn direction(&self, arc: &FreeArc, at_end: bool) -> DVec2 {
        const STEP: f64 = 1e-3;
        let first = at_end == arc.reversed;
        let part = if first { arc.parts[0] } else { arc.parts[arc.parts.len() - 1] };
        let span = self.span(arc.chain, part.span);
        let (from, to) = if first { (part.from, part.to) } else { (part.to, part.from) };
        span.point(from + (to - from) * STEP) - span.point(from)
    }

    fn green(&self, arc: &FreeArc) -> f64 {
        let sum: f64 = arc.parts.iter().map(|p| green(self.span(arc.chain, p.span), p)).sum();
        if arc.reversed { -sum } else { sum }
    }
}

/// A span that runs through a point: chain, span, and its contribution to the winding number behind the point.
type Through = (usize, usize, i32);

/// The spans of all wires, in a tree for ray queries.
struct Rays {
    tree: BoxTree<DVec2>,
    /// Chain and span of each box. The spans of a wire's closure follow its own.
    names: Vec<(u32, u32)>,
}

impl Rays {
    fn new(wires: &[Wire]) -> Self {
        let mut names = Vec::new();
        let mut boxes = Vec::new();
        for (c, wire) in wires.iter().enumerate() {
            for (k, span) in wire.chain.spans.iter().chain(&wire.closure).enumerate() {
                names.push((c as u32, k as u32));
                boxes.push([span.low(), span.high()]);
            }
        }
        Self { tree: BoxTree::new(&boxes), names }
    }

    /// Casts a ray from `q` along coordinate `axis`. Returns winding numbers by owner about the points just ahead of
    /// `q` (owners that the ray does not meet are absent), and the spans that run through `q`.
    fn windings(&self, wires: &[Wire], q: DVec2, axis: usize) -> (Vec<(usize, i32)>, Vec<Through>) {
        let across = 1 - axis;
        let mut ahead = Vec::new();
        let mut along = Vec::new();
        let (mut low, mut high) = (q, q);
        low[axis] -= ALONG;
        high[axis] = f64::INFINITY;
        self.tree.meeting([low, high], |number| {
            let (c, k) = (self.names[number].0 as usize, self.names[number].1 as usize);
            let spans = &wires[c].chain.spans;
            let span = spans.get(k).unwrap_or_else(|| &wires[c].closure[k - spans.len()]);
            let [a, b] = span.ends;
            if (a[across] <= q[across]) == (b[across] <= q[across]) {
                return;
            }
            // Positive if the span runs counter-clockwise about the points behind.
            let sign = if (b[across] > a[across]) == (axis == 0) { 1 } else { -1 };
            let far = if a[axis].min(b[axis]) > q[axis] + ALONG {
                f64::INFINITY
            } else {
                span.point(span.at(across, q[across]))[axis] - q[axis]
            };
            if far > ALONG {
                ahead.push((wires[c].owner, sign));
            } else if far >= -ALONG {
                along.push((c, k, sign));
            }
        });
        (sums_by_key(ahead), along)
    }
}

const CORNERS: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];

fn note(domain: &UvDomain, p: DVec2, what: TrimTrouble, repaired: bool) -> TrimNote {
    TrimNote { at: domain.of_unit(p.clamp(DVec2::ZERO, DVec2::ONE)), what, repaired }
}

fn border() -> Wire {
    let line = |k: usize| Span::line(CORNERS[k], CORNERS[(k + 1) % 4], k, (0.0, 1.0));
    Wire {
        owner: 0,
        chain: SpanChain { spans: (0..4).map(line).collect(), closed: true },
        closure: Vec::new(),
        least: 1,
    }
}

/// The point of the border nearest to `p`.
fn on_border(p: DVec2) -> DVec2 {
    let mut q = p.clamp(DVec2::ZERO, DVec2::ONE);
    if q.cmpgt(DVec2::ZERO).all() && q.cmplt(DVec2::ONE).all() {
        let sides = [(0, 0.0, q.x), (0, 1.0, 1.0 - q.x), (1, 0.0, q.y), (1, 1.0, 1.0 - q.y)];
        if let Some((axis, at, _)) = sides.into_iter().min_by(|a, b| a.2.total_cmp(&b.2)) {
            q[axis] = at;
        }
    }
    q
}

/// Length of the border of the unit square, counter-clockwise from the lower left corner to `p`.
fn perimeter(p: DVec2) -> f64 {
    if p.y == 0.0 {
        p.x
    } else if p.x == 1.0 {
        1.0 + p.y
    } else if p.y == 1.0 {
        3.0 - p.x
    } else {
        4.0 - p.y
    }
}
