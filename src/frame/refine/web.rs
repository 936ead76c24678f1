//! Triangles with adjacency, and local changes that keep their outline.

use crate::frame::trim::chain::same_boundary;
use crate::math::bits;
use crate::math::keyed::Buckets;
use crate::math::lanes::larger;
use crate::math::{BitMix, Seeded};
use crate::mesh::{Origin, TileMesh};
use glam::{DVec2, DVec3, Vec3};
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

/// Rounding error of a triangle's height, relative to its coordinates.
const ROUNDING: f64 = 1e-13;
/// Cosine to the surface's normal below which a triangle counts as steep. No triangle that follows its surface does.
const STEEP: f64 = 0.05;

/// Factor by which a comparison must hold to be certain despite rounding.
const ROOM: f64 = 2.0;

/// Points with more triangles than this are neither merged nor removed.
const MOST_AROUND: usize = 64;

/// Marks a removed triangle.
pub(crate) const GONE: [u32; 3] = [u32::MAX; 3];

/// Orientation and area of a triangle in space.
pub(crate) struct TriangleShape {
    corners: [u32; 3],
    /// Twice the area times the cosine to the mean of its corners' normals.
    pub(crate) facing: f64,
    /// Twice the area times (that cosine - [`STEEP`]).
    pub(crate) outwards: f64,
    cross: DVec3,
}

impl TriangleShape {
    pub(crate) fn of(mesh: &TileMesh, corners: [u32; 3]) -> Self {
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
        let cross = (b - a).cross(c - a);
        let normal: DVec3 = corners.iter().map(|&v| mesh.normals[v as usize].as_dvec3()).sum();
        let facing = cross.dot(normal.normalize_or_zero());
        Self { corners, facing, outwards: facing - STEEP * cross.length(), cross }
    }

    pub(crate) fn longest(&self, mesh: &TileMesh) -> f64 {
        let [a, b, c] = self.corners.map(|v| mesh.positions[v as usize]);
        a.distance(b).max(b.distance(c)).max(c.distance(a))
    }

    /// Whether it faces inwards, is steep or flat.
    pub(crate) fn is_wrong(mesh: &TileMesh, corners: [u32; 3]) -> bool {
        let shape = Self::of(mesh, corners);
        shape.outwards < 0.0 || shape.is_flat(mesh)
    }

    /// Fast test that a triangle is certainly not [wrong](Self::is_wrong): the same comparisons of squares, without
    /// roots and with room for rounding. `least` is [`TriangleShape::clear_area`].
    #[inline(always)]
    pub(crate) fn is_clearly_right((positions, normals): (&[DVec3], &[Vec3]), corners: [u32; 3], least: f64) -> bool {
        let [a, b, c] = corners.map(|v| positions[v as usize]);
        let cross = (b - a).cross(c - a);
        let [n, o, p] = corners.map(|v| normals[v as usize]);
        // Single precision is exact enough, because the sum of three unit normals is at most 3 long, and counts as that
        // long.
        let normal = (n + o + p).as_dvec3();
        let (facing, area) = (cross.dot(normal), cross.length_squared());
        let steep = ROOM * STEEP * 3.0;
        facing > 0.0 && area > least && facing * facing > steep * steep * area
    }

    /// The square of twice the area above which no triangle of a mesh is flat, however long.
    #[inline(always)]
    pub(crate) fn clear_area(positions: &[DVec3]) -> f64 {
        let size = positions.iter().fold([0.0; 3], |most, p| {
            let p = p.to_array();
            [0, 1, 2].map(|k| larger(p[k].abs(), most[k]))
        });
        let size = size.into_iter().fold(0.0, larger);
        let height = ROOM * ROUNDING * size;
        // No side is longer than the diagonal of the box. Squares that underflow prove nothing.
        (height * height * 12.0 * size * size).max(f64::MIN_POSITIVE)
    }

    /// Whether its corners are collinear up to rounding.
    pub(crate) fn is_flat(&self, mesh: &TileMesh) -> bool {
        let size = self.corners.iter().map(|&v| mesh.positions[v as usize].abs().max_element()).fold(0.0, f64::max);
        self.cross.length() <= ROUNDING * size * self.longest(mesh)
    }
}

/// Replaces triangles by index; [`GONE`] removes one. Additional triangles have the next indices, in order.
#[derive(Clone)]
pub(crate) struct Change {
    pub(crate) triangles: Vec<(usize, [u32; 3])>,
}

impl Change {
    /// The triangles that it makes.
    pub(crate) fn made(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.triangles.iter().map(|(_, corners)| *corners).filter(|corners| *corners != GONE)
    }
}

