//! A triangle and the surface -> the distance between them.
//!
//! Measured at the middles of the triangle's sides, which tell all about a surface of second degree.

use crate::frame::vertices::evaluate::{evaluate_three, three_positions};
use crate::math::boxes::around;
use crate::mesh::TileMesh;
use crate::prepare::internals::{PreparedFace, newton_step};
use glam::{DVec2, DVec3};

/// Share of a height by which the distance may exceed it unnoticed.
const SLIGHT: f64 = 0.01;
/// Share of the chord. If the middles of a triangle's sides are within it, the whole triangle is within the chord. Its
/// distance is 0 at the corners, and such a quadratic is at most 4/3 of what it is at the middles. 0.74 instead of 3/4
/// leaves room for rounding.
const CLEAR: f64 = 0.74;
/// Triangles where the tolerance is strictest are closer to the surface than this, in its terms, even if they fold.
const MOST_OFF: f64 = 8.0;

/// The surface of a tile, to compare triangles with.
pub(crate) struct FaceSurface<'a> {
    pub(crate) face: &'a PreparedFace,
    /// Parameters of the vertices.
    pub(crate) uvs: &'a mut Vec<DVec2>,
    /// Largest distance that triangles may have anywhere.
    pub(crate) chord: f64,
    /// Largest distance that they may have in some places.
    pub(crate) loosest: f64,
}

