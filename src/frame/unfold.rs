//! A tile's triangles -> the same without folds: triangles that are positive in (u,v) but look inwards in space.
//!
//! Where parameter lines bend within the surface (the circles of a flat ring, the surroundings of a pole), three points may
//! change sides between the parameter plane and space; and where a boundary is coarse, a lattice point that is inside in
//! (u,v) may lie beyond the boundary's chord. Edges are flipped (C. L. Lawson, *Software for C1 surface interpolation*,
//! 1977) and such points are merged into a neighbour, judged by the surface's normals, unless a new side would leave the
//! surface by more than the chord tolerance. The tile's boundary stays, so that nothing is seen from the neighbours.

use crate::mesh::{Origin, PatchMesh};
use glam::DVec3;
use std::collections::HashMap;

/// Heights that are rounding, as a share of the coordinates' size.
const ROUNDING: f64 = 1e-13;
/// Changes per folded triangle: one is enough for most, a fan of n points needs about n.
const CHANGES: usize = 16;
/// Cosine to the surface's normal below which a triangle counts as looking inwards: none that follows its surface stands
/// as steep as this.
const STEEP: f64 = 0.05;
/// Triangles around a point that is merged; more are left alone.
const MOST_AROUND: usize = 64;
/// Share of the area looking inwards that a change has to gain, so that changes come to an end.
const LEAST_GAIN: f64 = 1e-3;

/// Changes triangles until none of the first `trimmed` looks inwards, or nothing helps that stays near the surface, of which
/// `middle` gives the point half-way between two vertices in (u,v).
///
/// First all changes are taken, since sides that are long for a while may be gone at the end; if some are too long then,
/// or folds are no smaller, once more with changes only that never make such sides.
///
/// Cost: a few nanoseconds for each of these triangles; where one is folded, a hash of all edges of the tile.
pub(super) fn unfold(mesh: &mut PatchMesh, trimmed: usize, chord: f64, middle: &dyn Fn(u32, u32) -> DVec3) {
    let folded: Vec<usize> =
        (0..trimmed).rev().filter(|&t| Shape::of(mesh, mesh.triangles[t]).is_folded(mesh)).collect();
    if folded.is_empty() {
        return;
    }
    let stated = mesh.triangles.clone();
    for most_stray in [f64::INFINITY, MOST_STRAY * chord] {
        let mut web = Web { mesh, sides: HashMap::new(), most_stray, middle };
        web.sides.reserve(3 * stated.len());
        (0..stated.len()).for_each(|t| web.enter(t));
        web.unfold(folded.clone());
        web.most_stray = MOST_STRAY * chord;
        if web.improves(&stated) {
            mesh.triangles.retain(|t| *t != GONE);
            return;
        }
        mesh.triangles.clone_from(&stated);
    }
}

/// Chord tolerances by which a side may miss the surface after all; beyond, folds are the lesser evil.
const MOST_STRAY: f64 = 1.4;

/// Share of the area looking inwards that merging a point may leave where nothing gains: of several points beyond a chord
/// the first does not help before the others are gone.
const MOST_LOSS: f64 = 8.0;

