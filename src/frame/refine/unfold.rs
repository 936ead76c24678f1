//! A tile's triangles -> the same with folds removed where possible. Folds are positive in (u,v) but face inwards in
//! space.
//!
//! Folds have two causes. Where parameter lines bend within the surface (the circles of a flat ring, the neighbourhood
//! of a pole), three points may have opposite orientations in (u,v) and in space. Where a boundary is coarse, a lattice
//! point that is inside in (u,v) may lie beyond the boundary's chord.
//!
//! Edges are flipped (C. L. Lawson, *Software for C1 surface interpolation*, 1977) and such points are merged into a
//! neighbour, judged by the surface's normals, unless the triangles would leave the surface by more than the chord
//! tolerance. If no such step helps, the neighbourhood is retriangulated (`refill`). The tile's boundary never changes,
//! so neighbours are not affected.

use super::lift::FaceSurface;
use super::web::{Change, GONE, TriangleShape, Web};
use crate::mesh::{Origin, TileMesh};
use glam::DVec3;
use std::cell::{Cell, LazyCell};
use std::collections::{HashMap, HashSet, VecDeque};

/// Most changes per folded triangle. One is enough for most, a fan of n points needs about n.
const CHANGES: usize = 16;
/// Points that one with more points around it may be merged into: the nearest ones.
const MOST_TARGETS: usize = 8;
/// Least share of the inward-facing area that a change must remove, so that changes terminate.
const LEAST_GAIN: f64 = 1e-3;

/// Changes triangles until none of the `doubtful` is folded, or nothing helps that stays within the chord. These are
/// ascending indices; all other triangles must be [clearly right](TriangleShape::is_clearly_right), or between lattice
/// points only.
///
/// The first pass takes all changes, since triangles that deviate for a while may be gone at the end. If some still
/// deviate, or the folds did not shrink, a second pass from the original triangles only takes changes within the
/// tolerance.
///
/// `is_noise`: whether the tile's loops meet themselves or were repaired, so that little can be expected. Returns
/// whether any triangle changed. Cost: if one is folded, a few nanoseconds for every triangle of the tile.
pub(crate) fn unfold(mesh: &mut TileMesh, doubtful: &[usize], is_noise: bool, surface: &FaceSurface<'_>) -> bool {
    let is_wrong = |t: usize| TriangleShape::is_wrong(mesh, mesh.triangles[t]);
    let mut folded: Vec<usize> = doubtful.iter().copied().rev().filter(|&t| is_wrong(t)).collect();
    if surface.is_uneven() {
        let off = |t: usize| (surface.deviation(mesh, mesh.triangles[t]), t);
        let mut off: Vec<_> = folded.into_iter().map(off).filter(|(off, _)| !surface.allows(*off)).collect();
        // The last ones come first: those where the tolerance is strict.
        off.sort_by(|a, b| b.0.total_cmp(&a.0));
        folded = off.into_iter().map(|(_, t)| t).collect();
    }
    if folded.is_empty() {
        return false;
    }
    let stated = mesh.triangles.clone();
    let mut left = match is_noise {
        _ if surface.is_uneven() => MOST_WEIGHED_OF_UNEVEN,
        true => MOST_WEIGHED_OF_NOISE,
        false => MOST_WEIGHED,
    };
    let clear_area = TriangleShape::clear_area(&mesh.positions);
    let mut web = Web::new(mesh);
    for chord in [f64::INFINITY, surface.chord] {
        let near = Near { surface, chord, clear_area, left: Cell::new(left) };
        web.unfold(folded.clone(), &near);
        left = near.left.get();
        if web.improves(&stated, &Near { surface, chord: surface.chord, clear_area, left: Cell::new(0) }) {
            web.mesh.triangles.retain(|t| *t != GONE);
            return true;
        }
        web.restore(&stated);
    }
    false
}

/// Most neighbourhoods of a tile that are retriangulated in vain in a pass. Where a few do not help, none does: of 450
/// in the corpora, the three that help are the first of their tiles.
const MOST_VAIN_FILLINGS: usize = 4;

/// Most triangles of changes weighed per tile, in both passes together. Each takes about 0.15 µs. Tiles of the corpus
/// weigh up to 13 000, a rim five thousand times as long as wide more than 16 000; folds that remain after that are
/// noise.
const MOST_WEIGHED: usize = 1 << 15;

/// [`MOST_WEIGHED`] for tiles whose loops meet themselves or were repaired. Their triangles lie in several sheets, or
/// along edges out of order, and no change unfolds them.
const MOST_WEIGHED_OF_NOISE: usize = 1 << 12;

/// [`MOST_WEIGHED`] for tiles whose tolerance [is uneven](FaceSurface::is_uneven): where it is loose, rows of long
/// cells fold whatever is changed.
const MOST_WEIGHED_OF_UNEVEN: usize = 1 << 9;

