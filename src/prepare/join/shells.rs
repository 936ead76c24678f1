//! Shells -> the sums of their loops on each edge: which shells are closed.

use crate::model::{Face, Loop, Part, ShellKind};
use crate::prepare::sew::pairs::{EdgeInUse, uses};
use crate::prepare::trims::free_edges::FreeFaces;
use crate::prepare::wires::boundary::{boundary, sign, without_repeats, without_slits};
use std::borrow::Cow;
use std::collections::{BTreeSet, HashSet};

/// Counts of a part's closed and open shells as stated, before anything is repaired or lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct Shells {
    /// Shells whose loops can be oriented to sum to 0 on every edge. Faces without edges must be closed surfaces.
    pub closed: usize,
    /// All other shells.
    pub open: usize,
    /// Closed shells that bound voids.
    pub voids: usize,
    /// Closed shells for which the file does not say which side is inside.
    pub undirected: usize,
    /// Edges that their shell uses an odd number of times.
    pub free_edges: usize,
}

impl Shells {
    /// Counts the shells of a part. A loop that its face gives twice counts once, or not at all where it bounds
    /// nothing.
    ///
    /// Edges count as shared if they are the same edge, not if they only coincide. Loops are oriented by the edges that
    /// two of them share, whatever their orientation in the file. Cost: about 200 ns per coedge.
    #[must_use]
    pub fn of(part: &Part) -> Self {
        let (single, repeated) = without_repeats(Cow::Borrowed(part));
        let part = &*without_slits(single, repeated, &Vec::new(), &mut Vec::new());
        let unbounded = part.faces.iter().filter(|face| !face.loops.iter().any(|l| matches!(l, Loop::Edges(_))));
        // An unsound surface closes nothing.
        let is_open = |face: &&Face| face.surface.check().is_err() || face.surface.has_border();
        let mut open: BTreeSet<u32> = unbounded.filter(is_open).map(|face| face.shell).collect();
        let mut shells = Self::default();
        for (shell, uses) in unbalanced(part) {
            open.insert(shell);
            shells.free_edges += uses % 2;
        }
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

    /// Adds the counts of another part.
    pub fn join(&mut self, other: &Self) {
        self.closed += other.closed;
        self.open += other.open;
        self.voids += other.voids;
        self.undirected += other.undirected;
        self.free_edges += other.free_edges;
    }
}

/// Edges on which the loops of a shell do not cancel in any orientation: for each, its shell and number of uses.
fn unbalanced(part: &Part) -> Vec<(u32, usize)> {
    /// An edge as a loop uses it.
    struct Row {
        shell: u32,
        edge: u32,
        wire: usize,
        sign: i32,
    }
    let mut rows: Vec<Row> = Vec::with_capacity(2 * part.edges.len());
    let mut wires = 0;
    for face in &part.faces {
        for wire in boundary(face, None) {
            let row = |(edge, reversed)| Row { shell: face.shell, edge, wire: wires, sign: sign(reversed) };
            rows.extend(wire.into_iter().map(row));
            wires += 1;
        }
    }
    rows.sort_unstable_by_key(|row| (row.shell, row.edge, row.wire));
    let of_edges = || rows.chunk_by(|a, b| (a.shell, a.edge) == (b.shell, b.edge));
    // For each wire its neighbours, and whether both keep or both reverse their direction.
    let mut neighbours: Vec<Vec<(usize, bool)>> = vec![Vec::new(); wires];
    for of_edge in of_edges() {
        if let [a, b] = of_edge
            && a.wire != b.wire
        {
            neighbours[a.wire].push((b.wire, a.sign != b.sign));
            neighbours[b.wire].push((a.wire, a.sign != b.sign));
        }
    }
    let (mut turned, mut seen) = (vec![false; wires], vec![false; wires]);
    for first in 0..wires {
        if !seen[first] {
            connected(&neighbours, (first, false), &mut seen).into_iter().for_each(|(wire, is)| turned[wire] = is);
        }
    }
    let sum = |of_edge: &[Row]| of_edge.iter().map(|row| row.sign * sign(turned[row.wire])).sum::<i32>();
    of_edges().filter(|of_edge| sum(of_edge) != 0).map(|of_edge| (of_edge[0].shell, of_edge.len())).collect()
}

/// What is connected to the first, and whether it is turned. `neighbours`: for each its neighbours, and whether both
/// are turned alike. The nearest decide where neighbours contradict each other.
pub(super) fn connected(
    neighbours: &[Vec<(usize, bool)>],
    first: (usize, bool),
    seen: &mut [bool],
) -> Vec<(usize, bool)> {
    seen[first.0] = true;
    let mut group = vec![first];
    let mut next = 0;
    while let Some(&(from, turned)) = group.get(next) {
        next += 1;
        for &(other, alike) in &neighbours[from] {
            if !std::mem::replace(&mut seen[other], true) {
                group.push((other, turned == alike));
            }
        }
    }
    group
}

/// A shell of a solid with free edges.
pub(crate) struct Open {
    /// Entity number of the shell in the source file, 0 if none.
    pub(crate) entity: u64,
    /// Number of edges used an odd number of times, and of all edges used.
    pub(crate) free: usize,
    pub(crate) edges: usize,
    /// One of them, and a face that uses it.
    pub(crate) edge: u32,
    pub(crate) face: usize,
}

/// The open shells of solids. Excludes shells with `lost` faces, which are reported themselves.
pub(crate) fn open(part: &Part, free: &FreeFaces, lost: impl Fn(usize) -> bool) -> Vec<Open> {
    let uses = uses(part, free);
    let of_lost: HashSet<u32> =
        part.faces.iter().enumerate().filter(|(face, _)| lost(*face)).map(|(_, f)| f.shell).collect();
    let of_shells = uses.chunk_by(|a, b| a.shell == b.shell);
    let open = of_shells.filter_map(|of_shell| {
        let number = of_shell[0].shell;
        let shell = part.shells.get(number as usize).filter(|s| s.kind != ShellKind::Open)?;
        let mut free = of_shell.iter().filter(|u| u.count % 2 == 1);
        let EdgeInUse { edge, face, .. } = *free.next()?;
        Some(Open { entity: shell.entity, free: 1 + free.count(), edges: of_shell.len(), edge, face })
            .filter(|_| !of_lost.contains(&number))
    });
    open.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Surface, shapes};

