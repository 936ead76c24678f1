//! Faces that give a loop twice -> faces that give it once, or not at all where it bounds nothing.

use super::heal::Healing;
use crate::model::{Coedge, FaceTrouble, Loop, Part, Severity};
use crate::prepare::report::finding::Finding;
use crate::prepare::trims::free_faces::FreeFaces;
use std::borrow::Cow;
use std::cell::LazyCell;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// A loop that a face gives twice, of which one is left.
pub(crate) struct Repeated {
    face: usize,
    /// Its edges, sorted.
    edges: Vec<u32>,
    /// Whether the other one was its reverse.
    reversed: bool,
}

/// The part with the first of loops of the same edges in a face, and what was left out, by face.
pub(crate) fn without_repeats(mut part: Cow<'_, Part>) -> (Cow<'_, Part>, Vec<Repeated>) {
    let (mut repeated, mut dropped) = (Vec::new(), Vec::new());
    for (face, f) in part.faces.iter().enumerate().filter(|(_, f)| f.loops.len() > 1 && !f.lost) {
        let mut known: BTreeMap<Vec<u32>, &[Coedge]> = BTreeMap::new();
        for (index, coedges) in wires(&f.loops).filter(|(_, coedges)| !coedges.is_empty()) {
            match known.entry(sorted_edges(coedges)) {
                Entry::Vacant(entry) => _ = entry.insert(coedges),
                Entry::Occupied(first) => {
                    let reversed = sorted_uses(first.get(), true) == sorted_uses(coedges, false);
                    repeated.push(Repeated { face, edges: first.key().clone(), reversed });
                    dropped.push((face, index));
                }
            }
        }
    }
    drop_loops(&mut part, &dropped);
    (part, repeated)
}

/// The part without loops that run both ways along edges that no other face uses, and a report of all that repeats.
/// `repeated`: what [`without_repeats`] left out before edges were sewn.
///
/// Such a pair bounds nothing. It cuts a closed surface open, or marks a line on it. The one that is left stays where
/// nothing else would bound its face.
pub(crate) fn without_slits<'a>(
    part: Cow<'a, Part>,
    mut repeated: Vec<Repeated>,
    free: &FreeFaces,
    done: &mut Vec<Healing>,
) -> Cow<'a, Part> {
    // Sewing makes edges of several one.
    let (mut part, again) = without_repeats(part);
    repeated.extend(again);
    repeated.sort_by_key(|repeated| repeated.face);
    let mut dropped = Vec::new();
    let shared = LazyCell::new(|| shared_edges(&part, free));
    for of_face in repeated.chunk_by(|a, b| a.face == b.face) {
        let face = of_face[0].face;
        let f = &part.faces[face];
        let mut left: BTreeMap<Vec<u32>, usize> =
            wires(&f.loops).map(|(index, coedges)| (sorted_edges(coedges), index)).collect();
        let is_closed = f.surface.check().is_ok() && !f.surface.has_border();
        for Repeated { edges, reversed, .. } in of_face {
            let is_alone = || edges.iter().all(|&edge| shared.get(edge as usize) == Some(&false));
            let is_slit = *reversed && (is_closed || left.len() > 1) && is_alone();
            let slit = if is_slit { left.remove(edges) } else { None };
            dropped.extend(slit.map(|index| (face, index)));
            let (severity, what) = match slit {
                Some(_) => (Severity::Note, FaceTrouble::BothWays),
                None => (Severity::Warning, FaceTrouble::LoopTwice),
            };
            let start = edges.first().and_then(|&edge| Some(part.edges.get(edge as usize)?.start));
            let place = start.and_then(|vertex| part.vertices.get(vertex.index()).copied());
            done.push(Healing { face, severity, told: Finding::new(place, what) });
        }
    }
    drop(shared);
    dropped.sort_unstable();
    drop_loops(&mut part, &dropped);
    part
}

/// Removes loops, given by face and index, ascending.
fn drop_loops(part: &mut Cow<'_, Part>, dropped: &[(usize, usize)]) {
    for of_face in dropped.chunk_by(|a, b| a.0 == b.0) {
        let (mut index, mut rest) = (0, of_face.iter().peekable());
        part.to_mut().faces[of_face[0].0].loops.retain(|_| {
            index += 1;
            rest.next_if(|(_, dropped)| dropped + 1 == index).is_none()
        });
    }
}

/// For each edge whether more than one face uses it.
pub(crate) fn shared_edges(part: &Part, free: &FreeFaces) -> Vec<bool> {
    const NONE: u32 = u32::MAX;
    let mut first = vec![NONE; part.edges.len()];
    let mut shared = vec![false; part.edges.len()];
    let mut add = |face: usize, edge: u32| {
        let face = u32::try_from(face).unwrap_or(NONE);
        let Some(known) = first.get_mut(edge as usize) else { return };
        shared[edge as usize] |= *known != NONE && *known != face;
        *known = face;
    };
    for (k, face) in part.faces.iter().enumerate() {
        face.wires().flatten().for_each(|c| add(k, c.edge.0));
    }
    for (k, made) in free.iter().enumerate() {
        let Some(Ok(made)) = made else { continue };
        let pieces = made.region.loops.iter().flat_map(|l| &l.pieces);
        pieces.filter_map(|piece| piece.along.edge()).for_each(|edge| add(k, edge));
    }
    shared
}

/// The loops of edges, and their indices.
fn wires(loops: &[Loop]) -> impl Iterator<Item = (usize, &[Coedge])> {
    loops.iter().enumerate().filter_map(|(index, l)| match l {
        Loop::Edges(coedges) => Some((index, &coedges[..])),
        Loop::Vertex(_) => None,
    })
}

fn sorted_edges(coedges: &[Coedge]) -> Vec<u32> {
    let mut edges: Vec<u32> = coedges.iter().map(|c| c.edge.0).collect();
    edges.sort_unstable();
    edges
}

/// The uses of a loop, or of its reverse.
fn sorted_uses(coedges: &[Coedge], turned: bool) -> Vec<(u32, bool)> {
    let mut uses: Vec<(u32, bool)> = coedges.iter().map(|c| (c.edge.0, c.reversed != turned)).collect();
    uses.sort_unstable();
    uses
}
