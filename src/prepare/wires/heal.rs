//! A part whose wires are out of order or have gaps -> a part whose wires close, and a report of the changes to each
//! face.
//!
//! First, wires that close in another order of their edges are reordered. Then a gap within the part's tolerance, or
//! within the distance by which an edge may miss its vertex, is closed by merging its two vertices for all faces. A
//! wider gap gets one new edge for all faces that have it. Its curve lies on the surface of one of them, over the
//! straight line in (u,v). Seams of periodic surfaces, which bound nothing, can be left out ([`without_seams`]).

use crate::math::graph::{DisjointSets, Links};
use crate::model::{
    Coedge, CurveKind, Edge, EdgeId, Face, Loop, NurbsCurve3, Part, Severity, Surface, VertexId, WireTrouble,
    knots_of_pieces,
};
use crate::prepare::report::Finding;
use crate::prepare::uv::lead::curve_end;
use crate::prepare::uv::projector::Projector;
use glam::DVec3;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashSet};

/// Start and end vertex of an edge, or of its reverse; `None` if the part has no such edge.
pub(crate) fn ends(part: &Part, edge: EdgeId, reversed: bool) -> Option<[VertexId; 2]> {
    part.edges.get(edge.index()).map(|edge| edge.ends(reversed))
}

/// [`ends`] of each coedge; `None` if the part lacks one of the edges.
fn ends_of_all(part: &Part, coedges: &[Coedge]) -> Option<Vec<[VertexId; 2]>> {
    coedges.iter().map(|c| ends(part, c.edge, c.reversed)).collect()
}

/// Index of an edge in its wire, and whether to reverse it.
type OrderedEdge = (usize, bool);

/// Orders edges, given by start and end, into one or more closed wires. `None` if they do not close.
///
/// First tries the directions given. If that fails and exactly two edges meet at every vertex, reverses edges as
/// needed: files get directions wrong too. Each wire then runs in the direction of most of its edges.
fn in_order(ends: &[[VertexId; 2]]) -> Option<Vec<Vec<OrderedEdge>>> {
    chained(ends).or_else(|| {
        let mut at: BTreeMap<VertexId, Vec<usize>> = BTreeMap::new();
        for (k, [a, b]) in ends.iter().enumerate() {
            at.entry(*a).or_default().push(k);
            at.entry(*b).or_default().push(k);
        }
        at.values().all(|there| there.len() == 2).then(|| turned(ends, &at))
    })
}

/// Closed wires of edges in the directions given.
fn chained(ends: &[[VertexId; 2]]) -> Option<Vec<Vec<OrderedEdge>>> {
    let wires = Links::of(ends).closed()?;
    Some(wires.into_iter().map(|wire| wire.into_iter().map(|k| (k, false)).collect()).collect())
}

/// Closed wires of edges of which exactly two meet at every vertex.
fn turned(ends: &[[VertexId; 2]], at: &BTreeMap<VertexId, Vec<usize>>) -> Vec<Vec<OrderedEdge>> {
    let mut used = vec![false; ends.len()];
    let mut wires = Vec::new();
    for first in 0..ends.len() {
        if used[first] {
            continue;
        }
        used[first] = true;
        let mut wire = vec![(first, false)];
        let mut tip = ends[first][1];
        while let Some(&next) = at[&tip].iter().find(|&&k| !used[k]) {
            used[next] = true;
            let against = ends[next][0] != tip;
            wire.push((next, against));
            tip = ends[next][usize::from(!against)];
        }
        if 2 * wire.iter().filter(|w| w.1).count() > wire.len() {
            wire.reverse();
            wire.iter_mut().for_each(|w| w.1 = !w.1);
        }
        wires.push(wire);
    }
    wires
}

/// The loops of a face on a periodic surface without its seams: edges that one loop uses in both directions. `None` if
/// there are no seams, or if the remaining edges do not close.
///
/// A seam bounds nothing. Files add it to describe the face by a single wire.
pub(crate) fn without_seams(part: &Part, face: &Face) -> Option<Vec<Loop>> {
    if face.surface.period() == [None, None] {
        return None;
    }
    let mut found = false;
    let mut loops = Vec::with_capacity(face.loops.len());
    for l in &face.loops {
        let Loop::Edges(coedges) = l else {
            loops.push(l.clone());
            continue;
        };
        let ways: HashSet<(EdgeId, bool)> = coedges.iter().map(|c| (c.edge, c.reversed)).collect();
        let rest: Vec<Coedge> = coedges.iter().filter(|c| !ways.contains(&(c.edge, !c.reversed))).copied().collect();
        if rest.len() == coedges.len() {
            loops.push(l.clone());
            continue;
        }
        found = true;
        let wires = chained(&ends_of_all(part, &rest)?)?;
        loops.extend(wires.iter().map(|wire| Loop::Edges(wire.iter().map(|w| rest[w.0]).collect())));
    }
    found.then_some(loops)
}

