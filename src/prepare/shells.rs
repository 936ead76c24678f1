//! Shells that should bound solids -> those whose edges are not all used in pairs.

use super::free_edges::FreeFaces;
use super::uv_loop::{Along, Piece};
use crate::model::{Loop, Part, ShellKind};

/// A shell of a solid with free edges.
pub(super) struct Open {
    /// Entity number of the shell in the source file, 0 if none.
    pub(super) entity: u64,
    /// How many edges it uses an odd number of times, and how many in all.
    pub(super) free: usize,
    pub(super) edges: usize,
    /// One of them, and a face that uses it.
    pub(super) edge: u32,
    pub(super) face: usize,
}

/// What the faces of a shell make of an edge.
pub(super) struct Use {
    pub(super) shell: u32,
    pub(super) edge: u32,
    /// How often they use it.
    pub(super) count: usize,
    /// The first that does.
    pub(super) face: usize,
    /// Whether it bounds a face whose edges were made for it, as it came without topology.
    pub(super) untold: bool,
    /// Whether it lies along a side of such a face's domain.
    pub(super) side: bool,
}

/// The edges in use, by shell and edge.
pub(super) fn uses(part: &Part, free: &FreeFaces) -> Vec<Use> {
    let mut uses: Vec<Use> = Vec::with_capacity(2 * part.edges.len());
    let mut add = |face: usize, edge: u32, untold: bool, side: bool| {
        uses.push(Use { shell: part.faces[face].shell, edge, count: 1, face, untold, side });
    };
    for (face, f) in part.faces.iter().enumerate() {
        let mut wires: Vec<Vec<u32>> = Vec::new();
        for l in &f.loops {
            let Loop::Edges(coedges) = l else { continue };
            let mut wire: Vec<u32> = coedges.iter().map(|c| c.edge.0).collect();
            wire.sort_unstable();
            // A loop given twice is taken once.
            if wires.contains(&wire) {
                continue;
            }
            wire.iter().for_each(|&edge| add(face, edge, false, false));
            wires.push(wire);
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
    uses.sort_unstable_by_key(|u| (u.shell, u.edge, u.face));
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

/// The shells of solids that their faces leave open. Not those with faces that are `lost`: that is told.
///
/// Edges are compared, not their places: faces that only lie side by side share none.
pub(super) fn open(part: &Part, free: &FreeFaces, lost: impl Fn(usize) -> bool) -> Vec<Open> {
    let uses = uses(part, free);
    let has_lost = |shell: u32| part.faces.iter().enumerate().any(|(face, f)| f.shell == shell && lost(face));
    let of_shells = uses.chunk_by(|a, b| a.shell == b.shell);
    let open = of_shells.filter_map(|of_shell| {
        let number = of_shell[0].shell;
        let shell = part.shells.get(number as usize).filter(|s| s.kind != ShellKind::Open)?;
        let mut free = of_shell.iter().filter(|u| u.count % 2 == 1);
        let Use { edge, face, .. } = *free.next()?;
        Some(Open { entity: shell.entity, free: 1 + free.count(), edges: of_shell.len(), edge, face })
            .filter(|_| !has_lost(number))
    });
    open.collect()
}
