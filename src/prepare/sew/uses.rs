//! Loops of faces -> the edges in use, with counts per shell.

use crate::math::keyed::summed_by_pair;
use crate::model::Part;
use crate::prepare::trims::free_faces::FreeFaces;
use crate::prepare::uv::uv_loop::{Along, Piece};

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
            let first = piece.samples[0].uv;
            let on_line = |axis: usize| piece.samples.iter().all(|s| s.uv[axis] == first[axis]);
            (0..2).any(|axis| (first[axis] == domain[axis].0 || first[axis] == domain[axis].1) && on_line(axis))
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
