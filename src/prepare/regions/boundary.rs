//! Loops of a face -> the chain of edges that they use, and whether they close.

use crate::model::{Coedge, EdgeId, Face, Part, VertexId};
use crate::prepare::trims::free_faces::FreeFace;
use crate::prepare::uv::uv_loop::{Along, Piece, UvLoop};
use crate::prepare::wires::chain::{Chain, summed};
use crate::prepare::wires::ends::ends;

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
