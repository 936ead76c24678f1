//! Shells that should bound solids -> those whose edges are not all used in pairs.

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

/// By shell and edge: how often faces use it, and the first that does.
pub(super) fn uses(part: &Part) -> Vec<((u32, u32), (usize, usize))> {
    let mut uses: Vec<((u32, u32), usize)> = Vec::with_capacity(2 * part.edges.len());
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
            uses.extend(wire.iter().map(|&edge| ((f.shell, edge), face)));
            wires.push(wire);
        }
    }
    uses.sort_unstable();
    uses.chunk_by(|a, b| a.0 == b.0).map(|same| (same[0].0, (same.len(), same[0].1))).collect()
}

/// The shells of solids that their faces leave open. Not those with faces that are `lost`: that is told.
///
/// Edges are compared, not their places: faces that only lie side by side share none.
pub(super) fn open(part: &Part, lost: impl Fn(usize) -> bool) -> Vec<Open> {
    let uses = uses(part);
    let has_lost = |shell: u32| part.faces.iter().enumerate().any(|(face, f)| f.shell == shell && lost(face));
    let of_shells = uses.chunk_by(|a, b| a.0.0 == b.0.0);
    let open = of_shells.filter_map(|of_shell| {
        let number = of_shell[0].0.0;
        let shell = part.shells.get(number as usize).filter(|s| s.kind != ShellKind::Open)?;
        let mut free = of_shell.iter().filter(|(_, (count, _))| count % 2 == 1);
        let ((_, edge), (_, face)) = *free.next()?;
        Some(Open { entity: shell.entity, free: 1 + free.count(), edges: of_shell.len(), edge, face })
            .filter(|_| !has_lost(number))
    });
    open.collect()
}
