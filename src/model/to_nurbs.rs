//! Analytic and swept surfaces -> exact rational NURBS over a box of their natural parameters.
//!
//! Angles become rational quadratics in equal spans of at most 90° (Piegl & Tiller, ch. 7 and 8).

use super::curve::ArcNet;
use super::{AxisMap, Frame3, NurbsCurve3, NurbsSurface, Surface, knots};
use glam::{DVec3, DVec4};

impl Surface {
    /// Converts the surface over the natural box `u` × `v` (finite, increasing) to an exact NURBS, with its parameter
    /// maps.
    ///
    /// NURBS parameters equal the natural ones at knots, and everywhere in straight directions. Swept curves and NURBS
    /// surfaces are not cut to the box. If they are periodic and the box leaves the domain, they are repeated to cover
    /// it.
    #[must_use]
    pub fn to_nurbs(&self, u: (f64, f64), v: (f64, f64)) -> (NurbsSurface, [AxisMap; 2]) {
        match self {
            Self::Plane { frame } => {
                let corner = |u: f64, v: f64| frame.origin + frame.x * u + frame.y * v;
                let surface = NurbsSurface {
                    degree_u: 1,
                    degree_v: 1,
                    knots_u: vec![u.0, u.0, u.1, u.1],
                    knots_v: vec![v.0, v.0, v.1, v.1],
                    points: vec![corner(u.0, v.0), corner(u.0, v.1), corner(u.1, v.0), corner(u.1, v.1)],
                    weights: Vec::new(),
                };
                (surface, [AxisMap::Identity; 2])
            }
            Self::Cylinder { frame, radius } => turned(frame, u, &straight(v, |_| *radius), AxisMap::Identity),
            Self::Cone { frame, radius, half_angle } => {
                let slope = libm::tan(*half_angle);
                turned(frame, u, &straight(v, |v| radius + v * slope), AxisMap::Identity)
            }
            Self::Sphere { frame, radius } => {
                let (profile, map) = round(v, 0.0, *radius);
                turned(frame, u, &profile, map)
            }
            Self::Torus { frame, major, minor } => {
                let (profile, map) = round(v, *major, *minor);
                turned(frame, u, &profile, map)
            }
            Self::Extrusion { curve, direction } => {
                let curve = self.covering(curve, 0, u);
                let lift = |p: &DVec3| [*p + *direction * v.0, *p + *direction * v.1];
                let surface = NurbsSurface {
                    degree_u: curve.degree,
                    degree_v: 1,
                    knots_v: vec![v.0, v.0, v.1, v.1],
                    points: curve.points.iter().flat_map(lift).collect(),
                    weights: curve.weights.iter().flat_map(|&w| [w, w]).collect(),
                    knots_u: curve.knots,
                };
                (surface, [AxisMap::Identity; 2])
            }
            Self::Revolution { curve, frame } => {
                let curve = self.covering(curve, 1, v);
                let points = curve.points.iter().map(|&p| frame.local(p)).collect();
                turned(frame, u, &NurbsCurve3 { points, ..curve }, AxisMap::Identity)
            }
            Self::Nurbs(surface) => {
                let leaves = |(a, b): (f64, f64), (low, high): (f64, f64)| low < a || high > b;
                let domain = surface.domain();
                // Finding the periods of a net takes many points.
                let period = if leaves(domain.0, u) || leaves(domain.1, v) { self.period() } else { [None; 2] };
                let mut surface = surface.clone();
                if period[0].is_some() {
                    surface = unrolled_u(surface, u);
                }
                if period[1].is_some() {
                    surface = unrolled_u(surface.transposed(), v).transposed();
                }
                (surface, [AxisMap::Identity; 2])
            }
        }
    }

    /// Repeats the swept curve to cover `range`, if the surface is periodic along `axis`.
    fn covering(&self, curve: &NurbsCurve3, axis: usize, range: (f64, f64)) -> NurbsCurve3 {
        if self.period()[axis].is_none() {
            return curve.clone();
        }
        let rows = homogeneous(&curve.points, &curve.weights);
        let (knots, rows) = knots::unroll(curve.degree, &curve.knots, &rows, 1, range);
        let (points, weights) = euclidean(&rows, !curve.weights.is_empty());
        NurbsCurve3 { degree: curve.degree, knots, points, weights }
    }
}

/// `(w·x, w·y, w·z, w)` of each control point.
pub(crate) fn homogeneous(points: &[DVec3], weights: &[f64]) -> Vec<DVec4> {
    if weights.is_empty() {
        return points.iter().map(|p| p.extend(1.0)).collect();
    }
    points.iter().zip(weights).map(|(&p, &w)| (p * w).extend(w)).collect()
}