/// Triangles with adjacency.
pub(crate) struct Web<'a> {
    pub(crate) mesh: &'a mut TileMesh,
    /// Triangles by corner ([`Web::one`] of it), before any change. A few changes in a large tile must not cost a hash
    /// table of all its edges.
    around: Buckets<u32>,
    /// The current triangle, if any, left of each directed edge of changed triangles, with ends by [`Web::one`].
    changed: HashMap<(u32, u32), Option<usize>, BuildHasherDefault<BitMix>>,
    poles: Poles,
}

impl<'a> Web<'a> {
    /// Cost: two passes over the triangles.
    pub(crate) fn new(mesh: &'a mut TileMesh) -> Self {
        let poles = Poles::of(mesh);
        let corners = (0..).zip(mesh.triangles.as_flattened()).map(|(k, &v)| (poles.one(v), k / 3));
        let around = Buckets::of(mesh.positions.len(), corners);
        Self { mesh, around, changed: HashMap::default(), poles }
    }

    /// The representative of all vertices at the position of `v`.
    pub(crate) fn one(&self, v: u32) -> u32 {
        self.poles.one(v)
    }

    /// All vertices at the position of `v`, itself first.
    pub(crate) fn same(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let one = self.one(v);
        let others = self.poles.rows.get(&one).into_iter().flatten().copied().filter(move |&other| other != v);
        std::iter::once(v).chain(others)
    }

    /// The same triangle. Of several vertices at a pole, it uses the one whose parameters are nearest to the other
    /// corners'.
    pub(crate) fn with_near_parameters(&self, corners: [u32; 3], uvs: &[DVec2]) -> [u32; 3] {
        let uv = |v: u32| uvs[v as usize];
        let mut near = corners;
        for k in 0..3 {
            let others = 0.5 * (uv(corners[(k + 1) % 3]) + uv(corners[(k + 2) % 3]));
            let distance = |v: &u32| uv(*v).distance_squared(others);
            near[k] = self
                .same(corners[k])
                .min_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)))
                .unwrap_or(corners[k]);
        }
        near
    }

    /// The triangle left of a directed edge, if there is one.
    pub(crate) fn left_of(&self, a: u32, b: u32) -> Option<usize> {
        let edge = (self.one(a), self.one(b));
        if let Some(now) = self.changed.get(&edge) {
            return *now;
        }
        // No triangle at this edge has changed.
        let runs = |t: u32| {
            let [p, q, r] = self.mesh.triangles[t as usize].map(|v| self.one(v));
            [(p, q), (q, r), (r, p)].contains(&edge)
        };
        self.around_fewer(edge.0, edge.1).iter().rev().find(|&&t| runs(t)).map(|&t| t as usize)
    }

    /// The corner of triangle `t` that is neither `a` nor `b`.
    pub(crate) fn third(&self, t: usize, a: u32, b: u32) -> Option<u32> {
        let [a, b] = [a, b].map(|v| self.one(v));
        self.mesh.triangles[t].into_iter().find(|&v| self.one(v) != a && self.one(v) != b)
    }

    /// Whether the new triangles have the same boundary as the old ones. Where more than two triangles share an edge,
    /// [`left_of`](Self::left_of) finds one of several, and a flip with the wrong one would open the mesh.
    pub(crate) fn keeps_outline(&self, change: &Change) -> bool {
        let ones = |corners: [u32; 3]| corners.map(|v| self.one(v));
        let old = change.triangles.iter().filter_map(|(t, _)| self.mesh.triangles.get(*t).copied());
        let new = change.triangles.iter().map(|(_, corners)| *corners);
        same_boundary(old.filter(|t| *t != GONE).map(ones), new.filter(|t| *t != GONE).map(ones))
    }

    /// Applies a change, which must [keep the outline](Self::keeps_outline).
    pub(crate) fn apply(&mut self, change: &Change) {
        for &(t, _) in &change.triangles {
            if t < self.mesh.triangles.len() {
                self.record(t, None);
            }
        }
        for &(t, corners) in &change.triangles {
            if t == self.mesh.triangles.len() {
                self.mesh.triangles.push(corners);
            }
            self.mesh.triangles[t] = corners;
            if corners != GONE {
                self.record(t, Some(t));
            }
        }
    }

    /// Takes all changes back. `stated` are the triangles before any.
    pub(crate) fn restore(&mut self, stated: &[[u32; 3]]) {
        self.mesh.triangles.clear();
        self.mesh.triangles.extend_from_slice(stated);
        self.changed.clear();
    }

    /// Records which triangle is left of the edges of triangle `t`: itself, or none once it is gone.
    fn record(&mut self, t: usize, left: Option<usize>) {
        let [a, b, c] = self.mesh.triangles[t].map(|v| self.one(v));
        self.changed.extend([(a, b), (b, c), (c, a)].map(|edge| (edge, left)));
    }

    /// The triangles around `v`, counter-clockwise from `t`, each with its corner after `v`. `None` if there is a gap,
    /// or more than [`MOST_AROUND`] triangles.
    pub(crate) fn fan(&self, t: usize, v: u32) -> Option<Vec<(usize, u32)>> {
        let mut fan = Vec::new();
        let mut at = t;
        while fan.len() < MOST_AROUND {
            let corners = self.mesh.triangles[at];
            let k = corners.iter().position(|&c| self.one(c) == self.one(v))?;
            fan.push((at, corners[(k + 1) % 3]));
            at = self.left_of(v, corners[(k + 2) % 3])?;
            if at == t {
                return Some(fan);
            }
        }
        None
    }

    /// Whether there is a triangle left of an edge, in either direction.
    pub(crate) fn has_edge(&self, a: u32, b: u32) -> bool {
        let (a, b) = (self.one(a), self.one(b));
        let [there, back] = [(a, b), (b, a)].map(|edge| self.changed.get(&edge));
        if [there, back].into_iter().flatten().any(Option::is_some) {
            return true;
        }
        let runs = |t: &u32| {
            let [p, q, r] = self.mesh.triangles[*t as usize].map(|v| self.one(v));
            let has = |edge| [(p, q), (q, r), (r, p)].contains(&edge);
            there.is_none() && has((a, b)) || back.is_none() && has((b, a))
        };
        self.around_fewer(a, b).iter().any(runs)
    }

    /// The triangles, before any change, around that end of an edge that has fewer. A pole may have thousands.
    fn around_fewer(&self, a: u32, b: u32) -> &[u32] {
        let [here, there] = [a, b].map(|v| self.around.at(v));
        if there.len() < here.len() { there } else { here }
    }

    /// The flips of the edges of triangle `t`.
    pub(crate) fn flips(&self, t: usize) -> Vec<Change> {
        let corners = self.mesh.triangles[t];
        let flip = |k: usize| {
            let [a, b, c] = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]];
            let other = self.left_of(b, a)?;
            let d = self.third(other, a, b)?;
            (self.one(c) != self.one(d) && !self.has_edge(c, d))
                .then(|| Change { triangles: vec![(t, [a, d, c]), (other, [d, b, c])] })
        };
        (0..3).filter_map(flip).collect()
    }
}

