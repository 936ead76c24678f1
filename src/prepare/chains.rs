//! Faces' loops -> integer chains of edges, and what they sum to over each shell: whether the mesh can be closed at all.
//!
//! A chain counts for each edge how often it is used along its direction, less how often against it. A mesh is closed because the
//! chains of its faces cancel, whatever its loops do in (u,v).

use super::free_edges::{FreeFace, FreeFaces};
use super::heal::ends;
use super::uv_loop::{Along, Piece, UvLoop};
use super::wires::Given;
use crate::model::{Coedge, EdgeId, Face, Loop, Part, VertexId};

/// Edges with how often they are used along their direction, less how often against it: ascending, none of them 0.
pub(super) type Chain = Vec<(u32, i32)>;

/// A face's boundary, loop by loop, as the edges that it uses and whether against them.
pub(super) type Boundary = Vec<Vec<(u32, bool)>>;

/// Adds up what a chain has of each edge.
pub(super) fn summed(mut uses: Chain) -> Chain {
    uses.sort_unstable_by_key(|use_| use_.0);
    uses.dedup_by(|next, first| {
        let same = next.0 == first.0;
        first.1 += if same { next.1 } else { 0 };
        same
    });
    uses.retain(|use_| use_.1 != 0);
    uses
}

/// What loops in the unrolled plane use of edges: each coedge once, however many pieces poles part it into.
pub(super) fn of_region(part: &Part, loops: &[UvLoop]) -> Chain {
    let use_of = |piece: &Piece| match piece.along {
        Along::Edge(edge) if piece.samples[0].t == part.edges[edge as usize].range.0 => {
            Some((edge, sign(piece.reversed)))
        }
        _ => None,
    };
    summed(loops.iter().flat_map(|l| &l.pieces).filter_map(use_of).collect())
}

/// A face's boundary. Loops given again are left out.
pub(super) fn boundary(face: &Face, free: Option<&FreeFace>) -> Boundary {
    let of_piece = |piece: &Piece| match piece.along {
        Along::Edge(edge) => Some((edge, piece.reversed)),
        Along::Pole(_) => None,
    };
    if let Some(free) = free {
        let loops = free.region.loops.iter().map(|l| l.pieces.iter().filter_map(of_piece).collect::<Vec<_>>());
        return loops.filter(|l| !l.is_empty()).collect();
    }
    let mut given = Given::default();
    let of_coedges = |coedges: &Vec<Coedge>| coedges.iter().map(|c| (c.edge.0, c.reversed)).collect::<Vec<_>>();
    let wires = face.loops.iter().filter_map(|l| if let Loop::Edges(coedges) = l { Some(coedges) } else { None });
    wires.filter(|coedges| given.is_first(coedges)).map(of_coedges).filter(|l| !l.is_empty()).collect()
}

/// Turns the loops of a boundary that run against a chain.
pub(super) fn turn(boundary: &mut Boundary, chain: &Chain) {
    for l in boundary {
        let count = |edge: u32| chain.binary_search_by_key(&edge, |c| c.0).map_or(0, |k| chain[k].1);
        if l.iter().map(|&(edge, reversed)| sign(reversed) * count(edge).signum()).sum::<i32>() < 0 {
            l.reverse();
            l.iter_mut().for_each(|use_| use_.1 = !use_.1);
        }
    }
}

/// The chain of a boundary.
pub(super) fn of_boundary(boundary: &[Vec<(u32, bool)>]) -> Chain {
    summed(boundary.iter().flatten().map(|&(edge, reversed)| (edge, sign(reversed))).collect())
}

/// For each edge whether more than one face uses it.
pub(super) fn shared_edges(part: &Part, free: &FreeFaces) -> Vec<bool> {
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
        let coedges = face.loops.iter().flat_map(|l| if let Loop::Edges(coedges) = l { &coedges[..] } else { &[] });
        coedges.for_each(|c| add(k, c.edge.0));
    }
    for (k, made) in free.iter().enumerate() {
        let Some(Ok(made)) = made else { continue };
        for piece in made.region.loops.iter().flat_map(|l| &l.pieces) {
            if let Along::Edge(edge) = piece.along {
                add(k, edge);
            }
        }
    }
    shared
}

fn sign(reversed: bool) -> i32 {
    if reversed { -1 } else { 1 }
}

