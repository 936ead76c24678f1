//! Loops of faces -> the edges in use, with counts per shell.

use crate::model::Part;
use crate::prepare::trims::free_faces::FreeFaces;
use crate::prepare::uv::uv_loop::{Along, Piece};
use crate::prepare::wires::order::WireSet;

/// The uses of an edge by the faces of a shell.
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
}

/// The edges in use, sorted by shell and edge.
pub(crate) fn uses(part: &Part, free: &FreeFaces) -> Vec<EdgeInUse> {
    let mut uses: Vec<EdgeInUse> = Vec::with_capacity(2 * part.edges.len());
    let mut add = |face: usize, edge: u32, untold: bool, side: bool| {
        uses.push(EdgeInUse { shell: part.faces[face].shell, edge, count: 1, face, untold, side });
    };
    for (face, f) in part.faces.iter().enumerate() {
        let mut given = WireSet::default();
        for coedges in f.wires() {
            if given.is_first(coedges) {
                coedges.iter().for_each(|c| add(face, c.edge.0, false, false));
            }
        }
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
                add(face, edge, true, on_side(piece));
            }
        }
    }
    // One number compares faster than three.
    uses.sort_unstable_by_key(|u| u128::from(u.shell) << 96 | u128::from(u.edge) << 64 | u.face as u128);
    uses.dedup_by(|next, first| {
        let same = (next.shell, next.edge) == (first.shell, first.edge);
        if same {
            first.count += 1;
            first.untold |= next.untold;
            first.side |= next.side;
        }
        same
    });
    uses
}