/// Triangles that a retriangulation counts for in [`MOST_WEIGHED`], in addition to those of the changes it finds. Most
/// of its work goes into changes that are rejected.
const FILLING: usize = 32;

/// Up to this many changed triangles are searched linearly.
const FEW: usize = 32;

/// The tolerance for changes, and the work left.
struct Near<'a> {
    surface: &'a FaceSurface<'a>,
    chord: f64,
    /// The tile's [`TriangleShape::clear_area`].
    clear_area: f64,
    /// Triangles that may still be weighed.
    left: Cell<usize>,
}

impl Near<'_> {
    /// Counts the triangles of a change that is weighed. Returns whether they were still allowed.
    fn spend(&self, change: &Change) -> bool {
        let left = self.left.get().checked_sub(change.triangles.len());
        self.left.set(left.unwrap_or(0));
        left.is_some()
    }
}

/// Factor by which merging a point may increase the inward-facing area if no change reduces it. Of several points
/// beyond a chord, merging the first one does not help before the others are merged.
const MOST_LOSS: f64 = 8.0;

impl Web<'_> {
    /// Changes folded triangles while that helps: from the end of the list, where those come that a change folds. The
    /// others wait for a change nearby.
    fn unfold(&mut self, folded: Vec<usize>, near: &Near<'_>) {
        let mut left = CHANGES * folded.len();
        let mut vain = 0;
        let mut folded = VecDeque::from(folded);
        let mut waiting = Waiting::default();
        while let (Some(t), 1..) = (folded.pop_back(), left) {
            left -= 1;
            if near.left.get() == 0 {
                break;
            }
            let corners = self.mesh.triangles[t];
            if corners == GONE || !TriangleShape::is_wrong(self.mesh, corners) {
                continue;
            }
            let (flips, merges) = (self.flips(t), self.merges(t));
            let flips: Vec<Choice> = flips.into_iter().map(|flip| self.choice(vec![flip])).collect();
            let gaining = self.best(flips.iter().chain(&merges), 1.0 - LEAST_GAIN, near).cloned();
            let change = gaining.or_else(|| self.best(merges.iter(), MOST_LOSS, near).cloned());
            let retriangulated = || {
                let change = if vain < MOST_VAIN_FILLINGS { self.retriangulate(t, near) } else { None };
                vain += usize::from(change.is_none());
                change
            };
            let Some(change) = change.or_else(retriangulated) else {
                let beside = self.beside(t).into_iter().map(|t| self.mesh.triangles[t]);
                waiting.add(t, beside.chain([corners]).flatten().map(|v| self.one(v)));
                continue;
            };
            let all = change.triangles.iter().flat_map(|(t, new)| [self.mesh.triangles.get(*t), Some(new)]);
            for v in all.flatten().filter(|t| **t != GONE).flatten() {
                waiting.leave(self.one(*v), |t| folded.push_front(t));
            }
            self.apply(&change);
            let is_folded = |corners: [u32; 3]| corners != GONE && TriangleShape::is_wrong(self.mesh, corners);
            folded.extend(change.triangles.iter().filter(|(_, corners)| is_folded(*corners)).map(|(t, _)| *t));
        }
    }

    /// Retriangulates the neighbourhood of a folded triangle so that less of it faces inwards, or else is steep.
    fn retriangulate(&self, t: usize, near: &Near<'_>) -> Option<Change> {
        near.left.set(near.left.get().saturating_sub(FILLING));
        let gain = |change: &Change| {
            let old = self.wrong(change.triangles.iter().map(|(t, _)| self.mesh.triangles[*t]));
            let new = self.wrong(change.triangles.iter().map(|(_, corners)| *corners));
            is_less(new, old).then_some([old[0] - new[0], old[1] - new[1]])
        };
        let is_flat = |t: [u32; 3]| TriangleShape::of(self.mesh, t).is_flat(self.mesh);
        let fitting = self
            .refills(t, near.surface.uvs)
            .filter(|change| near.spend(change))
            .filter_map(|change| Some((gain(&change)?, change)))
            .filter(|(_, change)| !change.made().any(is_flat) && self.stays(change, near));
        fitting.max_by(|(a, _), (b, _)| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))).map(|(_, change)| change)
    }

    /// Twice the inward-facing area, the same including steep triangles, and the number of flat triangles.
    fn wrong(&self, triangles: impl Iterator<Item = [u32; 3]>) -> [f64; 3] {
        triangles.filter(|t| *t != GONE).map(|t| TriangleShape::of(self.mesh, t)).fold(
            [0.0; 3],
            |[inwards, all, flat], s| {
                let is_flat = f64::from(u8::from(s.is_flat(self.mesh)));
                [inwards - s.facing.min(0.0), all - s.outwards.min(0.0), flat + is_flat]
            },
        )
    }

    /// Whether the triangles are less folded than the original ones, and deviate no further than these or the chord.
    fn improves(&self, stated: &[[u32; 3]], near: &Near<'_>) -> bool {
        let pairs = stated.iter().zip(&self.mesh.triangles);
        // Few of a tile's triangles change.
        let all: Vec<_> = pairs.filter(|(old, new)| old != new).collect();
        let changed = || all.iter().copied();
        is_less(self.wrong(changed().map(|(_, new)| *new)), self.wrong(changed().map(|(old, _)| *old)))
            && self.is_as_near(changed(), near)
            && self.covers(changed(), near.chord)
    }

    /// Whether the new triangles deviate no further than the old ones or the chord.
    fn is_as_near<'a>(
        &self,
        changed: impl Iterator<Item = (&'a [u32; 3], &'a [u32; 3])> + Clone,
        near: &Near<'_>,
    ) -> bool {
        let deviation = |t: &[u32; 3]| near.surface.deviation(self.mesh, *t);
        let of_old = LazyCell::new(|| changed.clone().map(|(old, _)| deviation(old)).fold(0.0, f64::max));
        let new = changed.clone().map(|(_, new)| new).filter(|new| **new != GONE);
        new.map(deviation).all(|new| new <= near.chord || new <= *of_old)
    }

    /// Whether the middles of the new triangles' sides are within a distance of the old triangles. The converse is not
    /// required: what is cut off beyond a boundary's chord is not part of the face.
    fn covers<'a>(&self, changed: impl Iterator<Item = (&'a [u32; 3], &'a [u32; 3])> + Clone, within: f64) -> bool {
        let place = |t: &[u32; 3]| t.map(|v| self.mesh.positions[v as usize]);
        let old: Vec<[DVec3; 3]> = changed.clone().map(|(old, _)| place(old)).collect();
        // Nearly all are near an old triangle at one of their ends, so many triangles get an index by corner.
        let mut around: HashMap<u32, Vec<usize>> = HashMap::new();
        if old.len() > FEW {
            for (k, (corners, _)) in changed.clone().enumerate() {
                corners.iter().for_each(|&v| around.entry(v).or_default().push(k));
            }
        }
        let near = |[a, b]: [u32; 2]| {
            let p = self.mesh.positions[a as usize].midpoint(self.mesh.positions[b as usize]);
            let is_near = |triangle: &[DVec3; 3]| distance_to_triangle(p, triangle) <= within;
            let of_ends = [a, b].into_iter().filter_map(|v| around.get(&v)).flatten();
            of_ends.map(|&k| &old[k]).any(is_near) || old.iter().any(is_near)
        };
        let new = changed.map(|(_, new)| *new).filter(|new| *new != GONE);
        new.flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]).all(near)
    }

    /// Changes of the same triangles.
    fn choice(&self, changes: Vec<Change>) -> Choice {
        let mut choice = Choice { changes, area: 0.0, has_flat: false };
        for (t, _) in choice.changes.first().map_or(&[][..], |change| &change.triangles) {
            let shape = TriangleShape::of(self.mesh, self.mesh.triangles[*t]);
            choice.area += shape.outwards.min(0.0);
            choice.has_flat |= shape.is_flat(self.mesh);
        }
        choice
    }

    /// The change that most reduces the inward-facing area, among those that leave at most `share` of it. Ties go to
    /// the change with the widest triangles.
    fn best<'a>(&self, choices: impl Iterator<Item = &'a Choice>, share: f64, near: &Near<'_>) -> Option<&'a Change> {
        let mut best: Option<((f64, f64), &Change)> = None;
        let places = (&self.mesh.positions[..], &self.mesh.normals[..]);
        let changes = choices.flat_map(|choice| choice.changes.iter().map(move |change| (choice, change)));
        for (Choice { area: before, has_flat, .. }, change) in changes.filter(|(_, change)| near.spend(change)) {
            // Flat triangles do not show in the sums. Removing one is an improvement if nothing folds.
            let is_enough = |after: f64| {
                (after > share * before || *has_flat && after >= *before)
                    && best.is_none_or(|((gain, _), _)| after - before >= gain)
            };
            // The sum only falls. Most merges fold too much within a few triangles.
            let mut after = 0.0;
            let is_better = is_enough(after)
                && change.made().all(|t| {
                    TriangleShape::is_clearly_right(places, t, near.clear_area) || {
                        let shape = TriangleShape::of(self.mesh, t);
                        after += shape.outwards.min(0.0);
                        !shape.is_flat(self.mesh) && is_enough(after)
                    }
                });
            if !is_better {
                continue;
            }
            let shapes = change.made().map(|t| TriangleShape::of(self.mesh, t));
            let heights = shapes.map(|shape| shape.outwards / shape.longest(self.mesh));
            let score = (after - before, heights.fold(f64::INFINITY, f64::min));
            if best.is_none_or(|(s, _)| score > s) && self.stays(change, near) {
                best = Some((score, change));
            }
        }
        best.map(|(_, change)| change)
    }

    /// Whether the new triangles keep the outline, and stay within the tolerance of the surface and the old ones.
    fn stays(&self, change: &Change, to: &Near<'_>) -> bool {
        if !self.keeps_outline(change) {
            return false;
        }
        if to.chord == f64::INFINITY {
            return true;
        }
        let changed = || change.triangles.iter().map(|(t, new)| (&self.mesh.triangles[*t], new));
        self.is_as_near(changed(), to) && self.covers(changed(), to.chord)
    }

    /// Merges of each lattice point of triangle `t` into each of its neighbours.
    fn merges(&self, t: usize) -> Vec<Choice> {
        let corners = self.mesh.triangles[t].into_iter();
        let inner = corners.filter(|v| matches!(self.mesh.origins[*v as usize], Origin::Lattice { .. }));
        inner.filter_map(|v| Some(self.choice(self.merges_of(v, &self.fan(t, v)?)))).collect()
    }

    /// Merges of `v` into each point of its fan, or the nearest of many, unless an edge would get more than two
    /// triangles.
    fn merges_of(&self, v: u32, fan: &[(usize, u32)]) -> Vec<Change> {
        let from = self.mesh.positions[v as usize];
        let distance = |to: u32| from.distance_squared(self.mesh.positions[to as usize]);
        let mut farthest = f64::INFINITY;
        if fan.len() > MOST_TARGETS {
            let mut distances: Vec<f64> = fan.iter().map(|&(_, to)| distance(to)).collect();
            farthest = *distances.select_nth_unstable_by(MOST_TARGETS - 1, f64::total_cmp).1;
        }
        // A third neighbour in the fan would give an edge more than two triangles.
        let keeps_edges = |a: u32| {
            let others = fan.iter().filter(|&&(_, b)| self.one(a) != self.one(b) && self.has_edge(a, b));
            others.count() == 2
        };
        let merge = |to: u32| {
            let one = self.one(to);
            let moved = |t: usize| {
                let corners = self.mesh.triangles[t];
                if corners.iter().any(|&c| self.one(c) == one) {
                    GONE
                } else {
                    corners.map(|c| if c == v { to } else { c })
                }
            };
            Change { triangles: fan.iter().map(|&(t, _)| (t, moved(t))).collect() }
        };
        let targets = fan.iter().map(|&(_, to)| to).filter(|&to| distance(to) <= farthest && keeps_edges(to));
        targets.map(merge).collect()
    }
}

