//! A triangle and the surface -> the distance between them.
//!
//! Measured at the middles of the triangle's sides, which tell all about a surface of second degree.

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
        most_of_quadratic(self.lifts(mesh, corners))
    }
}

/// Largest absolute value on a triangle of a quadratic that vanishes at its corners and has these values at the middles
/// of its sides.
///
/// On each side that is the middle. Inside there may be another extreme: for the squared distance from the circle
/// through the corners it is the circle's centre, with the squared radius as its value.
fn most_of_quadratic(middles: [f64; 3]) -> f64 {
    let [a, b, c] = middles.map(f64::abs);
    let sides = a.max(b).max(c);
    let [x, y, z] = middles.map(f64::is_sign_negative);
    let acute = a < b + c && b < c + a && c < a + b;
    if !(x == y && y == z && acute) {
        return sides;
    }
    (4.0 * a * b * c / (2.0 * (a * b + b * c + c * a) - (a * a + b * b + c * c))).max(sides)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extreme_of_a_quadratic_is_exact() {
        const STEPS: u32 = 300;
        for middles in
            [[1.0, 1.0, 1.0], [-2.0, -1.5, -1.0], [3.0, 1.0, 1.0], [1.0, -1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 0.0]]
        {
            let at = |[p, q, r]: [f64; 3]| 4.0 * (middles[0] * p * q + middles[1] * q * r + middles[2] * r * p);
            let place = |i: u32, j: u32| [i, j, STEPS - i - j].map(|k| f64::from(k) / f64::from(STEPS));
            let all = (0..=STEPS).flat_map(|i| (0..=STEPS - i).map(move |j| place(i, j)));
            let sampled = all.map(|p| at(p).abs()).fold(0.0, f64::max);
            let most = most_of_quadratic(middles);
            assert!((most - sampled).abs() <= 1e-4 * sampled, "{middles:?}: {most} instead of {sampled}");
        }
    }
}
