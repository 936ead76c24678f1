//! Loops of faces -> the edges in use, with counts per shell; edges that may coincide -> the pairs of them that are
//! worth a comparison; pairs that coincide -> whether they may merge.
//!
//! Boxes find edges that are close. Identical edges are found by sorting, so that any number of them costs no more than
//! as many separate edges.
//!
//! Two edges of one face stay apart if the face is a sliver. The two edges of a seam coincide as well. But then the
//! face extends far from the seam, and parts of its boundary have no other edge as near.

use super::overlap::CurveQuery;
use crate::control::Call;
use crate::math::boxes::{Aabb, BoxTree, around};
use crate::math::keyed::summed_by_pair;
use crate::model::{Edge, Part};
use crate::prepare::trims::free_edges::{FreeFaces, free_face};
use crate::prepare::uv::uv_curve::UvSample;
use crate::prepare::uv::uv_loop::{Along, Piece};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// The uses of an edge by the faces of a shell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeInUse {
    pub(crate) shell: u32,
    pub(crate) edge: u32,
    /// Number of uses.
    pub(crate) count: usize,
    /// The first face that uses it.
    pub(crate) face: usize,
    /// Whether it bounds a face without topology, whose edges were made for it.
    pub(crate) untold: bool,
    /// Whether it lies along a side of such a face's domain.
    pub(crate) side: bool,
    /// Whether a face, seen from outside, has it in reverse.
    pub(crate) against: bool,
}

/// The edges in use, sorted by shell and edge.
pub(crate) fn uses(part: &Part, free: &FreeFaces) -> Vec<EdgeInUse> {
    let mut uses = Vec::new();
    let mut add = |face: usize, (edge, against): (u32, bool), untold: bool, side: bool| {
        uses.push(EdgeInUse { shell: part.faces[face].shell, edge, count: 1, face, untold, side, against });
    };
    for (face, f) in part.faces.iter().enumerate() {
        f.wires().flatten().for_each(|c| add(face, (c.edge.0, c.reversed != f.reversed), false, false));
    }
    for (face, made) in free.iter().enumerate() {
        let Some(Ok(made)) = made else { continue };
        let domain = part.faces[face].surface.natural_domain();
        let on_side = |piece: &Piece| {
            let mut constants = UvSample::constants(&piece.samples).into_iter().zip(domain);
            constants.any(|(constant, (low, high))| constant.is_some_and(|x| x == low || x == high))
        };
        for piece in made.region.loops.iter().flat_map(|l| &l.pieces) {
            if let Along::Edge(edge) = piece.along {
                add(face, (edge, false), true, on_side(piece));
            }
        }
    }
    let add = |sum: &mut EdgeInUse, next: &EdgeInUse| {
        sum.count += next.count;
        sum.face = sum.face.min(next.face);
        sum.untold |= next.untold;
        sum.side |= next.side;
        sum.against |= next.against;
    };
    summed_by_pair(part.edges.len(), uses, |used| (used.shell, used.edge), add)
}

/// An edge that may coincide with another.
pub(crate) struct Candidate {
    pub(crate) used: EdgeInUse,
    pub(crate) tolerance: f64,
    /// Whether its shell is open, and its face has topology.
    pub(crate) open: bool,
}

impl Candidate {
    /// Whether its face may have a common edge with that of another. Faces of an open shell, which nothing orients,
    /// need opposite directions there: sheets on top of each other would become a closed body, and one would be turned
    /// over.
    pub(crate) fn may_adjoin(&self, other: &Self, same_direction: bool) -> bool {
        !(self.open && other.open) || (self.used.against == other.used.against) != same_direction
    }
}

/// Whether an edge has a valid curve, range and vertices.
pub(crate) fn is_sound(part: &Part, e: &Edge) -> bool {
    let stated = e.range.0 < e.range.1 && e.curve.check().is_ok();
    let (low, high) = e.curve.domain();
    let ends = [e.start, e.end].map(|v| part.vertices.get(v.index()));
    stated && e.range.0 >= low && e.range.1 <= high && ends.iter().all(|p| p.is_some_and(|p| p.is_finite()))
}

/// An edge with so many partners is only compared with edges that have fewer.
pub(crate) const MOST_PARTNERS: usize = 64;

/// Pairs of a shell that were not compared because too many edges lie together.
pub(crate) struct LeftOut {
    /// A candidate among them.
    pub(crate) first: usize,
    pub(crate) count: usize,
}