/// Tolerance of a part that states none, as a share of its size: rounding of coordinates printed with eight digits.
const FLOOR: f64 = 1e-7;

/// Share of a part's size by which an edge may end off its vertex without a report. Files print six digits or more.
const OFF_VERTEX: f64 = 1e-4;

/// Number of neighbours in x order that a vertex is compared with, per loop.
const MOST_BESIDE: usize = 64;

/// Cubic spans of the curve that closes a wide gap: enough to follow a quarter turn to 1e-6 of its radius.
const SPANS: usize = 16;

/// A repair of a face, to be reported.
pub(crate) struct Healing {
    pub(crate) face: usize,
    pub(crate) severity: Severity,
    pub(crate) told: Finding,
}

/// A gap between two successive coedges of a loop that do not share a vertex.
struct Gap {
    face: usize,
    index: usize,
    /// Index of the coedge before the gap.
    after: usize,
    width: f64,
}

impl Gap {
    /// The vertices on both sides of the gap.
    fn ends(&self, part: &Part) -> Option<[VertexId; 2]> {
        let Loop::Edges(coedges) = &part.faces[self.face].loops[self.index] else { return None };
        let [before, next] = [self.after, (self.after + 1) % coedges.len()].map(|k| coedges[k]);
        Some([ends(part, before.edge, before.reversed)?[1], ends(part, next.edge, next.reversed)?[0]])
    }
}

/// Closes the gaps in the loops of `part`, whose bounding box has the diagonal `size`, and appends what was repaired to
/// `done`. Copies a borrowed part only if there are gaps, and any part if a loop is reordered.
pub(crate) fn heal<'a>(part: Cow<'a, Part>, size: f64, done: &mut Vec<Healing>) -> Cow<'a, Part> {
    tell_ends_off_vertices(&part, OFF_VERTEX * size, done);
    let mut gaps = gaps(&part);
    if gaps.is_empty() {
        return part;
    }
    let tolerance = if part.tolerance > 0.0 { part.tolerance } else { FLOOR * size };
    let near = tolerance.max(OFF_VERTEX * size);
    let sorted = sort(&part, &gaps, near, done);
    if let Some(sorted) = &sorted {
        gaps = self::gaps(sorted);
    }
    let (narrow, wide): (Vec<Gap>, Vec<Gap>) = gaps.into_iter().partition(|gap| gap.width <= near);
    let mut healed = sorted.unwrap_or_else(|| part.into_owned());
    let wide: Vec<Gap> = wide.into_iter().chain(unite(&mut healed, narrow, tolerance, done)).collect();
    bridge(&mut healed, wide, done);
    Cow::Owned(healed)
}

/// Reorders the edges of loops that have gaps but close in another order. `None` if there are no such loops.
///
/// If a loop has a gap wider than `near` and does not close as it is, vertices up to `near` apart count as one.
fn sort(part: &Part, gaps: &[Gap], near: f64, done: &mut Vec<Healing>) -> Option<Part> {
    let mut sorted: Option<Part> = None;
    // Back to front, so that the indices of earlier loops stay valid.
    for of_loop in gaps.chunk_by(|a, b| (a.face, a.index) == (b.face, b.index)).rev() {
        let Gap { face, index, .. } = of_loop[0];
        let Loop::Edges(coedges) = &part.faces[face].loops[index] else { continue };
        let wide = || of_loop.iter().any(|gap| gap.width > near);
        let again = |ends: &Vec<[VertexId; 2]>| wide().then(|| in_order(&united(part, ends, near)))?;
        let Some(wires) = ends_of_all(part, coedges).and_then(|ends| in_order(&ends).or_else(|| again(&ends))) else {
            continue;
        };
        let turned = wires.iter().flatten().filter(|w| w.1).count();
        let what = WireTrouble::Reordered { edges: coedges.len(), turned };
        let place = of_loop[0].ends(part).and_then(|[v, _]| part.vertices.get(v.index()).copied());
        done.push(Healing { face, severity: Severity::Warning, told: Finding::new(place, what) });
        let taken = |&(k, turned): &(usize, bool)| Coedge { reversed: coedges[k].reversed != turned, ..coedges[k] };
        let wires = wires.iter().map(|wire| Loop::Edges(wire.iter().map(taken).collect()));
        sorted.get_or_insert_with(|| part.clone()).faces[face].loops.splice(index..=index, wires);
    }
    sorted
}