/// Vertices at the same position. A pole is a row of tessellants, one for each parameter.
#[derive(Default)]
struct Poles {
    /// Representative of each boundary vertex: the first of its row, or itself. Empty without poles.
    first: Vec<u32>,
    /// By representative: all vertices of the row, ascending.
    rows: HashMap<u32, Vec<u32>>,
}

impl Poles {
    fn of(mesh: &TileMesh) -> Self {
        let on_boundary = |o: &Origin| matches!(o, Origin::Edge { .. } | Origin::Border { .. });
        let count = mesh.origins.iter().position(|o| !on_boundary(o)).unwrap_or(mesh.origins.len());
        let place = |v: usize| bits::of_point(mesh.positions[v]);
        let mut places: HashMap<[u64; 3], u32, Seeded> = HashMap::default();
        for v in 1..count {
            if mesh.positions[v] == mesh.positions[v - 1] {
                places.entry(place(v)).or_insert(v as u32 - 1);
            }
        }
        if places.is_empty() {
            return Self::default();
        }
        let mut poles = Self { first: (0..count as u32).collect(), rows: HashMap::new() };
        for v in 0..count {
            if let Some(&first) = places.get(&place(v)) {
                poles.first[v] = first;
                poles.rows.entry(first).or_default().push(v as u32);
            }
        }
        poles
    }

    fn one(&self, v: u32) -> u32 {
        self.first.get(v as usize).copied().unwrap_or(v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Flips, removes and splits triangles of a fan, and compares adjacency with the triangles themselves.
    #[test]
    fn adjacency_matches_the_triangles_after_any_change() {
        let mut mesh = TileMesh { positions: vec![DVec3::ZERO; 7], ..TileMesh::default() };
        mesh.triangles = (0..6).map(|k| [0, 1 + k, 1 + (k + 1) % 6]).collect();
        let mut web = Web::new(&mut mesh);
        let changes: [&[(usize, [u32; 3])]; 3] = [
            &[(0, [0, 1, 3]), (1, [1, 2, 3])],
            &[(3, GONE)],
            // A new vertex in the middle of an edge makes a triangle more on either side.
            &[(2, [0, 3, 7]), (6, [7, 3, 4]), (4, [0, 5, 6])],
        ];
        for change in changes {
            web.apply(&Change { triangles: change.to_vec() });
            let triangles = web.mesh.triangles.clone();
            for (a, b) in (0..9).flat_map(|a| (0..9).map(move |b| (a, b))).filter(|(a, b)| a != b) {
                let runs = |t: &[u32; 3]| (0..3).any(|k| (t[k], t[(k + 1) % 3]) == (a, b));
                assert_eq!(web.left_of(a, b), triangles.iter().position(runs), "{a} to {b} after {change:?}");
            }
        }
        assert_eq!(web.mesh.triangles.len(), 7);
    }
}