/// Whether all edges of a face are there, each starts at the vertex where the one before it ends, and these are finite.
pub(super) fn is_closed(part: &Part, face: &Face, free: Option<&FreeFace>) -> bool {
    let vertices = |edge: u32, reversed: bool| -> Option<[VertexId; 2]> {
        let ends = ends(part, &Coedge { edge: EdgeId(edge), reversed, pcurve: None })?;
        ends.iter().all(|v| part.vertices.get(v.index()).is_some_and(|p| p.is_finite())).then_some(ends)
    };
    if free.is_some() {
        let all = boundary(face, free);
        return all.iter().all(|l| is_chain(l.iter().map(|&(edge, reversed)| vertices(edge, reversed))));
    }
    face.loops.iter().all(|l| match l {
        Loop::Edges(coedges) => is_chain(coedges.iter().map(|c| vertices(c.edge.0, c.reversed))),
        Loop::Vertex(_) => true,
    })
}

/// Whether each starts where the one before it ends, the first where the last does.
fn is_chain(mut all: impl Iterator<Item = Option<[VertexId; 2]>>) -> bool {
    let Some(first) = all.next() else { return true };
    let Some([start, mut at]) = first else { return false };
    for ends in all {
        match ends {
            Some([from, to]) if from == at => at = to,
            _ => return false,
        }
    }
    at == start
}

/// What the faces of a shell sum to on an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sum {
    pub(super) shell: u32,
    pub(super) edge: u32,
    pub(super) sum: i32,
    /// How often it is used, either way.
    pub(super) uses: u32,
    /// The first and the last face that use it.
    pub(super) faces: [u32; 2],
}

impl Sum {
    /// Whether no orientation of the faces makes it 0.
    pub(super) fn is_free(&self) -> bool {
        self.uses % 2 == 1
    }
}

/// A face's chain, as its triangles are turned.
pub(super) struct Turned<'a> {
    pub(super) face: usize,
    pub(super) shell: u32,
    pub(super) reversed: bool,
    pub(super) chain: &'a [(u32, i32)],
}

/// What faces sum to on the edges of each shell, where that is not 0. Cost: a sort of all uses.
pub(super) fn sums<'a>(faces: impl Iterator<Item = Turned<'a>>) -> Vec<Sum> {
    let of_face = |face: Turned<'a>| {
        let Turned { face, shell, reversed, chain } = face;
        let use_of = move |&(edge, count): &(u32, i32)| Sum {
            shell,
            edge,
            sum: count * sign(reversed),
            uses: count.unsigned_abs(),
            faces: [u32::try_from(face).unwrap_or(u32::MAX); 2],
        };
        chain.iter().map(use_of)
    };
    let mut all: Vec<Sum> = faces.flat_map(of_face).collect();
    all.sort_unstable_by_key(|s| (s.shell, s.edge, s.faces[0]));
    all.dedup_by(|next, first| {
        let same = (next.shell, next.edge) == (first.shell, first.edge);
        if same {
            first.sum += next.sum;
            first.uses += next.uses;
            first.faces[1] = next.faces[0];
        }
        same
    });
    all.retain(|s| s.sum != 0);
    all
}

/// What is known of a part's closedness before any mesh is made.
#[derive(Clone, Debug, Default)]
pub(super) struct Closedness {
    /// Edges that their shell uses an odd number of times.
    pub(super) free_edges: Vec<EdgeId>,
    /// Other edges on which the faces of a shell do not cancel.
    pub(super) not_orientable: Vec<EdgeId>,
    /// Whether all shells' faces cancel on all edges, and all loops are closed chains of vertices.
    pub(super) closed: bool,
}

impl Closedness {
    /// Of a part whose loops are closed, or not.
    pub(super) fn of(sums: &[Sum], loops_close: bool) -> Self {
        let of_kind = |free: bool| {
            let mut edges: Vec<EdgeId> = sums.iter().filter(|s| s.is_free() == free).map(|s| EdgeId(s.edge)).collect();
            edges.sort_unstable();
            edges.dedup();
            edges
        };
        Self { free_edges: of_kind(true), not_orientable: of_kind(false), closed: loops_close && sums.is_empty() }
    }

    /// Leaves the edges of faces free that got no tiles after all.
    pub(super) fn lose(&mut self, faces: impl Iterator<Item = Chain>) {
        for chain in faces {
            self.closed = false;
            self.free_edges.extend(chain.into_iter().map(|(edge, _)| EdgeId(edge)));
        }
        self.free_edges.sort_unstable();
        self.free_edges.dedup();
    }
}