/// Edges that a thread checks, measures or converts at a time: about a microsecond each.
pub(super) const EDGES_AT_ONCE: usize = 64;

/// The pairs of candidates to compare, and what was left out, by shell.
///
/// Of identical candidates, pairs the first with each other one. Of all others, pairs those that may share a stretch:
/// two distinct ends lie in both boxes, or one end does and a curve has knots at which they may part.
pub(crate) fn pairs(
    call: Call<'_>,
    part: &Part,
    candidates: &[Candidate],
) -> (Vec<[usize; 2]>, BTreeMap<u32, LeftOut>) {
    let edge = |k: usize| &part.edges[candidates[k].used.edge as usize];
    // Trims of one face are distinct in its domain. Only sides of the domain may meet in space.
    let trims = |a: usize, b: usize| {
        let [one, other] = [a, b].map(|k| &candidates[k].used);
        one.face == other.face && (one.untold || other.untold) && !(one.side && other.side)
    };
    let mut alike: Vec<usize> = (0..candidates.len()).collect();
    let order = |&a: &usize, &b: &usize| {
        candidates[a].used.shell.cmp(&candidates[b].used.shell).then_with(|| statement_order(edge(a), edge(b)))
    };
    alike.sort_by(order);
    let mut out = Vec::new();
    let mut firsts = Vec::new();
    for of_kind in alike.chunk_by(|a, b| order(a, b) == Ordering::Equal) {
        firsts.push(of_kind[0]);
        for &k in &of_kind[1..] {
            if trims(of_kind[0], k) { firsts.push(k) } else { out.push([of_kind[0], k]) }
        }
    }
    firsts.sort_unstable();
    let box_and_ends = |&k: &usize| -> (Aabb, [DVec3; 2]) {
        let [low, high] = around(edge(k).curve.points.iter().copied());
        // Half the tolerance for each of two boxes, along each axis.
        let slack = DVec3::splat(0.5 * candidates[k].tolerance);
        ([low - slack, high + slack], <[f64; 2]>::from(edge(k).range).map(|t| edge(k).curve.point(t)))
    };
    let (boxes, ends): (Vec<_>, Vec<_>) = call.each(EDGES_AT_ONCE, &firsts, box_and_ends).into_iter().unzip();
    let mut partners = vec![0; firsts.len()];
    let mut left_out = BTreeMap::new();
    let mut compare = |a: usize, b: usize| {
        let pair = [firsts[a], firsts[b]];
        let (shell, tolerance) = (candidates[pair[0]].used.shell, candidates[pair[0]].tolerance);
        if shell != candidates[pair[1]].used.shell || trims(pair[0], pair[1]) {
            return;
        }
        let within = |p: DVec3, of: usize| {
            let slack = DVec3::splat(0.5 * tolerance);
            p.cmpge(boxes[of][0] - slack).all() && p.cmple(boxes[of][1] + slack).all()
        };
        let inside = |of: usize, other: usize| ends[of].into_iter().filter(move |&p| within(p, other));
        let mut inside = inside(a, b).chain(inside(b, a));
        let Some(first) = inside.next() else { return };
        let simple = |k: usize| {
            let c = &edge(firsts[k]).curve;
            c.points.len() == c.degree + 1 && ends[k][0].distance(ends[k][1]) > 2.0 * tolerance
        };
        if inside.all(|p| p.distance(first) <= 2.0 * tolerance) && simple(a) && simple(b) {
            return;
        }
        // A long border may have any number of short ones along it, but many against many is quadratic.
        if partners[a] >= MOST_PARTNERS && partners[b] >= MOST_PARTNERS {
            left_out.entry(shell).or_insert(LeftOut { first: pair[0], count: 0 }).count += 1;
            return;
        }
        partners[a] += 1;
        partners[b] += 1;
        out.push(pair);
    };
    let tree = BoxTree::new(&boxes);
    for (a, own) in boxes.iter().enumerate() {
        tree.meeting(*own, |b| {
            if a < b {
                compare(a, b);
            }
        });
    }
    out.sort_unstable();
    (out, left_out)
}