/// The ends of a loop's edges, with vertices up to `near` apart replaced by one of them.
fn united(part: &Part, ends: &[[VertexId; 2]], near: f64) -> Vec<[VertexId; 2]> {
    let at = |v: VertexId| part.vertices.get(v.index()).copied().unwrap_or(DVec3::NAN);
    let mut by_x: Vec<VertexId> = ends.iter().flatten().copied().collect();
    by_x.sort_unstable_by(|a, b| at(*a).x.total_cmp(&at(*b).x).then(a.cmp(b)));
    by_x.dedup();
    let mut stands_for: BTreeMap<VertexId, VertexId> = BTreeMap::new();
    for (k, &v) in by_x.iter().enumerate() {
        let before = by_x[..k].iter().rev().take(MOST_BESIDE).take_while(|b| at(v).x - at(**b).x <= near);
        let same = before.map(|b| stands_for.get(b).copied().unwrap_or(*b)).find(|b| at(*b).distance(at(v)) <= near);
        stands_for.insert(v, same.unwrap_or(v));
    }
    ends.iter().map(|pair| pair.map(|v| stands_for.get(&v).copied().unwrap_or(v))).collect()
}

fn gaps(part: &Part) -> Vec<Gap> {
    let mut out = Vec::new();
    for (face, f) in part.faces.iter().enumerate().filter(|(_, f)| !f.lost) {
        for (index, l) in f.loops.iter().enumerate() {
            let Loop::Edges(coedges) = l else { continue };
            for after in 0..coedges.len() {
                let mut gap = Gap { face, index, after, width: 0.0 };
                let Some([a, b]) = gap.ends(part).filter(|[a, b]| a != b) else { continue };
                let (Some(p), Some(q)) = (part.vertices.get(a.index()), part.vertices.get(b.index())) else { continue };
                gap.width = p.distance(*q);
                if gap.width.is_finite() {
                    out.push(gap);
                }
            }
        }
    }
    out
}

/// Merges the vertices on both sides of narrow gaps. Returns the gaps that cannot be closed so, because a short edge
/// joins the two vertices and would vanish.
fn unite(part: &mut Part, narrow: Vec<Gap>, tolerance: f64, done: &mut Vec<Healing>) -> Vec<Gap> {
    let widest_gap = narrow.iter().map(|gap| gap.width).fold(0.0, f64::max);
    let is_short = |&[s, t]: &[VertexId; 2]| {
        let [p, q] = [s, t].map(|v| part.vertices.get(v.index()));
        s != t && p.zip(q).is_some_and(|(p, q)| p.distance(*q) <= 4.0 * widest_gap)
    };
    let short = part.edges.iter().map(|e| [e.start, e.end]).filter(is_short);
    let mut merged = MergedVertices::new(part.vertices.len(), short);
    let mut left = Vec::new();
    let mut widest: BTreeMap<usize, (f64, DVec3)> = BTreeMap::new();
    for gap in narrow {
        let Some(stated) = gap.ends(part) else { continue };
        if !merged.merge(stated) {
            left.push(gap);
            continue;
        }
        let place = part.vertices[stated[0].index()];
        let known = widest.entry(gap.face).or_insert((gap.width, place));
        if gap.width > known.0 {
            *known = (gap.width, place);
        }
    }
    end_at_roots(&mut part.edges, &mut merged.sets);
    done.extend(widest.into_iter().map(|(face, (width, place))| {
        let severity = if width <= tolerance { Severity::Note } else { Severity::Warning };
        let what = WireTrouble::VerticesMoved { width_mm: width, tolerance_mm: tolerance };
        Healing { face, severity, told: Finding::new(Some(place), what) }
    }));
    left
}