/// Changes of the same triangles, of which one may be applied.
struct Choice {
    changes: Vec<Change>,
    /// Twice the area of these triangles that are steep or face inwards, negated.
    area: f64,
    /// Whether one of them is flat.
    has_flat: bool,
}

/// Folded triangles that nothing helps, until a triangle at one of the points around them changes.
#[derive(Default)]
struct Waiting {
    triangles: HashSet<usize>,
    /// By point. May list triangles that have left already.
    at: HashMap<u32, Vec<usize>>,
}

impl Waiting {
    fn add(&mut self, t: usize, points: impl Iterator<Item = u32>) {
        self.triangles.insert(t);
        points.for_each(|v| self.at.entry(v).or_default().push(t));
    }

    /// Removes the triangles waiting at a point and calls `each` with them, oldest first.
    fn leave(&mut self, point: u32, mut each: impl FnMut(usize)) {
        let there = self.at.remove(&point).unwrap_or_default();
        there.into_iter().filter(|t| self.triangles.remove(t)).for_each(&mut each);
    }
}

/// Whether `new` is better than `old`, both by [`Web::wrong`]: first by inward-facing area, then steep area, then flat
/// triangles.
fn is_less(new: [f64; 3], old: [f64; 3]) -> bool {
    let least = |old: f64| (1.0 - LEAST_GAIN) * old;
    let as_much = |k: usize| new[k] <= old[k];
    new[0] < least(old[0]) || as_much(0) && (new[1] < least(old[1]) || as_much(1) && new[2] < old[2])
}

/// Distance of `p` from a triangle.
fn distance_to_triangle(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let inside = [(a, b), (b, c), (c, a)].into_iter().all(|(a, b)| (b - a).cross(p - a).dot(normal) >= 0.0);
    if inside && normal != DVec3::ZERO {
        return (p - a).dot(normal.normalize()).abs();
    }
    let to_side = |a: DVec3, b: DVec3| {
        let (along, length) = (b - a, (b - a).length_squared());
        let share = if length > 0.0 { ((p - a).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
        p.distance(a + along * share)
    };
    to_side(a, b).min(to_side(b, c)).min(to_side(c, a))
}
