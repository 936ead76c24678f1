//! Edges that may coincide -> the pairs of them that are worth a comparison.
//!
//! Boxes find edges that are close. Identical edges are found by sorting, so that any number of them costs no more than
//! as many separate edges.

use super::candidate::Candidate;
use crate::math::boxes::{Aabb, BoxTree, around};
use crate::model::{Edge, Part};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// An edge with so many partners is only compared with edges that have fewer.
pub(crate) const MOST_PARTNERS: usize = 64;

/// Pairs of a shell that were not compared because too many edges lie together.
pub(crate) struct LeftOut {
    /// A candidate among them.
    pub(crate) first: usize,
    pub(crate) count: usize,
}

/// The pairs of candidates to compare, and what was left out, by shell.
///
/// Of identical candidates, pairs the first with each other one. Of all others, pairs those that may share a stretch:
/// two distinct ends lie in both boxes, or one end does and a curve has knots at which they may part.
pub(crate) fn pairs(part: &Part, candidates: &[Candidate]) -> (Vec<[usize; 2]>, BTreeMap<u32, LeftOut>) {
    let edge = |k: usize| &part.edges[candidates[k].edge as usize];
    // Trims of one face are distinct in its domain. Only sides of the domain may meet in space.
    let trims = |a: usize, b: usize| {
        let [one, other] = [&candidates[a], &candidates[b]];
        one.face == other.face && (one.untold || other.untold) && !(one.side && other.side)
    };
    let mut alike: Vec<usize> = (0..candidates.len()).collect();
    let order = |&a: &usize, &b: &usize| {
        candidates[a].shell.cmp(&candidates[b].shell).then_with(|| statement_order(edge(a), edge(b)))
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
    let box_of = |&k: &usize| {
        let [low, high] = around(edge(k).curve.points.iter().copied());
        // Half the tolerance for each of two boxes, along each axis.
        let slack = DVec3::splat(0.5 * candidates[k].tolerance);
        [low - slack, high + slack]
    };
    let boxes: Vec<Aabb> = firsts.iter().map(box_of).collect();
    let ends_of = |&k: &usize| <[f64; 2]>::from(edge(k).range).map(|t| edge(k).curve.point(t));
    let ends: Vec<[DVec3; 2]> = firsts.iter().map(ends_of).collect();
    let mut partners = vec![0; firsts.len()];
    let mut left_out = BTreeMap::new();
    let mut compare = |a: usize, b: usize| {
        let pair = [firsts[a], firsts[b]];
        let one = &candidates[pair[0]];
        if one.shell != candidates[pair[1]].shell || trims(pair[0], pair[1]) {
            return;
        }
        let tolerance = one.tolerance;
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
            left_out.entry(one.shell).or_insert(LeftOut { first: pair[0], count: 0 }).count += 1;
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
