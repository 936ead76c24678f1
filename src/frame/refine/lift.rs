//! A triangle and the surface -> the distance between them.
//!
//! Measured at the middles of the triangle's sides and at its centroid. For surfaces of second degree the sides are
//! exact, and a few percent may be missed inside.

use crate::frame::vertices::evaluate::evaluate_three;
use crate::mesh::TileMesh;
use crate::prepare::internals::PreparedFace;
use glam::DVec2;

/// The surface of a tile, to compare triangles with.
pub(crate) struct FaceSurface<'a> {
    pub(crate) face: &'a PreparedFace,
    /// Parameters of the vertices.
    pub(crate) uvs: &'a mut Vec<DVec2>,
}

impl FaceSurface<'_> {
    /// The middle of an edge in (u,v).
    pub(crate) fn middle(&self, a: u32, b: u32) -> DVec2 {
        self.uvs[a as usize].midpoint(self.uvs[b as usize])
    }

    /// Height of the surface above the middle of each side of a triangle, along the surface's normal.
    pub(crate) fn lifts(&self, mesh: &TileMesh, [a, b, c]: [u32; 3]) -> [f64; 3] {
        let sides = [(a, b), (b, c), (c, a)];
        let middles = sides.map(|(a, b)| self.middle(a, b));
        let on = evaluate_three(&self.face.patches, middles);
        [0, 1, 2].map(|k| {
            let ((a, b), (point, normal)) = (sides[k], on[k]);
            (point - mesh.positions[a as usize].midpoint(mesh.positions[b as usize])).dot(normal)
        })
    }

    /// Largest distance of the triangle from the surface, along the surface's normals.
    pub(crate) fn deviation(&self, mesh: &TileMesh, corners: [u32; 3]) -> f64 {
        let [x, y, z] = self.lifts(mesh, corners);
        // A quadratic that vanishes at the corners is, at the centroid, 4/9 of the sum of its values at the middles.
        [x, y, z, (x + y + z) * 4.0 / 9.0].into_iter().fold(0.0, |most, lift| most.max(lift.abs()))
    }
}
