//! Surfaces -> domain, periods and poles of their natural parameters; closed-form inversion.

use super::nurbs_surface::extent;
use super::{Frame3, NurbsCurve3, Surface};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Two border rows are equal if they are this close, as a share of the size of the lines from one to the other. Some
/// files print the coordinates of closed surfaces with seven digits.
const SAME_ROW: f64 = 1e-6;
/// Ends of a meridian within this share of the size lie on the axis: files print axis directions with as few as seven
/// digits.
const SAME_POINT: f64 = 1e-7;
/// Points of a NURBS border within this distance count as one: a share of the size of the lines next to it.
/// Files round each point by itself.
const SAME_END: f64 = 1e-5;

/// A line of constant parameter that is a single point in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pole {
    /// The constant parameter: 0 for u, 1 for v.
    pub axis: usize,
    /// Its value.
    pub at: f64,
    /// The point in space.
    pub point: DVec3,
}

impl Surface {
    /// First and last natural parameter in u and in v; infinite where the surface is unbounded.
    ///
    /// Angles of full turns are given as 0 to 2π, though the surface continues beyond.
    #[must_use]
    pub fn natural_domain(&self) -> [(f64, f64); 2] {
        const ALL: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
        match self {
            Self::Plane { .. } => [ALL, ALL],
            Self::Cylinder { .. } | Self::Cone { .. } => [(0.0, TAU), ALL],
            Self::Sphere { .. } => [(0.0, TAU), (-FRAC_PI_2, FRAC_PI_2)],
            Self::Torus { .. } => [(0.0, TAU), (0.0, TAU)],
            Self::Extrusion { curve, .. } => [curve.domain(), ALL],
            Self::Revolution { curve, .. } => [(0.0, TAU), curve.domain()],
            Self::Nurbs(surface) => surface.domain().into(),
        }
    }

    /// The periods in u and v; `None` where the surface does not repeat.
    ///
    /// 2π for angles; the length of the domain for closed curves and NURBS. Surfaces that close in a pole are not
    /// periodic: they do not continue there.
    #[must_use]
    pub fn period(&self) -> [Option<f64>; 2] {
        match self {
            Self::Plane { .. } => [None, None],
            Self::Cylinder { .. } | Self::Cone { .. } | Self::Sphere { .. } => [Some(TAU), None],
            Self::Torus { .. } => [Some(TAU), Some(TAU)],
            Self::Extrusion { curve, .. } => [curve_period(curve), None],
            Self::Revolution { curve, frame } => {
                let on_axis = axis_distance(curve, frame, curve.domain().0) <= axis_tolerance(curve, frame);
                [Some(TAU), curve_period(curve).filter(|_| !on_axis)]
            }
            Self::Nurbs(surface) => {
                let domain = <[_; 2]>::from(surface.domain());
                let sizes = [0, 1].map(|axis| surface.size_along(axis));
                let is_collapsed = |axis: usize, at: f64| surface.is_collapsed(axis, at, SAME_END * sizes[1 - axis]);
                // If every line in a direction is a single point, the direction closes trivially, without a period. Nor
                // does a direction that closes in a pole have one.
                [0, 1].map(|axis| {
                    let across = 1 - axis;
                    let is_periodic = surface.is_closed(axis, SAME_ROW * sizes[axis])
                        && !surface.samples(across).all(|t| is_collapsed(across, t))
                        && !is_collapsed(axis, domain[axis].0);
                    is_periodic.then_some(domain[axis].1 - domain[axis].0)
                })
            }
        }
    }

    /// The parameter lines that are single points: a sphere's ends, apexes, collapsed NURBS borders, and ends of a
    /// rotated curve on the axis. Inner points of a rotated curve are not checked: a curve that meets the axis must be
    /// cut there.
    #[must_use]
    pub fn poles(&self) -> Vec<Pole> {
        let parallel = |at: f64| Pole { axis: 1, at, point: self.point(0.0, at) };
        match self {
            Self::Plane { .. } | Self::Cylinder { .. } | Self::Extrusion { .. } => Vec::new(),
            Self::Cone { frame, radius, half_angle } => {
                let at = -radius / libm::tan(*half_angle);
                vec![Pole { axis: 1, at, point: frame.origin + frame.z * at }]
            }
            Self::Sphere { frame, radius } => [-FRAC_PI_2, FRAC_PI_2]
                .map(|at| Pole { axis: 1, at, point: frame.origin + frame.z * radius.copysign(at) })
                .to_vec(),
            Self::Torus { frame, major, minor } if minor >= major => {
                let at = libm::acos(-major / minor);
                let height = (minor * minor - major * major).sqrt();
                let pole = |at: f64, z: f64| Pole { axis: 1, at, point: frame.origin + frame.z * z };
                if height > 0.0 { vec![pole(at, height), pole(TAU - at, -height)] } else { vec![pole(PI, 0.0)] }
            }
            Self::Torus { .. } => Vec::new(),
            Self::Revolution { curve, frame } => {
                let (a, b) = curve.domain();
                let tol = axis_tolerance(curve, frame);
                [a, b].into_iter().filter(|&t| axis_distance(curve, frame, t) <= tol).map(parallel).collect()
            }
            Self::Nurbs(surface) => {
                let ((u0, u1), (v0, v1)) = surface.domain();
                // Not by the whole net: the end of a long strip is short, and no point.
                let tolerances = [1, 0].map(|along| SAME_END * surface.size_along(along));
                [(0, u0), (0, u1), (1, v0), (1, v1)]
                    .into_iter()
                    .filter(|&(axis, at)| surface.is_collapsed(axis, at, tolerances[axis]))
                    .map(|(axis, at)| {
                        let point = if axis == 0 { surface.point(at, v0) } else { surface.point(u0, at) };
                        Pole { axis, at, point }
                    })
                    .collect()
            }
        }
    }