/// Splits homogeneous points into points and, if `weighted`, weights.
pub(crate) fn euclidean(rows: &[DVec4], weighted: bool) -> (Vec<DVec3>, Vec<f64>) {
    let points = rows.iter().map(|r| if r.w == 1.0 { r.truncate() } else { r.truncate() / r.w }).collect();
    (points, if weighted { rows.iter().map(|r| r.w).collect() } else { Vec::new() })
}

/// The curve of Bézier pieces between `breaks`: `degree + 1` homogeneous points each, of which neighbours share one.
pub(crate) fn of_pieces(degree: usize, breaks: &[f64], pieces: &[DVec4], weighted: bool) -> NurbsCurve3 {
    let later = pieces.chunks_exact(degree + 1).flat_map(|piece| &piece[1..]);
    let rows: Vec<DVec4> = pieces.first().into_iter().chain(later).copied().collect();
    let (points, weights) = euclidean(&rows, weighted);
    NurbsCurve3 { degree, knots: knots::knots_of_pieces(degree, breaks), points, weights }
}

/// A straight meridian in the frame's (x, z) plane. Parameter: height.
fn straight(v: (f64, f64), distance: impl Fn(f64) -> f64) -> NurbsCurve3 {
    let at = |v: f64| DVec3::new(distance(v), 0.0, v);
    let mut curve = NurbsCurve3 { knots: vec![v.0, v.0, v.1, v.1], ..NurbsCurve3::line(at(v.0), at(v.1)) };
    snap_to_axis(&mut curve);
    curve
}

/// A circular meridian of radius `minor` about (x = `major`, z = 0). Parameter: angle.
fn round(v: (f64, f64), major: f64, minor: f64) -> (NurbsCurve3, AxisMap) {
    let (net, map) = arc(v);
    let points = net.rays.iter().map(|r| DVec3::new(major + minor * r.x, 0.0, minor * r.y)).collect();
    let mut curve = NurbsCurve3 { degree: 2, knots: net.knots, points, weights: net.weights };
    snap_to_axis(&mut curve);
    (curve, map)
}

/// Moves meridian ends that miss the axis by rounding onto it, so that a pole's row is one point to the last bit.
fn snap_to_axis(meridian: &mut NurbsCurve3) {
    let size = meridian.points.iter().fold(0.0_f64, |size, p| size.max(p.length()));
    let last = meridian.points.len() - 1;
    for i in [0, last] {
        if meridian.points[i].x.abs() <= 1e-15 * size {
            meridian.points[i].x = 0.0;
        }
    }
}

/// The unit arc over an angle range. Its last knot equals the map's end to the last bit.
fn arc(range: (f64, f64)) -> (ArcNet, AxisMap) {
    let mut net = ArcNet::new(range.0, range.1);
    #[allow(clippy::cast_possible_truncation, reason = "at most 80 000 spans")]
    let map = AxisMap::Arc { start: range.0, step: net.step, spans: net.spans as u32 };
    let end = range.0 + net.step * net.spans as f64;
    let tail = net.knots.len() - 3;
    net.knots[tail..].fill(end);
    (net, map)
}

/// Rotates the meridian (in the frame's coordinates) about the frame's z axis over the angles `u`.
fn turned(frame: &Frame3, u: (f64, f64), meridian: &NurbsCurve3, map_v: AxisMap) -> (NurbsSurface, [AxisMap; 2]) {
    let (net, map_u) = arc(u);
    let count_v = meridian.points.len();
    let mut points = Vec::with_capacity(net.rays.len() * count_v);
    let mut weights = Vec::with_capacity(net.rays.len() * count_v);
    for (ray, w) in net.rays.iter().zip(&net.weights) {
        for (j, p) in meridian.points.iter().enumerate() {
            let across = ray.perp();
            points.push(frame.place(DVec3::new(p.x * ray.x + p.y * across.x, p.x * ray.y + p.y * across.y, p.z)));
            weights.push(w * meridian.weights.get(j).copied().unwrap_or(1.0));
        }
    }
    let surface = NurbsSurface {
        degree_u: 2,
        degree_v: meridian.degree,
        knots_u: net.knots,
        knots_v: meridian.knots.clone(),
        points,
        weights,
    };
    (surface, [map_u, map_v])
}

/// Repeats a surface that is closed in u along u to cover `range`.
fn unrolled_u(surface: NurbsSurface, range: (f64, f64)) -> NurbsSurface {
    let ((u0, u1), _) = surface.domain();
    if range.0 >= u0 && range.1 <= u1 {
        return surface;
    }
    let rows = homogeneous(&surface.points, &surface.weights);
    let (knots_u, rows) = knots::unroll(surface.degree_u, &surface.knots_u, &rows, surface.count_v(), range);
    let (points, weights) = euclidean(&rows, !surface.weights.is_empty());
    NurbsSurface { knots_u, points, weights, ..surface }
}