/// Makes edges start and end at the roots of sets of vertices.
pub(crate) fn end_at_roots(edges: &mut [Edge], sets: &mut DisjointSets) {
    let known = sets.len();
    for v in edges.iter_mut().flat_map(|e| [&mut e.start, &mut e.end]).filter(|v| v.index() < known) {
        *v = VertexId(sets.root(v.0));
    }
}

/// Sets of merged vertices, and the short edges that join them.
struct MergedVertices {
    sets: DisjointSets,
    /// By the root of a set: the far ends of the short edges of its vertices.
    far_ends: BTreeMap<u32, Vec<u32>>,
}

impl MergedVertices {
    /// Every vertex below `count` in a set of its own. `short`: the ends of short edges.
    fn new(count: usize, short: impl Iterator<Item = [VertexId; 2]>) -> Self {
        let mut far_ends: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for [s, t] in short {
            far_ends.entry(s.0).or_default().push(t.0);
            far_ends.entry(t.0).or_default().push(s.0);
        }
        Self { sets: DisjointSets::new(count), far_ends }
    }

    /// Merges the sets of two vertices, unless a short edge joins them. Whether they are in one set now.
    fn merge(&mut self, vertices: [VertexId; 2]) -> bool {
        let [a, b] = vertices.map(|v| self.sets.root(v.0));
        if a == b {
            return true;
        }
        let count = |root: u32| self.far_ends.get(&root).map_or(0, Vec::len);
        let (few, many) = if count(a) <= count(b) { (a, b) } else { (b, a) };
        let mut moved = self.far_ends.remove(&few).unwrap_or_default();
        if moved.iter().any(|&end| self.sets.root(end) == many) {
            self.far_ends.insert(few, moved);
            return false;
        }
        // The short list goes to the long one, so that an end moves only into a list at least twice as long.
        let mut all = self.far_ends.remove(&many).unwrap_or_default();
        all.append(&mut moved);
        self.sets.join(a, b);
        self.far_ends.insert(a.min(b), all);
        true
    }
}

/// Inserts an edge into every gap.
fn bridge(part: &mut Part, mut gaps: Vec<Gap>, done: &mut Vec<Healing>) {
    let mut known: BTreeMap<[VertexId; 2], EdgeId> = BTreeMap::new();
    let mut of_face: BTreeMap<usize, (usize, f64, DVec3)> = BTreeMap::new();
    // Back to front, so that the indices of earlier gaps stay valid.
    gaps.sort_by_key(|gap| (gap.face, gap.index, std::cmp::Reverse(gap.after)));
    for gap in gaps {
        // Merging vertices at narrow gaps may have closed this one.
        let Some([a, b]) = gap.ends(part) else { continue };
        if a == b {
            continue;
        }
        let key = [a.min(b), a.max(b)];
        let edge = *known.entry(key).or_insert_with(|| {
            let [p, q] = key.map(|v| part.vertices[v.index()]);
            let (curve, kind) = straight(&part.faces[gap.face], p, q);
            let range = curve.domain();
            part.edges.push(Edge { curve, range, start: key[0], end: key[1], kind, entity: 0 });
            EdgeId::new(part.edges.len() - 1)
        });
        let Loop::Edges(coedges) = &mut part.faces[gap.face].loops[gap.index] else { continue };
        coedges.insert(gap.after + 1, Coedge { edge, reversed: a != key[0] });
        let place = part.vertices[a.index()];
        let told = of_face.entry(gap.face).or_insert((0, 0.0, place));
        told.0 += 1;
        if gap.width > told.1 {
            (told.1, told.2) = (gap.width, place);
        }
    }
    done.extend(of_face.into_iter().map(|(face, (count, width, place))| {
        let what = WireTrouble::Bridged { width_mm: width, gaps: count };
        Healing { face, severity: Severity::Warning, told: Finding::new(Some(place), what) }
    }));
}

