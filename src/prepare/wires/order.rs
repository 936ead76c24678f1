//! A wire's edges as listed -> wires that close, in another order or without seams of periodic surfaces.

use super::ends::ends_of_all;
use crate::math::graph::Links;
use crate::model::{Coedge, EdgeId, Face, Loop, Part, VertexId};
use std::collections::{BTreeMap, HashSet};

/// Index of an edge in its wire, and whether to reverse it.
pub(crate) type OrderedEdge = (usize, bool);

/// Orders edges, given by start and end, into one or more closed wires. `None` if they do not close.
///
/// First tries the directions given. If that fails and exactly two edges meet at every vertex, reverses edges as
/// needed: files get directions wrong too. Each wire then runs in the direction of most of its edges.
pub(crate) fn in_order(ends: &[[VertexId; 2]]) -> Option<Vec<Vec<OrderedEdge>>> {
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