    #[test]
    fn a_loop_given_twice_closes_nothing() {
        let mut part = shapes::by_name("square").unwrap_or_default().parts.remove(0);
        let again = part.faces[0].loops.clone();
        part.faces[0].loops.extend(again);
        let shells = Shells::of(&part);
        assert_eq!((shells.closed, shells.open, shells.free_edges), (0, 1, part.edges.len()));
    }

    #[test]
    fn loops_that_no_orientation_balances_leave_a_shell_open() {
        // A box with an edge that both faces use in the same direction: each edge has two uses, but a wire is open.
        let mut part = shapes::by_name("box").unwrap_or_default().parts.remove(0);
        let Loop::Edges(coedges) = &mut part.faces[0].loops[0] else { panic!("a box has edges") };
        coedges[0].reversed = !coedges[0].reversed;
        let shells = Shells::of(&part);
        assert_eq!((shells.closed, shells.open, shells.free_edges), (0, 1, 0));
        // Reversed as a whole, the wire closes the box again.
        let Loop::Edges(coedges) = &mut part.faces[0].loops[0] else { panic!("a box has edges") };
        coedges.iter_mut().skip(1).for_each(|c| c.reversed = !c.reversed);
        assert_eq!(Shells::of(&part).closed, 1);
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

    #[test]
    fn a_face_on_an_unsound_surface_leaves_its_shell_open() {
        let mut part = shapes::by_name("wave").unwrap_or_default().parts.remove(0);
        let Surface::Nurbs(net) = &mut part.faces[0].surface else { panic!("a wave is a spline surface") };
        net.points.clear();
        part.faces[0].loops.clear();
        let shells = Shells::of(&part);
        assert_eq!((shells.closed, shells.open), (0, 1));
    }
}