    /// Finds the natural parameters of the surface point nearest to `p`, with angles in [0, 2π) (a sphere's v in
    /// [-π/2, π/2]).
    ///
    /// In closed form for planes, cylinders, cones, spheres and tori. `None` for the other kinds, and if the parameters
    /// are not finite. On the axis, u is arbitrary (0). Considers both nappes of a cone and both sheets of a
    /// self-intersecting torus.
    #[must_use]
    pub fn invert(&self, p: DVec3) -> Option<DVec2> {
        let found = match self {
            Self::Plane { frame } => frame.local(p).truncate(),
            Self::Cylinder { frame, .. } => {
                let local = frame.local(p);
                DVec2::new(turn(libm::atan2(local.y, local.x)), local.z)
            }
            Self::Cone { frame, radius, half_angle } => {
                let (u, rho, z) = polar(frame, p);
                let (s, c) = libm::sincos(*half_angle);
                // The meridian line is (ρ, z) = (r, 0) + l (sin a, cos a); beyond the apex, ρ < 0 at u + π.
                let across = |rho: f64| ((rho - radius) * c - z * s).abs();
                let along = |rho: f64| ((rho - radius) * s + z * c) * c;
                if across(-rho) < across(rho) {
                    DVec2::new(turn(u + PI), along(-rho))
                } else {
                    DVec2::new(turn(u), along(rho))
                }
            }
            Self::Sphere { frame, .. } => {
                let (u, rho, z) = polar(frame, p);
                DVec2::new(turn(u), libm::atan2(z, rho))
            }
            Self::Torus { frame, major, minor } => {
                let (u, rho, z) = polar(frame, p);
                let away = |rho: f64| (libm::hypot(rho - major, z) - minor).abs();
                if minor > major && away(-rho) < away(rho) {
                    DVec2::new(turn(u + PI), turn(libm::atan2(z, -rho - major)))
                } else {
                    DVec2::new(turn(u), turn(libm::atan2(z, rho - major)))
                }
            }
            Self::Extrusion { .. } | Self::Revolution { .. } | Self::Nurbs(_) => return None,
        };
        found.is_finite().then_some(found)
    }
}

/// Cylindrical coordinates: angle, distance from the axis, height.
fn polar(frame: &Frame3, p: DVec3) -> (f64, f64, f64) {
    let local = frame.local(p);
    (libm::atan2(local.y, local.x), libm::hypot(local.x, local.y), local.z)
}

/// Wraps an angle to [0, 2π).
fn turn(angle: f64) -> f64 {
    // Nearly all are within a turn, where there is nothing to divide.
    let within = if angle < 0.0 { angle + TAU } else { angle };
    let wrapped = if angle.abs() < TAU { within } else { angle.rem_euclid(TAU) };
    if wrapped < TAU { wrapped } else { 0.0 }
}

/// Distance of the curve point at `t` from the axis of revolution.
fn axis_distance(curve: &NurbsCurve3, frame: &Frame3, t: f64) -> f64 {
    frame.meridian(curve.point(t)).x
}

/// Points of the curve within this distance of the axis of revolution lie on it.
fn axis_tolerance(curve: &NurbsCurve3, frame: &Frame3) -> f64 {
    SAME_POINT * extent(&curve.points).max(curve.point(curve.domain().0).distance(frame.origin))
}

/// The length of a curve's domain, if its ends meet and it is not a single point.
fn curve_period(curve: &NurbsCurve3) -> Option<f64> {
    let (a, b) = curve.domain();
    let size = extent(&curve.points);
    (size > 0.0 && curve.point(a).distance(curve.point(b)) <= SAME_ROW * size).then_some(b - a)
}
