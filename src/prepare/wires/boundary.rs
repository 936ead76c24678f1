//! Loops of a face -> the edges that they use: as a chain, which tells whether they close, and to find loops that a
//! face gives twice. Of these it keeps one, or none where they bound nothing.

use super::heal::{Healing, ends};
use crate::math::keyed::{sums_by_key, take_rows};
use crate::model::{Coedge, EdgeId, Face, FaceTrouble, Loop, Part, Severity, VertexId};
use crate::prepare::report::Finding;
use crate::prepare::trims::free_edges::{FreeFace, FreeFaces};
use crate::prepare::uv::uv_loop::{Along, Piece, UvLoop};
use std::borrow::Cow;
use std::cell::LazyCell;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// An integer chain: edges with their forward uses minus reversed uses, ascending by edge. No entry is 0.
pub(crate) type Chain = Vec<(u32, i32)>;

/// Sorts uses by edge, sums those of the same edge and drops zeros.
pub(crate) fn summed(uses: Chain) -> Chain {
    let mut uses = sums_by_key(uses);
    uses.retain(|use_| use_.1 != 0);
    uses
}

/// A face's boundary: for each loop the edges that it uses, and whether against their direction.
pub(crate) type Boundary = Vec<Vec<(u32, bool)>>;

/// The chain of loops in the unrolled plane. Each coedge counts once, however many pieces poles split it into.
pub(crate) fn of_region(part: &Part, loops: &[UvLoop]) -> Chain {
    let use_of = |piece: &Piece| match piece.along {
        Along::Edge(edge) if piece.samples[0].t == part.edges[edge as usize].range.0 => {
            Some((edge, sign(piece.reversed)))
        }
        _ => None,
    };
    summed(loops.iter().flat_map(|l| &l.pieces).filter_map(use_of).collect())
}

/// A face's boundary.
pub(crate) fn boundary(face: &Face, free: Option<&FreeFace>) -> Boundary {
    let of_piece = |piece: &Piece| Some((piece.along.edge()?, piece.reversed));
    if let Some(free) = free {
        let loops = free.region.loops.iter().map(|l| l.pieces.iter().filter_map(of_piece).collect::<Vec<_>>());
        return loops.filter(|l| !l.is_empty()).collect();
    }
    let of_coedges = |coedges: &[Coedge]| coedges.iter().map(|c| (c.edge.0, c.reversed)).collect::<Vec<_>>();
    face.wires().map(of_coedges).filter(|l| !l.is_empty()).collect()
}

/// Reverses the loops of a boundary that run against a chain.
pub(crate) fn turn(boundary: &mut Boundary, chain: &Chain) {
    for l in boundary {
        let count = |edge: u32| chain.binary_search_by_key(&edge, |c| c.0).map_or(0, |k| chain[k].1);
        if l.iter().map(|&(edge, reversed)| sign(reversed) * count(edge).signum()).sum::<i32>() < 0 {
            l.reverse();
            l.iter_mut().for_each(|use_| use_.1 = !use_.1);
        }
    }
}

/// The chain of a boundary.
pub(crate) fn of_boundary(boundary: &[Vec<(u32, bool)>]) -> Chain {
    summed(boundary.iter().flatten().map(|&(edge, reversed)| (edge, sign(reversed))).collect())
}

/// The count of a use in a chain, and the sign of a face's contribution to a volume by `S_u × S_v`.
pub(crate) fn sign(reversed: bool) -> i32 {
    if reversed { -1 } else { 1 }
}

/// Whether all edges of a face exist, their vertices are finite, and each starts at the vertex where the previous ends.
pub(crate) fn is_closed(part: &Part, face: &Face, free: Option<&FreeFace>) -> bool {
    let vertices = |edge: u32, reversed: bool| -> Option<[VertexId; 2]> {
        let ends = ends(part, EdgeId(edge), reversed)?;
        ends.iter().all(|v| part.vertices.get(v.index()).is_some_and(|p| p.is_finite())).then_some(ends)
    };
    boundary(face, free).iter().all(|l| {
        let all = l.iter().map(|&(edge, reversed)| vertices(edge, reversed));
        all.clone()
            .zip(all.cycle().skip(1))
            .all(|(one, next)| one.zip(next).is_some_and(|(one, next)| one[1] == next[0]))
    })
}

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
        let rows: Vec<usize> = of_face.iter().map(|&(_, index)| index).collect();
        take_rows(&mut part.to_mut().faces[of_face[0].0].loops, &rows);
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
        made.region.edges().for_each(|edge| add(k, edge));
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
