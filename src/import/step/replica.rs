//! Curves and surfaces -> the same moved by a similarity, exactly, for replicas. Parameters that are lengths scale
//! along.

use super::curve::Carrier;
use crate::model::{Frame3, NurbsCurve3, Surface};
use glam::{DAffine3, DVec3};

/// A rigid motion with an optional uniform scale and reflection, from a Cartesian transformation operator.
#[derive(Clone, Copy, Debug)]
pub(super) struct Similarity {
    motion: DAffine3,
    scale: f64,
}

impl Similarity {
    /// `motion` must have orthogonal axes of equal length, as from
    /// [`Geometry::motion`](super::place::Geometry::motion).
    pub(super) fn new(motion: DAffine3) -> Self {
        Self { scale: motion.matrix3.x_axis.length(), motion }
    }

    fn point(&self, p: DVec3) -> DVec3 {
        self.motion.transform_point3(p)
    }

    fn vector(&self, v: DVec3) -> DVec3 {
        self.motion.transform_vector3(v)
    }

    fn unit(&self, v: DVec3) -> DVec3 {
        self.vector(v) / self.scale
    }

    /// The frame with the images of the first two axes, for plane curves and planes.
    fn plane(&self, frame: &Frame3) -> Frame3 {
        let (x, y) = (self.unit(frame.x), self.unit(frame.y));
        Frame3 { origin: self.point(frame.origin), x, y, z: x.cross(y) }
    }

    /// The frame with the images of the first and third axes, and whether a reflection reversed the angle.
    fn axis(&self, frame: &Frame3) -> (Frame3, bool) {
        let (x, z) = (self.unit(frame.x), self.unit(frame.z));
        let y = z.cross(x);
        (Frame3 { origin: self.point(frame.origin), x, y, z }, y.dot(self.unit(frame.y)) < 0.0)
    }

    pub(super) fn curve(&self, mut curve: NurbsCurve3) -> NurbsCurve3 {
        self.points(&mut curve.points);
        curve
    }

    fn points(&self, points: &mut [DVec3]) {
        points.iter_mut().for_each(|p| *p = self.point(*p));
    }

    pub(super) fn carrier(&self, carrier: Carrier) -> Carrier {
        let s = self.scale;
        match carrier {
            Carrier::Line { point, along } => Carrier::Line { point: self.point(point), along: self.vector(along) },
            Carrier::Round { frame, a, b } => Carrier::Round { frame: self.plane(&frame), a: a * s, b: b * s },
            Carrier::Hyperbola { frame, a, b } => Carrier::Hyperbola { frame: self.plane(&frame), a: a * s, b: b * s },
            Carrier::Parabola { frame, focal } => Carrier::Parabola { frame: self.plane(&frame), focal: focal * s },
            Carrier::Spline { curve, kind } => Carrier::Spline { curve: self.curve(curve), kind },
        }
    }

    /// The moved surface, and whether its normal is opposite to that of the original parameters: surfaces about an axis
    /// count angles right-handed, and a reflection reverses that.
    pub(super) fn surface(&self, mut surface: Surface) -> (Surface, bool) {
        let (s, mut turned) = (self.scale, false);
        let mut about = |frame: &mut Frame3| (*frame, turned) = self.axis(frame);
        match &mut surface {
            Surface::Plane { frame } => *frame = self.plane(frame),
            Surface::Cylinder { frame, radius }
            | Surface::Cone { frame, radius, .. }
            | Surface::Sphere { frame, radius } => {
                about(frame);
                *radius *= s;
            }
            Surface::Torus { frame, major, minor } => {
                about(frame);
                (*major, *minor) = (*major * s, *minor * s);
            }
            Surface::Revolution { curve, frame } => {
                about(frame);
                self.points(&mut curve.points);
            }
            Surface::Extrusion { curve, direction } => {
                self.points(&mut curve.points);
                *direction = self.vector(*direction);
            }
            Surface::Nurbs(net) => self.points(&mut net.points),
        }
        (surface, turned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DQuat};

    /// A rotation, a scale of two, and reflections along axes.
    fn motion(signs: DVec3) -> DAffine3 {
        let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7));
        let scale = DMat3::from_diagonal(2.0 * signs);
        DAffine3::from_mat3_translation(turn * scale, DVec3::new(3.0, -1.0, 4.0))
    }

    #[test]
    fn moved_surfaces_keep_their_points_and_report_flipped_normals() {
        let frame = Frame3::from_axis(DVec3::X, DVec3::new(0.3, 0.2, 1.0), DVec3::Y).expect("an axis");
        let arc = NurbsCurve3::arc(&Frame3::WORLD, 2.0, 1.0, 0.1, 1.2);
        for surface in [
            Surface::Plane { frame },
            Surface::Cylinder { frame, radius: 2.0 },
            Surface::Cone { frame, radius: 2.0, half_angle: 0.3 },
            Surface::Sphere { frame, radius: 2.0 },
            Surface::Torus { frame, major: 5.0, minor: 2.0 },
            Surface::Revolution { curve: arc.clone(), frame },
            Surface::Extrusion { curve: arc, direction: DVec3::new(0.0, 1.0, 3.0) },
        ] {
            for signs in [DVec3::ONE, DVec3::new(1.0, -1.0, 1.0), DVec3::NEG_ONE] {
                let (motion, mirror) = (motion(signs), signs.y < 0.0);
                let (moved, turned) = Similarity::new(motion).surface(surface.clone());
                let (u, v) = (0.4, 0.6);
                // Parameters that are lengths are twice as long.
                let (su, sv) = match surface {
                    Surface::Plane { .. } => (2.0, 2.0),
                    Surface::Cylinder { .. } | Surface::Cone { .. } => (1.0, 2.0),
                    _ => (1.0, 1.0),
                };
                // If the angle is reversed, the same place has the opposite angle.
                let at = (if turned { -u } else { u } * su, v * sv);
                let image = moved.point(at.0, at.1);
                let expected = motion.transform_point3(surface.point(u, v));
                assert!(image.distance(expected) < 1e-12, "{surface:?} {signs}");
                // The moved normal of the original parameters: a reflection flips cross products.
                let stated = motion.transform_vector3(surface.normal(u, v).expect("a normal"));
                let stated = if mirror { -stated } else { stated };
                let own = moved.normal(at.0, at.1).expect("a normal");
                assert_eq!(own.dot(stated) < 0.0, turned, "{surface:?} {signs}");
            }
        }
    }
}
