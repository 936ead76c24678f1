//! A surface and one of its parameters -> the curve along which that parameter is constant.

use super::curve::Carrier;
use crate::model::{CurveKind, Frame3, NurbsCurve3, Surface};
use glam::DVec3;

/// The curve through (`u`, `v`) along `axis`: 0 along u, 1 along v. Exact; it runs as the parameter grows. `u` and `v`
/// are natural parameters within the surface's domain.
pub(super) fn isoline(surface: &Surface, axis: usize, [u, v]: [f64; 2]) -> Carrier {
    let point = surface.point(u, v);
    match (surface, axis) {
        (Surface::Plane { frame }, 0) => Carrier::Line { point, along: frame.x },
        (Surface::Plane { .. } | Surface::Cylinder { .. } | Surface::Cone { .. } | Surface::Extrusion { .. }, 1) => {
            Carrier::Line { point, along: surface.tangents(u, v)[2] }
        }
        (Surface::Extrusion { curve, direction }, _) => {
            let points = curve.points.iter().map(|p| *p + *direction * v).collect();
            Carrier::Spline { curve: NurbsCurve3 { points, ..curve.clone() }, kind: CurveKind::Spline }
        }
        (Surface::Sphere { frame, radius }, 1) => meridian(frame, u, 0.0, *radius),
        (Surface::Torus { frame, major, minor }, 1) => meridian(frame, u, *major, *minor),
        (Surface::Revolution { curve, frame }, 1) => {
            let (sin, cos) = libm::sincos(u);
            let turn = |p: DVec3| DVec3::new(p.x * cos - p.y * sin, p.x * sin + p.y * cos, p.z);
            let points = curve.points.iter().map(|p| frame.place(turn(frame.local(*p)))).collect();
            Carrier::Spline { curve: NurbsCurve3 { points, ..curve.clone() }, kind: CurveKind::Spline }
        }
        (Surface::Nurbs(net), _) => {
            Carrier::Spline { curve: net.iso_line(1 - axis, [v, u][axis]).curve(), kind: CurveKind::Spline }
        }
        (
            Surface::Plane { frame }
            | Surface::Cylinder { frame, .. }
            | Surface::Cone { frame, .. }
            | Surface::Sphere { frame, .. }
            | Surface::Torus { frame, .. }
            | Surface::Revolution { frame, .. },
            _,
        ) => {
            let out = frame.radial(point);
            let radius = out.length();
            Carrier::Round { frame: Frame3 { origin: point - out, ..*frame }, a: radius, b: radius }
        }
    }
}

/// The circle of radius `minor` in the half plane at angle `u` about the axis, its centre at distance `major`.
fn meridian(frame: &Frame3, u: f64, major: f64, minor: f64) -> Carrier {
    let (sin, cos) = libm::sincos(u);
    let x = frame.x * cos + frame.y * sin;
    let frame = Frame3 { origin: frame.origin + x * major, x, y: frame.z, z: x.cross(frame.z) };
    Carrier::Round { frame, a: minor, b: minor }
}
