//! Parts -> how many of their shells are closed, by counting how often faces use each edge.

use serde::Serialize;
use std::collections::HashSet;
use trimtess::model::{EdgeId, Face, Loop, Part, ShellKind, Surface};

/// Shells by what they bound, and whether every edge is used in pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Shells {
    pub(crate) closed: usize,
    pub(crate) open: usize,
    /// Closed shells that bound voids.
    pub(crate) voids: usize,
    /// Closed shells of which the file does not say which side is inside.
    pub(crate) undirected: usize,
    /// Edges that their shell uses an odd number of times.
    pub(crate) free_edges: usize,
}

impl Shells {
    /// The shells of a part. A shell is closed when its faces use each of its edges an even number of times, and those
    /// without edges are closed surfaces.
    pub(crate) fn of(part: &Part) -> Self {
        let mut odd: HashSet<(u32, EdgeId)> = HashSet::new();
        let mut open: HashSet<u32> = HashSet::new();
        for face in &part.faces {
            let mut bounded = false;
            let mut wires: Vec<Vec<EdgeId>> = Vec::new();
            for boundary in &face.loops {
                let Loop::Edges(coedges) = boundary else { continue };
                bounded = true;
                let mut wire: Vec<EdgeId> = coedges.iter().map(|c| c.edge).collect();
                wire.sort_unstable();
                // A loop given twice is taken once.
                if wires.contains(&wire) {
                    continue;
                }
                wires.push(wire);
                for coedge in coedges {
                    let edge = (face.shell, coedge.edge);
                    if !odd.insert(edge) {
                        odd.remove(&edge);
                    }
                }
            }
            if !bounded && !closes(face) {
                open.insert(face.shell);
            }
        }
        let free_edges = odd.len();
        open.extend(odd.into_iter().map(|(shell, _)| shell));
        let mut shells = Self { free_edges, ..Self::default() };
        for (number, shell) in (0_u32..).zip(&part.shells) {
            if open.contains(&number) {
                shells.open += 1;
            } else {
                shells.closed += 1;
                shells.voids += usize::from(shell.kind == ShellKind::Void);
                shells.undirected += usize::from(shell.kind == ShellKind::Open);
            }
        }
        shells
    }

    /// Adds those of another part.
    pub(crate) fn join(&mut self, other: &Self) {
        self.closed += other.closed;
        self.open += other.open;
        self.voids += other.voids;
        self.undirected += other.undirected;
        self.free_edges += other.free_edges;
    }
}

/// Whether a face that is its whole surface has no border: each direction goes round, or ends in points.
fn closes(face: &Face) -> bool {
    let surface: &Surface = &face.surface;
    let (period, domain, poles) = (surface.period(), surface.natural_domain(), surface.poles());
    (0..2).all(|axis| {
        let (low, high) = domain[axis];
        let pole = |end: f64| poles.iter().any(|pole| pole.axis == axis && pole.at == end);
        period[axis].is_some() || pole(low) && pole(high)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use trimtess::model::shapes;

    #[test]
    fn a_loop_given_twice_closes_nothing() {
        let mut part = shapes::by_name("square").unwrap_or_default().parts.remove(0);
        let again = part.faces[0].loops.clone();
        part.faces[0].loops.extend(again);
        let shells = Shells::of(&part);
        assert_eq!((shells.closed, shells.open, shells.free_edges), (0, 1, part.edges.len()));
    }

    #[test]
    fn sheets_are_open_and_solids_closed() {
        for (name, closed, open) in
            [("square", 0, 1), ("box", 1, 0), ("cone", 1, 0), ("sphere", 1, 0), ("torus", 1, 0), ("wave", 0, 1)]
        {
            let model = shapes::by_name(name).unwrap_or_default();
            let shells = Shells::of(&model.parts[0]);
            assert_eq!((shells.closed, shells.open), (closed, open), "{name}");
        }
    }
}