/// A triangle's sides.
fn sides([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

/// In place of a triangle that was merged away.
const GONE: [u32; 3] = [u32::MAX; 3];

/// What a triangle looks like in space.
struct Shape {
    corners: [u32; 3],
    /// Twice the area, times the cosine to the mean of its corners' normals less [`STEEP`].
    outwards: f64,
    cross: DVec3,
}

impl Shape {
    fn of(mesh: &PatchMesh, corners: [u32; 3]) -> Self {
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
        let cross = (b - a).cross(c - a);
        let normal: DVec3 = corners.iter().map(|&v| mesh.normals[v as usize].as_dvec3()).sum();
        Self { corners, outwards: cross.dot(normal.normalize_or_zero()) - STEEP * cross.length(), cross }
    }

    fn longest(&self, mesh: &PatchMesh) -> f64 {
        let [a, b, c] = self.corners.map(|v| mesh.positions[v as usize]);
        a.distance(b).max(b.distance(c)).max(c.distance(a))
    }

    fn is_folded(&self, mesh: &PatchMesh) -> bool {
        self.outwards < 0.0 && !self.is_flat(mesh)
    }

    /// Whether its corners are in line but for rounding.
    fn is_flat(&self, mesh: &PatchMesh) -> bool {
        let size = self.corners.iter().map(|&v| mesh.positions[v as usize].abs().max_element()).fold(0.0, f64::max);
        self.cross.length() <= ROUNDING * size * self.longest(mesh)
    }
}

/// Triangles in place of others; as many as there were, some of them [`GONE`].
#[derive(Clone)]
struct Change {
    triangles: Vec<(usize, [u32; 3])>,
}

/// Triangles that know their neighbours.
struct Web<'a> {
    mesh: &'a mut PatchMesh,
    /// The triangle left of each directed edge.
    sides: HashMap<(u32, u32), usize>,
    /// Distance by which new sides may miss the surface.
    most_stray: f64,
    middle: &'a dyn Fn(u32, u32) -> DVec3,
}

impl Web<'_> {
    /// Changes folded triangles, the last first, as long as that helps.
    fn unfold(&mut self, mut folded: Vec<usize>) {
        let mut left = CHANGES * folded.len();
        while let (Some(t), 1..) = (folded.pop(), left) {
            left -= 1;
            let corners = self.mesh.triangles[t];
            if corners == GONE || !Shape::of(self.mesh, corners).is_folded(self.mesh) {
                continue;
            }
            let (flips, merges) = (self.flips(t), self.merges(t));
            let gaining = self.best(flips.iter().chain(&merges), 1.0 - LEAST_GAIN).cloned();
            let Some(change) = gaining.or_else(|| self.best(merges.iter(), MOST_LOSS).cloned()) else { continue };
            for &(t, _) in &change.triangles {
                self.leave(t);
            }
            for (t, corners) in change.triangles {
                self.mesh.triangles[t] = corners;
                if corners != GONE {
                    self.enter(t);
                    if Shape::of(self.mesh, corners).is_folded(self.mesh) {
                        folded.push(t);
                    }
                }
            }
        }
    }

    /// Whether less looks inwards than in the triangles as stated, and nothing strays.
    fn improves(&self, stated: &[[u32; 3]]) -> bool {
        let changed = || stated.iter().zip(&self.mesh.triangles).filter(|(old, new)| old != new);
        let new = changed().map(|(_, new)| *new).filter(|t| *t != GONE);
        let near = new.flat_map(sides).all(|(a, b)| self.stray(a, b) <= self.most_stray);
        near && self.score(changed().map(|(_, new)| *new)).0 > self.score(changed().map(|(old, _)| *old)).0
    }

    /// By what the middle of a side misses the surface half-way between its ends in (u,v): no less than its distance.
    fn stray(&self, a: u32, b: u32) -> f64 {
        let place = |v: u32| self.mesh.positions[v as usize];
        place(a).midpoint(place(b)).distance((self.middle)(a, b))
    }

    fn enter(&mut self, t: usize) {
        let corners = self.mesh.triangles[t];
        (0..3).for_each(|k| {
            self.sides.insert((corners[k], corners[(k + 1) % 3]), t);
        });
    }

    fn leave(&mut self, t: usize) {
        let corners = self.mesh.triangles[t];
        (0..3).for_each(|k| {
            self.sides.remove(&(corners[k], corners[(k + 1) % 3]));
        });
    }

    fn has_edge(&self, a: u32, b: u32) -> bool {
        self.sides.contains_key(&(a, b)) || self.sides.contains_key(&(b, a))
    }

    /// Area that looks inwards, twice and negative, and the least height of triangles: the larger the better.
    fn score(&self, triangles: impl Iterator<Item = [u32; 3]>) -> (f64, f64) {
        triangles
            .filter(|t| *t != GONE)
            .map(|t| Shape::of(self.mesh, t))
            .fold((0.0, f64::INFINITY), |(area, height), s| {
                (area + s.outwards.min(0.0), height.min(s.outwards / s.longest(self.mesh)))
            })
    }

    /// The change that gains most of the area looking inwards, among those that leave `share` of it at most. Where several
    /// gain the same, the one that leaves the widest triangles.
    fn best<'a>(&self, changes: impl Iterator<Item = &'a Change>, share: f64) -> Option<&'a Change> {
        let mut best: Option<((f64, f64), &Change)> = None;
        for change in changes {
            let before = self.score(change.triangles.iter().map(|(t, _)| self.mesh.triangles[*t])).0;
            let (after, height) = self.score(change.triangles.iter().map(|(_, corners)| *corners));
            let score = (after - before, height);
            let better = after > share * before && best.is_none_or(|(s, _)| score > s);
            if better && self.stays(change) {
                best = Some((score, change));
            }
        }
        best.map(|(_, change)| change)
    }

    /// Whether all new triangles have an area, and new sides stay near the surface.
    fn stays(&self, change: &Change) -> bool {
        let new = || change.triangles.iter().map(|(_, t)| *t).filter(|t| *t != GONE);
        new().all(|t| !Shape::of(self.mesh, t).is_flat(self.mesh))
            && new().flat_map(sides).all(|(a, b)| self.has_edge(a, b) || self.stray(a, b) <= self.most_stray)
    }

    /// The edges of triangle `t`, flipped.
    fn flips(&self, t: usize) -> Vec<Change> {
        let corners = self.mesh.triangles[t];
        let flip = |k: usize| {
            let [a, b, c] = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]];
            let other = *self.sides.get(&(b, a))?;
            let d = *self.mesh.triangles[other].iter().find(|&&v| v != a && v != b)?;
            (c != d && !self.has_edge(c, d)).then(|| Change { triangles: vec![(t, [a, d, c]), (other, [d, b, c])] })
        };
        (0..3).filter_map(flip).collect()
    }

    /// The lattice points of triangle `t`, merged into each of their neighbours.
    fn merges(&self, t: usize) -> Vec<Change> {
        let mut changes = Vec::new();
        for v in self.mesh.triangles[t] {
            if !matches!(self.mesh.origins[v as usize], Origin::Lattice { .. }) {
                continue;
            }
            if let Some(fan) = self.fan(t, v) {
                changes.extend(fan.iter().filter_map(|&(_, to)| self.merge(v, to, &fan)));
            }
        }
        changes
    }

    /// The triangles around `v` counter-clockwise, each with the corner that follows `v` in it; `None` if there is a gap.
    fn fan(&self, t: usize, v: u32) -> Option<Vec<(usize, u32)>> {
        let mut fan = Vec::new();
        let mut at = t;
        while fan.len() < MOST_AROUND {
            let corners = self.mesh.triangles[at];
            let k = corners.iter().position(|&c| c == v)?;
            fan.push((at, corners[(k + 1) % 3]));
            at = *self.sides.get(&(v, corners[(k + 2) % 3]))?;
            if at == t {
                return Some(fan);
            }
        }
        None
    }

    /// `v` merged into `to`; `None` where that would join more than two triangles along an edge.
    fn merge(&self, v: u32, to: u32, fan: &[(usize, u32)]) -> Option<Change> {
        let common = fan.iter().filter(|&&(_, w)| w != to && self.has_edge(w, to)).count();
        (common == 2).then(|| {
            let moved = |t: usize| {
                let corners = self.mesh.triangles[t];
                if corners.contains(&to) { GONE } else { corners.map(|c| if c == v { to } else { c }) }
            };
            Change { triangles: fan.iter().map(|&(t, _)| (t, moved(t))).collect() }
        })
    }
}
