//! A part -> points that span it, and the same part at another place.

use super::{Face, FreeTrims, Part, Surface};
use glam::DVec3;

impl Part {
    /// Vertices and control points of edges. Their box, with that of [`surface_points`], measures the part's size and
    /// bounds nothing.
    pub(crate) fn points_of_edges(&self) -> impl Iterator<Item = DVec3> {
        self.vertices.iter().chain(self.edges.iter().flat_map(|edge| &edge.curve.points)).copied()
    }

    pub(crate) fn faces_without_edges(&self) -> impl Iterator<Item = &Face> {
        self.faces.iter().filter(|face| face.wires().next().is_none())
    }

    /// Moves vertices, edges and surfaces by `by`, millimetres.
    ///
    /// For parts far from the origin, whose instances then carry the distance: in coordinates of 1e12 mm every point
    /// that is computed is off by 1e-4 mm. The STEP reader does so by itself.
    pub fn translate(&mut self, by: DVec3) {
        self.vertices.iter_mut().for_each(|point| *point += by);
        self.edges.iter_mut().flat_map(|edge| &mut edge.curve.points).for_each(|point| *point += by);
        self.faces.iter_mut().for_each(|face| face.surface.translate(by));
    }
}

/// Points of a face's surface, all over the domain that it or its trims bound; none if neither does, or if the surface
/// is unsound.
pub(crate) fn surface_points(face: &Face) -> Vec<DVec3> {
    if face.surface.check().is_err() {
        return Vec::new();
    }
    let [(mut u0, mut u1), (mut v0, mut v1)] = face.surface.natural_domain();
    if let Some([low, high]) = face.trims.as_ref().map(FreeTrims::bounds) {
        // Where the surface is infinite, its trims bound it.
        let side = |of_surface: f64, of_trims: f64| if of_surface.is_finite() { of_surface } else { of_trims };
        (u0, u1, v0, v1) = (side(u0, low.x), side(u1, high.x), side(v0, low.y), side(v1, high.y));
    }
    if ![u0, u1, v0, v1].iter().all(|x| x.is_finite()) {
        return Vec::new();
    }
    let along = |a: f64, b: f64| -> [f64; 9] { std::array::from_fn(|k| a + (b - a) * (k as f64 / 8.0)) };
    face.surface.lattice(&along(u0, u1), &along(v0, v1))
}

impl Surface {
    fn translate(&mut self, by: DVec3) {
        match self {
            Self::Plane { frame }
            | Self::Cylinder { frame, .. }
            | Self::Cone { frame, .. }
            | Self::Sphere { frame, .. }
            | Self::Torus { frame, .. } => frame.origin += by,
            Self::Extrusion { curve, .. } => curve.points.iter_mut().for_each(|point| *point += by),
            Self::Revolution { curve, frame } => {
                curve.points.iter_mut().for_each(|point| *point += by);
                frame.origin += by;
            }
            Self::Nurbs(nurbs) => nurbs.points.iter_mut().for_each(|point| *point += by),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Frame3, NurbsCurve3, NurbsSurface, SurfaceKind};

    /// One of each kind.
    fn surfaces() -> Vec<Surface> {
        let frame = Frame3 { origin: DVec3::new(1.0, 2.0, 3.0), ..Frame3::WORLD };
        let curve = NurbsCurve3::line(DVec3::new(4.0, 0.0, 1.0), DVec3::new(5.0, 1.0, 2.0));
        let nurbs =
            NurbsSurface::bezier((1, 1), vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE], vec![1.0, 2.0, 3.0, 4.0]);
        vec![
            Surface::Plane { frame },
            Surface::Cylinder { frame, radius: 2.0 },
            Surface::Cone { frame, radius: 2.0, half_angle: 0.3 },
            Surface::Sphere { frame, radius: 2.0 },
            Surface::Torus { frame, major: 3.0, minor: 1.0 },
            Surface::Extrusion { curve: curve.clone(), direction: DVec3::Y },
            Surface::Revolution { curve, frame },
            Surface::Nurbs(nurbs),
        ]
    }

    #[test]
    fn lattices_and_tangents_are_those_of_single_places() {
        for surface in surfaces() {
            let (us, vs) = ([0.0, 0.3, 1.0], [0.1, 0.9]);
            let places = us.iter().flat_map(|&u| vs.iter().map(move |&v| (u, v)));
            for ((u, v), point) in places.zip(surface.lattice(&us, &vs)) {
                let all = surface.derivatives(u, v);
                assert_eq!([point, surface.point(u, v)], [all.point; 2], "{:?}", surface.kind());
                assert_eq!(surface.tangents(u, v), [all.point, all.du, all.dv], "{:?}", surface.kind());
            }
        }
    }

    #[test]
    fn surfaces_of_all_kinds_move() {
        let by = DVec3::new(-7.0, 11.0, 0.5);
        assert_eq!(surfaces().iter().map(Surface::kind).collect::<Vec<_>>(), SurfaceKind::ALL);
        for surface in surfaces() {
            let mut moved = surface.clone();
            moved.translate(by);
            for (u, v) in [(0.1, 0.2), (0.7, 0.9)] {
                let off = moved.point(u, v).distance(surface.point(u, v) + by);
                assert!(off < 1e-13, "{:?}: {off:e}", surface.kind());
            }
        }
    }
}