impl FaceSurface<'_> {
    /// The middle of an edge in (u,v).
    pub(crate) fn middle(&self, a: u32, b: u32) -> DVec2 {
        self.uvs[a as usize].midpoint(self.uvs[b as usize])
    }

    /// Height of the surface above the middle of each side of a triangle. Where that may be much less than the
    /// distance, because the surface turns away below the middle, the distance.
    pub(crate) fn lifts(&self, mesh: &TileMesh, corners: [u32; 3]) -> [f64; 3] {
        let [a, b, c] = corners;
        let sides = [(a, b), (b, c), (c, a)];
        let middles = sides.map(|(a, b)| self.middle(a, b));
        let on = evaluate_three(&self.face.patches, middles);
        let below = sides.map(|(a, b)| mesh.positions[a as usize].midpoint(mesh.positions[b as usize]));
        let offs = [0, 1, 2].map(|k| on[k].0 - below[k]);
        let heights = [0, 1, 2].map(|k| offs[k].dot(on[k].1));
        if offs.iter().all(|off| off.length_squared() <= self.chord * self.chord) {
            return heights;
        }
        [0, 1, 2].map(|k| {
            let (off, (_, normal), height) = (offs[k], on[k], heights[k]);
            let bend = self.bend(mesh, corners, off, normal);
            if height.abs() + bend <= self.chord || bend <= SLIGHT * height.abs() {
                return height;
            }
            self.distance(middles[k], below[k], corners).copysign(height)
        })
    }

    /// Estimates by how much the surface turns away on the way along itself that leads below a point at `off`: half of
    /// that way times the turn, taken from `normal` and those of the corners. Infinite without a normal.
    fn bend(&self, mesh: &TileMesh, corners: [u32; 3], off: DVec3, normal: DVec3) -> f64 {
        if normal == DVec3::ZERO {
            return f64::INFINITY;
        }
        let outwards = if self.face.reversed { -normal } else { normal };
        let turns = corners.map(|v| outwards.distance_squared(mesh.normals[v as usize].as_dvec3()));
        let turn_squared = turns.into_iter().fold(0.0, f64::max);
        let way_squared = off.length_squared() - off.dot(normal).powi(2);
        0.5 * (way_squared * turn_squared).max(0.0).sqrt()
    }

    /// An upper bound of a point's distance from the surface: that from the surface at `uv`, or after a step of
    /// Newton's method from there, within the box of `corners`.
    fn distance(&self, uv: DVec2, p: DVec3, corners: [u32; 3]) -> f64 {
        let here = self.face.patches.derivatives(uv.x, uv.y);
        let off = p - here.point;
        let after = newton_step(&here, off).map(|step| {
            let [low, high] = around(corners.map(|v| self.uvs[v as usize]));
            let there = (uv + step).clamp(low, high);
            self.face.patches.point(there.x, there.y).distance(p)
        });
        after.unwrap_or(f64::INFINITY).min(off.length())
    }

    /// Whether the tolerance is much looser in some places than in others.
    pub(crate) fn is_uneven(&self) -> bool {
        self.loosest > MOST_OFF * self.chord
    }

    /// Whether a triangle that is so far from the surface must be where the tolerance is looser than elsewhere in the
    /// tile, and may be that far.
    ///
    /// Cells that are long where nobody looks, and narrow because the rest of the tile is near, fold where a row of
    /// them is closer to the next than to the surface. No other triangles between these points would do better.
    pub(crate) fn allows(&self, off: f64) -> bool {
        (MOST_OFF * self.chord..=self.loosest).contains(&off)
    }

    /// Whether the [deviation](Self::deviation) of a triangle exceeds the chord.
    pub(crate) fn exceeds(&self, mesh: &TileMesh, corners: [u32; 3]) -> bool {
        !self.is_clearly_near(mesh, corners) && self.deviation(mesh, corners) > self.chord
    }

    /// Fast test that a triangle certainly is within the chord: its sides' middles are so near the surface's points at
    /// the same parameters that normals do not matter.
    fn is_clearly_near(&self, mesh: &TileMesh, [a, b, c]: [u32; 3]) -> bool {
        let sides = [(a, b), (b, c), (c, a)];
        let Some(on) = three_positions(&self.face.patches, sides.map(|(a, b)| self.middle(a, b))) else { return false };
        let near = CLEAR * self.chord;
        sides.into_iter().zip(on).all(|((a, b), on)| {
            let below = mesh.positions[a as usize].midpoint(mesh.positions[b as usize]);
            on.distance_squared(below) <= near * near
        })
    }

    /// Largest distance of the triangle from the surface.
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
    use crate::model::shapes;
    use crate::prepare::{PrepareOptions, prepare};
    use crate::sequence::random::SplitMix;

    /// Sides that run along the inside of a torus lie so far below it that the tube turns away beneath them.
    #[test]
    fn distances_from_a_groove_are_not_less_than_they_are() {
        let prepared = prepare(shapes::by_name("torus").expect("a shape"), &PrepareOptions::DEFAULT);
        let prepared = prepared.expect("within the limits");
        let part = &prepared.parts[0];
        let face = part.face_of(&part.tiles[0]);
        let patches = &face.patches;
        let (u, v) = (&patches.breaks_u, &patches.breaks_v);
        let (du, dv, inside) = (u[1] - u[0], v[1] - v[0], v[v.len() / 2]);
        let mut uvs = vec![
            DVec2::new(u[0] + 0.05 * du, inside - 0.6 * dv),
            DVec2::new(u[0] + 0.95 * du, inside + 0.1 * dv),
            DVec2::new(u[0] + 0.05 * du, inside + 0.5 * dv),
        ];
        let at: Vec<[DVec3; 3]> = uvs.iter().map(|at| patches.tangents(at.x, at.y)).collect();
        let positions: Vec<DVec3> = at.iter().map(|at| at[0]).collect();
        let normals = at.iter().map(|[_, du, dv]| du.cross(*dv).normalize().as_vec3()).collect();
        let exact = |p: DVec3| ((p.truncate().length() - 8.0).hypot(p.z) - 3.0).abs();
        let most = exact(positions[0].midpoint(positions[1]));
        let mesh = TileMesh { positions, normals, ..TileMesh::default() };
        for chord in [0.1 * most, 0.99 * most] {
            let surface = FaceSurface { face, uvs: &mut uvs, chord, loosest: chord };
            let lift = surface.lifts(&mesh, [0, 1, 2])[0].abs();
            assert!((most..1.01 * most).contains(&lift), "{lift} instead of {most}");
        }
        // A tolerance that is large enough even so needs no more than the height.
        let surface = FaceSurface { face, uvs: &mut uvs, chord: 2.0 * most, loosest: 2.0 * most };
        assert!(surface.lifts(&mesh, [0, 1, 2])[0].abs() < 0.99 * most);
    }

    #[test]
    fn positions_alone_tell_most_triangles_that_are_near() {
        let (mut draw, mut near, mut far) = (SplitMix(3), 0, 0);
        for name in ["torus", "wave"] {
            let prepared = prepare(shapes::by_name(name).expect("a shape"), &PrepareOptions::DEFAULT);
            let prepared = prepared.expect("within the limits");
            let face = prepared.parts[0].face_of(&prepared.parts[0].tiles[0]);
            let patches = &face.patches;
            let ends = [&patches.breaks_u, &patches.breaks_v].map(|breaks| [breaks[0], breaks[1]]);
            for _ in 0..2000 {
                let size = draw.range(0.01, 1.0);
                let mut at = |[from, to]: [f64; 2]| draw.range(from, from + size * (to - from));
                let mut uvs: Vec<DVec2> = (0..3).map(|_| DVec2::new(at(ends[0]), at(ends[1]))).collect();
                let three = [uvs[0], uvs[1], uvs[2]];
                let on = evaluate_three(patches, three);
                assert_eq!(three_positions(patches, three), Some(on.map(|(position, _)| position)));
                let (positions, normals) = on.map(|(position, n)| (position, n.as_vec3())).into_iter().unzip();
                let mesh = TileMesh { positions, normals, ..TileMesh::default() };
                let mut surface = FaceSurface { face, uvs: &mut uvs, chord: f64::INFINITY, loosest: f64::INFINITY };
                let most = surface.deviation(&mesh, [0, 1, 2]);
                for share in [0.5, 0.9, 1.1, 2.0] {
                    surface.chord = share * most;
                    let exceeds = surface.deviation(&mesh, [0, 1, 2]) > surface.chord;
                    assert_eq!(surface.exceeds(&mesh, [0, 1, 2]), exceeds, "{name} {three:?}");
                    near += usize::from(surface.is_clearly_near(&mesh, [0, 1, 2]));
                    far += usize::from(exceeds);
                }
            }
        }
        assert!(near > 1000 && far > 1000, "{near} {far}");
    }

    #[test]
    fn triangles_may_be_far_off_only_where_the_tolerance_is_uneven() {
        let prepared = prepare(shapes::by_name("torus").expect("a shape"), &PrepareOptions::DEFAULT);
        let prepared = prepared.expect("within the limits");
        let face = prepared.parts[0].face_of(&prepared.parts[0].tiles[0]);
        let allows = |loosest: f64, off: f64| {
            let surface = FaceSurface { face, uvs: &mut Vec::new(), chord: 0.1, loosest };
            surface.is_uneven() && surface.allows(off)
        };
        assert!(allows(5.0, 3.0) && allows(f64::INFINITY, 3.0));
        // Near enough to be where the tolerance is strict; beyond any tolerance; an even one.
        assert!(!allows(5.0, 0.5) && !allows(5.0, 6.0) && !allows(0.1, 3.0));
    }

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