/// An order in which edges are equal if all of their numbers are.
fn statement_order(a: &Edge, b: &Edge) -> Ordering {
    fn points(e: &Edge) -> impl Iterator<Item = [f64; 3]> {
        e.curve.points.iter().map(DVec3::to_array)
    }
    let or_equal = |order: Option<Ordering>| order.unwrap_or(Ordering::Equal);
    (a.curve.degree, a.curve.points.len())
        .cmp(&(b.curve.degree, b.curve.points.len()))
        .then_with(|| or_equal(points(a).partial_cmp(points(b))))
        .then_with(|| or_equal(a.range.partial_cmp(&b.range)))
        .then_with(|| or_equal(a.curve.knots.partial_cmp(&b.curve.knots)))
        .then_with(|| or_equal(a.curve.weights.partial_cmp(&b.curve.weights)))
}

/// Distance, in tolerances, that a face must extend from two of its edges to be more than a sliver between them.
const FAR: f64 = 8.0;

/// Two edges within this share of their length have nothing between them.
const ROUNDING: f64 = 1e-9;

/// Decides for the faces of a part. The boundary of a face is sampled on first use.
pub(crate) struct SliverCheck<'a> {
    part: &'a Part,
    free: &'a FreeFaces,
    rims: BTreeMap<usize, Rim>,
    /// Faces whose edges stay apart, with the tolerance.
    pub(crate) kept: BTreeMap<usize, f64>,
}

/// A face's boundary.
struct Rim {
    edges: Vec<(u32, CurveQuery)>,
    /// Whether another edge is near everywhere along it.
    thin: bool,
}

impl<'a> SliverCheck<'a> {
    pub(crate) fn new(part: &'a Part, free: &'a FreeFaces) -> Self {
        Self { part, free, rims: BTreeMap::new(), kept: BTreeMap::new() }
    }

    /// Whether two edges of a face, at most `width` apart, may merge.
    ///
    /// Cost: feet of one edge's points on all others; for thin faces, of all edges' points.
    pub(crate) fn may_join(&mut self, face: usize, pair: [u32; 2], width: f64, tolerance: f64) -> bool {
        let reach = FAR * tolerance;
        let (part, free) = (self.part, self.free);
        let rim = self.rims.entry(face).or_insert_with(|| Rim::new(part, free, face, reach));
        let of_pair = || rim.edges.iter().filter(|e| pair.contains(&e.0)).map(|e| &e.1);
        let coincide = of_pair().all(|course| width <= ROUNDING * course.length());
        let goes_away = || {
            let others = rim.edges.iter().filter(|e| !pair.contains(&e.0));
            others.flat_map(|e| e.1.samples()).any(|p| of_pair().all(|course| course.foot(p).1 > reach))
        };
        let may = coincide || !rim.thin && goes_away();
        if !may {
            self.kept.insert(face, tolerance);
        }
        may
    }
}

impl Rim {
    fn new(part: &Part, free: &FreeFaces, face: usize, reach: f64) -> Self {
        let of_pieces = free_face(free, face).into_iter().flat_map(|made| made.region.edges());
        let mut numbers: Vec<u32> = part.faces[face].wires().flatten().map(|c| c.edge.0).chain(of_pieces).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let course = |number: u32| {
            let edge = part.edges.get(number as usize).filter(|e| is_sound(part, e))?;
            Some((number, CurveQuery::new(edge)))
        };
        let edges: Vec<(u32, CurveQuery)> = numbers.into_iter().filter_map(course).collect();
        // Try the edge that was near the previous point first.
        let mut last = 0;
        let mut near = |k: usize, p| {
            let beside = |j: usize| j != k && edges[j].1.foot(p).1 <= reach;
            if !beside(last) {
                let Some(found) = (0..edges.len()).find(|&j| beside(j)) else { return false };
                last = found;
            }
            true
        };
        let thin = (0..edges.len()).all(|k| edges[k].1.samples().all(|p| near(k, p)));
        Self { edges, thin }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_of_two_faces_with_topology_in_an_open_shell_adjoin_in_opposite_directions() {
        let of = |open: bool| {
            let (shell, edge, count, face, untold, side, against) = (0, 0, 1, 0, !open, false, false);
            let used = EdgeInUse { shell, edge, count, face, untold, side, against };
            Candidate { used, tolerance: 0.1, open }
        };
        for same_direction in [false, true] {
            assert_eq!(of(true).may_adjoin(&of(true), same_direction), !same_direction);
            for [one, other] in [[true, false], [false, true], [false, false]] {
                assert!(of(one).may_adjoin(&of(other), same_direction));
            }
        }
    }
}
