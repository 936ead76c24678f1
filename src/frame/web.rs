//! Triangles that know their neighbours, and the changes that keep their outline.

use crate::mesh::PatchMesh;
use glam::DVec3;
use std::collections::HashMap;

/// Heights that are rounding, as a share of the coordinates' size.
const ROUNDING: f64 = 1e-13;
/// Cosine to the surface's normal below which a triangle counts as looking inwards: none that follows its surface stands
/// as steep as this.
const STEEP: f64 = 0.05;

/// In place of a triangle that was merged away.
pub(super) const GONE: [u32; 3] = [u32::MAX; 3];

/// What a triangle looks like in space.
pub(super) struct Shape {
    corners: [u32; 3],
    /// Twice the area, times the cosine to the mean of its corners' normals less [`STEEP`].
    pub(super) outwards: f64,
    cross: DVec3,
}

impl Shape {
    pub(super) fn of(mesh: &PatchMesh, corners: [u32; 3]) -> Self {
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
        let cross = (b - a).cross(c - a);
        let normal: DVec3 = corners.iter().map(|&v| mesh.normals[v as usize].as_dvec3()).sum();
        Self { corners, outwards: cross.dot(normal.normalize_or_zero()) - STEEP * cross.length(), cross }
    }

    pub(super) fn longest(&self, mesh: &PatchMesh) -> f64 {
        let [a, b, c] = self.corners.map(|v| mesh.positions[v as usize]);
        a.distance(b).max(b.distance(c)).max(c.distance(a))
    }

    pub(super) fn is_folded(&self, mesh: &PatchMesh) -> bool {
        self.outwards < 0.0 && !self.is_flat(mesh)
    }

    /// Whether its corners are in line but for rounding.
    pub(super) fn is_flat(&self, mesh: &PatchMesh) -> bool {
        let size = self.corners.iter().map(|&v| mesh.positions[v as usize].abs().max_element()).fold(0.0, f64::max);
        self.cross.length() <= ROUNDING * size * self.longest(mesh)
    }
}

/// Triangles in place of others, some of them [`GONE`]; those that are more get the next numbers, in order.
#[derive(Clone)]
pub(super) struct Change {
    pub(super) triangles: Vec<(usize, [u32; 3])>,
}

/// Triangles that know their neighbours.
pub(super) struct Web<'a> {
    pub(super) mesh: &'a mut PatchMesh,
    /// The triangle left of each directed edge.
    pub(super) sides: HashMap<(u32, u32), usize>,
}

impl<'a> Web<'a> {
    pub(super) fn new(mesh: &'a mut PatchMesh) -> Self {
        let count = mesh.triangles.len();
        let mut web = Self { mesh, sides: HashMap::with_capacity(3 * count) };
        (0..count).for_each(|t| web.enter(t));
        web
    }

    /// Puts the new triangles in place of the old ones.
    pub(super) fn apply(&mut self, change: &Change) {
        for &(t, _) in &change.triangles {
            if t < self.mesh.triangles.len() {
                self.leave(t);
            }
        }
        for &(t, corners) in &change.triangles {
            if t == self.mesh.triangles.len() {
                self.mesh.triangles.push(corners);
            }
            self.mesh.triangles[t] = corners;
            if corners != GONE {
                self.enter(t);
            }
        }
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

    pub(super) fn has_edge(&self, a: u32, b: u32) -> bool {
        self.sides.contains_key(&(a, b)) || self.sides.contains_key(&(b, a))
    }

    /// The edges of triangle `t`, flipped.
    pub(super) fn flips(&self, t: usize) -> Vec<Change> {
        let corners = self.mesh.triangles[t];
        let flip = |k: usize| {
            let [a, b, c] = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]];
            let other = *self.sides.get(&(b, a))?;
            let d = *self.mesh.triangles[other].iter().find(|&&v| v != a && v != b)?;
            (c != d && !self.has_edge(c, d)).then(|| Change { triangles: vec![(t, [a, d, c]), (other, [d, b, c])] })
        };
        (0..3).filter_map(flip).collect()
    }
}
