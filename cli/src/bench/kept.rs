//! Plans of consecutive frames and the tiles rebuilt in the later one -> how much of these was in the plan before.

use serde::Serialize;
use std::collections::HashSet;
use trimtess::frame::Plan;
use trimtess::frame::internals::TileLattice;
use trimtess::model::{PartId, TileId};
use trimtess::prepare::Prepared;

/// Fractions of the content of rebuilt tiles that was there before, over all rebuilt tiles, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct ReuseShares {
    /// Tiles with an unchanged lattice: only edges changed.
    pub(super) lattices: f64,
    /// Lattice lines inside tiles.
    pub(super) lines: f64,
    /// Cells between the same adjacent lines.
    pub(super) cells: f64,
    /// Tessellants along the boundaries of tiles.
    pub(super) tessellants: f64,
    /// Boundary segments between the same adjacent tessellants.
    pub(super) segments: f64,
}

/// A number of items, and how many of them were there before.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    kept: usize,
    all: usize,
}

impl Count {
    fn add(&mut self, kept: usize, all: usize) {
        self.kept += kept;
        self.all += all;
    }

    fn share(self) -> f64 {
        self.kept as f64 / (self.all as f64).max(1.0)
    }
}

/// Counts over frames.
#[derive(Clone, Debug, Default)]
pub(super) struct Counts {
    lattices: Count,
    lines: Count,
    cells: Count,
    tessellants: Count,
    segments: Count,
}

impl Counts {
    /// Adds the tiles `made` in the frame of plan `now`.
    pub(super) fn add(&mut self, prepared: &Prepared, before: &Plan, now: &Plan, made: &[(PartId, TileId)]) {
        for &(part, tile) in made {
            let (p, t) = (part.index(), tile.0 as usize);
            let lattices = [before, now].map(|plan| &*plan.parts[p].tiles[t]);
            self.lattice(lattices[0], lattices[1]);
            for u in prepared.parts[p].tiles[t].loops.iter().flatten() {
                let stretch = |plan: &Plan| {
                    let edge = &plan.parts[p].edges[u.edge.index()];
                    let (a, b) = (edge.breaks[u.from as usize] as usize, edge.breaks[u.to as usize] as usize);
                    edge.ts[a.min(b)..=a.max(b)].to_vec()
                };
                let (old, new) = (stretch(before), stretch(now));
                let (points, stretches) = same(&old, &new);
                self.tessellants.add(points, new.len());
                self.segments.add(stretches, new.len() - 1);
            }
        }
    }

    fn lattice(&mut self, before: &TileLattice, now: &TileLattice) {
        let is_same = before.us == now.us && before.vs == now.vs;
        self.lattices.add(usize::from(is_same), 1);
        let [(_, us), (_, vs)] = [(&before.us, &now.us), (&before.vs, &now.vs)].map(|(old, new)| {
            let (points, stretches) = same(old, new);
            self.lines.add(points - 2, new.len() - 2);
            (points, stretches)
        });
        self.cells.add(us * vs, (now.us.len() - 1) * (now.vs.len() - 1));
    }

    pub(super) fn shares(&self) -> ReuseShares {
        ReuseShares {
            lattices: self.lattices.share(),
            lines: self.lines.share(),
            cells: self.cells.share(),
            tessellants: self.tessellants.share(),
            segments: self.segments.share(),
        }
    }
}

/// How many parameters of `new` are in `old`, and how many adjacent pairs.
fn same(old: &[f64], new: &[f64]) -> (usize, usize) {
    let points: HashSet<u64> = old.iter().map(|x| x.to_bits()).collect();
    let pairs: HashSet<[u64; 2]> = old.windows(2).map(|w| [w[0].to_bits(), w[1].to_bits()]).collect();
    let kept = new.iter().filter(|x| points.contains(&x.to_bits())).count();
    (kept, new.windows(2).filter(|w| pairs.contains(&[w[0].to_bits(), w[1].to_bits()])).count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_cells_and_segments_are_counted_by_their_parameters() {
        assert_eq!(same(&[0.0, 0.5, 1.0], &[0.0, 0.25, 0.5, 1.0]), (3, 1));
        let lattice = |us: &[f64]| TileLattice { us: us.into(), vs: vec![0.0, 1.0, 2.0].into(), chord: 1.0 };
        let mut counts = Counts::default();
        counts.lattice(&lattice(&[0.0, 0.5, 1.0]), &lattice(&[0.0, 0.25, 0.5, 1.0]));
        counts.lattice(&lattice(&[0.0, 1.0]), &lattice(&[0.0, 1.0]));
        let shares = counts.shares();
        assert_eq!((shares.lattices, shares.lines, shares.cells), (0.5, 3.0 / 4.0, 4.0 / 8.0));
    }
}
