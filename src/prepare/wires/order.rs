//! A wire's edges as listed to wires that close: in another order, or without the seams that a closed surface does not need.

use super::ends::ends;
use crate::model::{Coedge, Face, Loop, Part, VertexId};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, HashSet};

/// The wires of a face so far, each as the edges that it uses.
#[derive(Default)]
pub(crate) struct Given(HashSet<Vec<u32>>);

impl Given {
    /// Whether a wire is the first of its edges: one given again is taken once. One without edges is no wire given before.
    pub(crate) fn is_first(&mut self, coedges: &[Coedge]) -> bool {
        let mut edges: Vec<u32> = coedges.iter().map(|c| c.edge.0).collect();
        edges.sort_unstable();
        edges.is_empty() || self.0.insert(edges)
    }
}

/// Index of an edge of a wire, and whether it has to be turned.
pub(crate) type Taken = (usize, bool);

/// Edges by start and end, in an order in which they close, as one wire or more; none if they do not.
///
/// First as they run. Then, if at every vertex two of them end, in the sense that most of them have: files mistake senses
/// as well.
pub(crate) fn in_order(ends: &[[VertexId; 2]]) -> Option<Vec<Vec<Taken>>> {
    chained(ends).or_else(|| {
        let mut at: BTreeMap<VertexId, Vec<usize>> = BTreeMap::new();
        for (k, [a, b]) in ends.iter().enumerate() {
            at.entry(*a).or_default().push(k);
            at.entry(*b).or_default().push(k);
        }
        at.values().all(|there| there.len() == 2).then(|| turned(ends, &at))
    })
}

/// Chains of edges as they run.
fn chained(ends: &[[VertexId; 2]]) -> Option<Vec<Vec<Taken>>> {
    let mut from: BTreeMap<VertexId, Vec<usize>> = BTreeMap::new();
    for (k, [start, _]) in ends.iter().enumerate().rev() {
        from.entry(*start).or_default().push(k);
    }
    let mut wires = Vec::new();
    for first in 0..ends.len() {
        let [start, mut at] = ends[first];
        if !take(&mut from, start, first) {
            continue;
        }
        let mut wire = vec![(first, false)];
        while at != start {
            let next = *from.get(&at)?.last()?;
            take(&mut from, at, next);
            wire.push((next, false));
            at = ends[next][1];
        }
        wires.push(wire);
    }
    Some(wires)
}

/// Takes an edge from those that start at a vertex; whether it was still there.
fn take(from: &mut BTreeMap<VertexId, Vec<usize>>, at: VertexId, edge: usize) -> bool {
    let Entry::Occupied(mut there) = from.entry(at) else { return false };
    let before = there.get().len();
    there.get_mut().retain(|&k| k != edge);
    there.get().len() < before
}

/// Chains of edges of which two end at every vertex.
fn turned(ends: &[[VertexId; 2]], at: &BTreeMap<VertexId, Vec<usize>>) -> Vec<Vec<Taken>> {
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

/// The loops of a face on a surface that goes round, without the edges that one of them runs both ways; none if there are
/// none, or what is left does not close.
///
/// Such an edge bounds nothing: it is where the file opens the surface, so as to have one wire.
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
        let both_ways = |c: &&Coedge| !coedges.iter().any(|d| d.edge == c.edge && d.reversed != c.reversed);
        let rest: Vec<&Coedge> = coedges.iter().filter(both_ways).collect();
        if rest.len() == coedges.len() {
            loops.push(l.clone());
            continue;
        }
        found = true;
        let all: Option<Vec<[VertexId; 2]>> = rest.iter().map(|c| ends(part, c)).collect();
        let wires = chained(&all?)?;
        loops.extend(wires.iter().map(|wire| Loop::Edges(wire.iter().map(|w| rest[w.0].clone()).collect())));
    }
    found.then_some(loops)
}