/// The curve on a face's surface over the straight line in (u,v) between the images of two points. The line between
/// them in space if the surface is a plane, or unsound.
fn straight(face: &Face, p: DVec3, q: DVec3) -> (NurbsCurve3, CurveKind) {
    if matches!(face.surface, Surface::Plane { .. }) || face.surface.check().is_err() {
        return (NurbsCurve3::line(p, q), CurveKind::Line);
    }
    let projector = Projector::new(&face.surface, 1e-6 * p.distance(q));
    let from = projector.project(p, None);
    let to = projector.unwrap(projector.project(q, None), from);
    let at = |k: usize| from + (to - from) * (k as f64 / SPANS as f64);
    let step = (to - from) / SPANS as f64;
    // Cubic Bézier spans from points and derivatives. The curve ends exactly at the vertices.
    let mut points = vec![p];
    for k in 0..SPANS {
        let [(a, da), (b, db)] = [k, k + 1].map(|k| projector.along(at(k), step));
        let [a, b] = [if k == 0 { p } else { a }, if k + 1 == SPANS { q } else { b }];
        points.extend([a + da / 3.0, b - db / 3.0, b]);
    }
    let breaks: Vec<f64> = (0..=SPANS).map(|k| k as f64).collect();
    if !points.iter().all(|p| p.is_finite()) {
        return (NurbsCurve3::line(p, q), CurveKind::Line);
    }
    let knots = knots_of_pieces(3, &breaks);
    (NurbsCurve3 { degree: 3, knots, points, weights: Vec::new() }, CurveKind::Spline)
}

/// Reports edges whose curves end more than `limit` off their vertices, the worst of each face. The mesh follows the
/// vertices.
fn tell_ends_off_vertices(part: &Part, limit: f64, done: &mut Vec<Healing>) {
    let off = |e: &Edge| {
        let at = |v: VertexId, t: f64| Some((part.vertices.get(v.index())?.distance(curve_end(e, t)), v));
        let worst = [at(e.start, e.range.0), at(e.end, e.range.1)].into_iter().flatten();
        worst.filter(|(distance, _)| *distance > limit).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let is_sound = |e: &Edge| e.range.0 < e.range.1 && e.curve.check().is_ok();
    let bad: BTreeMap<u32, (f64, VertexId)> =
        (0..).zip(&part.edges).filter(|(_, e)| is_sound(e)).filter_map(|(k, e)| Some((k, off(e)?))).collect();
    if bad.is_empty() {
        return;
    }
    for (face, f) in part.faces.iter().enumerate() {
        let bad_uses = f.wires().flatten().filter_map(|c| Some((c.edge, *bad.get(&c.edge.0)?)));
        if let Some((edge, (gap_mm, vertex))) = bad_uses.max_by(|(_, a), (_, b)| a.0.total_cmp(&b.0)) {
            let place = part.vertices.get(vertex.index()).copied();
            let told = Finding { edge: Some(edge), ..Finding::new(place, WireTrouble::EdgeOffVertex { gap_mm }) };
            done.push(Healing { face, severity: Severity::Warning, told });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;

    #[test]
    fn vertices_are_merged_like_by_a_look_at_all_short_edges() {
        const COUNT: u32 = 200;
        let mut random = SplitMix(11);
        let mut vertex = || VertexId((random.unit() * f64::from(COUNT)) as u32);
        let short: Vec<[VertexId; 2]> = (0..150).map(|_| [vertex(), vertex()]).filter(|[s, t]| s != t).collect();
        let mut merged = MergedVertices::new(COUNT as usize, short.iter().copied());
        let mut sets = DisjointSets::new(COUNT as usize);
        let mut left = 0;
        for _ in 0..1000 {
            let gap = [vertex(), vertex()];
            let [a, b] = gap.map(|v| sets.root(v.0));
            let mut is_joining = |ends: &[VertexId; 2]| {
                let [s, t] = ends.map(|v| sets.root(v.0));
                [s.min(t), s.max(t)] == [a.min(b), a.max(b)]
            };
            let joined = a != b && short.iter().any(&mut is_joining);
            if !joined {
                sets.join(a, b);
            }
            left += u32::from(joined);
            assert_eq!(merged.merge(gap), !joined, "{gap:?}");
        }
        assert!(left > 50, "{left}");
        assert!((0..COUNT).all(|v| merged.sets.root(v) == sets.root(v)));
    }

    #[test]
    fn many_gaps_between_many_short_edges_are_looked_at_once() {
        // Pairs joined by short edges, in a row with gaps between them, whose far ends gather at one vertex.
        const COUNT: u32 = 200_000;
        let pair = |k: u32| [VertexId(2 * k + 1), VertexId(2 * k + 2)];
        let mut merged = MergedVertices::new(2 * COUNT as usize + 1, (0..COUNT).map(pair));
        let all_merged = (0..COUNT).all(|k| merged.merge([VertexId(0), pair(k)[0]]));
        assert!(all_merged && (0..COUNT).all(|k| !merged.merge(pair(k))));
    }
}
