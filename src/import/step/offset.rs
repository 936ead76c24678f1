//! Offsets of surfaces: exact where the offset is of the same kind, else bicubic pieces refined until sampled errors pass.

use super::surface::Reach;
use super::turned::sheet;
use crate::model::{NurbsCurve3, NurbsSurface, Surface};
use glam::DVec3;

/// Pieces per knot span and direction at which refinement stops.
const MAX_PIECES: usize = 64;
/// Control points of an approximation, at most.
const MAX_POINTS: usize = 400_000;

/// The surface at `distance` along the normal of `base`, with a note where it is approximated; or why it cannot be had.
///
/// `reach` tells where the face lies, for surfaces of several sheets.
pub(super) fn offset(
    base: &Surface,
    distance: f64,
    tolerance: f64,
    reach: Reach<'_>,
) -> Result<(Surface, Option<String>), String> {
    let positive = |r: f64| if r > 0.0 { Ok(r) } else { Err(format!("an offset by {distance} mm leaves nothing")) };
    let exact = match base {
        Surface::Plane { frame } => {
            let mut frame = *frame;
            frame.origin += frame.z * distance;
            Surface::Plane { frame }
        }
        Surface::Cylinder { frame, radius } => {
            Surface::Cylinder { frame: *frame, radius: positive(radius + distance)? }
        }
        Surface::Cone { frame, radius, half_angle } => {
            // Moving the slant line sideways changes the radius where the apex stays behind z = 0, else the origin.
            let moved = radius + distance / half_angle.cos();
            if moved >= 0.0 {
                Surface::Cone { frame: *frame, radius: moved, half_angle: *half_angle }
            } else {
                let mut frame = *frame;
                frame.origin -= frame.z * (moved / half_angle.tan());
                Surface::Cone { frame, radius: 0.0, half_angle: *half_angle }
            }
        }
        Surface::Sphere { frame, radius } => Surface::Sphere { frame: *frame, radius: positive(radius + distance)? },
        Surface::Torus { frame, major, minor } => {
            Surface::Torus { frame: *frame, major: *major, minor: positive(minor + distance)? }
        }
        Surface::Nurbs(net) => return approximate(base, net, distance, tolerance),
        // The normal of a sweep is the same all along the sweep: offsetting its profile offsets it.
        Surface::Extrusion { curve, direction } => {
            let (curve, error) = profile(curve, tolerance, |t| beside(base, t, 0.0, distance))?;
            return Ok((Surface::Extrusion { curve, direction: *direction }, approximated(error)));
        }
        Surface::Revolution { curve, frame } => {
            let curve = sheet(curve, frame, &reach().on);
            let base = &Surface::Revolution { curve: curve.clone(), frame: *frame };
            let (curve, error) = profile(&curve, tolerance, |t| beside(base, 0.0, t, distance))?;
            return Ok((Surface::Revolution { curve, frame: *frame }, approximated(error)));
        }
    };
    Ok((exact, None))
}

fn approximated(error: f64) -> Option<String> {
    Some(format!("offset surface approximated within {error:.2e} mm"))
}

/// The point at `distance` along the normal.
fn beside(base: &Surface, u: f64, v: f64, distance: f64) -> Result<DVec3, String> {
    let normal = base.normal(u, v).ok_or("the surface to offset has no normal somewhere")?;
    Ok(base.point(u, v) + normal * distance)
}

/// The distinct knots of the domain.
pub(super) fn breaks_of(knots: &[f64], (a, b): (f64, f64)) -> Vec<f64> {
    let mut inside: Vec<f64> = knots.iter().copied().filter(|k| *k >= a && *k <= b).collect();
    inside.dedup();
    inside
}

/// A curve of cubic pieces through `at`, over the domain and knots of `base`, and its largest sampled error.
fn profile(
    base: &NurbsCurve3,
    tolerance: f64,
    at: impl Fn(f64) -> Result<DVec3, String>,
) -> Result<(NurbsCurve3, f64), String> {
    fitted(&breaks_of(&base.knots, base.domain()), tolerance, at)
}

/// A curve of cubic pieces through `at` between `spans`, and its largest sampled error.
pub(super) fn fitted(
    spans: &[f64],
    tolerance: f64,
    at: impl Fn(f64) -> Result<DVec3, String>,
) -> Result<(NurbsCurve3, f64), String> {
    let mut pieces = 1;
    loop {
        let breaks = refined(spans, pieces);
        let ts = thirds(&breaks);
        let mut points = ts.iter().map(|t| at(*t)).collect::<Result<Vec<_>, _>>()?;
        to_bezier(&mut points, |k| k, ts.len());
        let curve = NurbsCurve3 { degree: 3, knots: cubic_knots(&breaks), points, weights: Vec::new() };
        let mut error: f64 = 0.0;
        for t in probes(&breaks) {
            error = error.max(curve.point(t).distance(at(t)?));
        }
        if error <= tolerance {
            return Ok((curve, error));
        }
        if pieces >= MAX_PIECES {
            return Err(format!("what stands for it is still {error:.2e} mm off after refinement"));
        }
        pieces *= 2;
    }
}

fn approximate(
    base: &Surface,
    net: &NurbsSurface,
    distance: f64,
    tolerance: f64,
) -> Result<(Surface, Option<String>), String> {
    let at = |u: f64, v: f64| beside(base, u, v, distance);
    let (domain_u, domain_v) = net.domain();
    let (base_u, base_v) = (breaks_of(&net.knots_u, domain_u), breaks_of(&net.knots_v, domain_v));
    let mut pieces = 1;
    loop {
        let (breaks_u, breaks_v) = (refined(&base_u, pieces), refined(&base_v, pieces));
        if 9 * breaks_u.len() * breaks_v.len() > MAX_POINTS {
            return Err(format!(
                "an offset surface of more than {MAX_POINTS} control points; allow a larger tolerance"
            ));
        }
        let surface = fit(&breaks_u, &breaks_v, &at)?;
        let error = worst(&surface, &breaks_u, &breaks_v, &at)?;
        if error <= tolerance {
            return Ok((Surface::Nurbs(surface), approximated(error)));
        }
        if pieces >= MAX_PIECES {
            return Err(format!("the offset surface is still {error:.2e} mm off after refinement"));
        }
        pieces *= 2;
    }
}

fn refined(breaks: &[f64], pieces: usize) -> Vec<f64> {
    let mut fine = Vec::with_capacity((breaks.len() - 1) * pieces + 1);
    for ends in breaks.windows(2) {
        fine.extend((0..pieces).map(|i| ends[0] + (ends[1] - ends[0]) * i as f64 / pieces as f64));
    }
    fine.extend(breaks.last());
    fine
}

/// Parameters at thirds of every piece, each joint once.
fn thirds(breaks: &[f64]) -> Vec<f64> {
    let mut out = vec![breaks[0]];
    for ends in breaks.windows(2) {
        let third = (ends[1] - ends[0]) / 3.0;
        out.extend([ends[0] + third, ends[1] - third, ends[1]]);
    }
    out
}

/// Bicubic pieces through 4 × 4 points each; neighbours share their border.
fn fit(
    breaks_u: &[f64],
    breaks_v: &[f64],
    at: &impl Fn(f64, f64) -> Result<DVec3, String>,
) -> Result<NurbsSurface, String> {
    let (us, vs) = (thirds(breaks_u), thirds(breaks_v));
    let mut points = Vec::with_capacity(us.len() * vs.len());
    for u in &us {
        for v in &vs {
            points.push(at(*u, *v)?);
        }
    }
    let (nu, nv) = (us.len(), vs.len());
    for i in 0..nu {
        to_bezier(&mut points, |k| i * nv + k, nv);
    }
    for j in 0..nv {
        to_bezier(&mut points, |k| k * nv + j, nu);
    }
    Ok(NurbsSurface {
        degree_u: 3,
        degree_v: 3,
        knots_u: cubic_knots(breaks_u),
        knots_v: cubic_knots(breaks_v),
        points,
        weights: Vec::new(),
    })
}

/// Values at thirds of cubic pieces to their inner Bézier points, along one line of the net.
fn to_bezier(points: &mut [DVec3], index: impl Fn(usize) -> usize, count: usize) {
    for start in (0..count - 1).step_by(3) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| points[index(start + k)]);
        points[index(start + 1)] = (a * -5.0 + b * 18.0 - c * 9.0 + d * 2.0) / 6.0;
        points[index(start + 2)] = (a * 2.0 - b * 9.0 + c * 18.0 - d * 5.0) / 6.0;
    }
}

fn cubic_knots(breaks: &[f64]) -> Vec<f64> {
    let mut knots = vec![breaks[0]];
    knots.extend(breaks.iter().flat_map(|t| [*t; 3]));
    knots.extend(breaks.last());
    knots
}

/// Sixths of every piece: the middles of the thirds, where a cubic through the thirds is farthest off.
fn probes(breaks: &[f64]) -> Vec<f64> {
    breaks.windows(2).flat_map(|e| [1.0, 3.0, 5.0].map(|k| e[0] + (e[1] - e[0]) * k / 6.0)).collect()
}

/// The largest distance at points between those that were interpolated.
fn worst(
    surface: &NurbsSurface,
    breaks_u: &[f64],
    breaks_v: &[f64],
    at: &impl Fn(f64, f64) -> Result<DVec3, String>,
) -> Result<f64, String> {
    let (us, vs) = (probes(breaks_u), probes(breaks_v));
    let mut worst: f64 = 0.0;
    for u in &us {
        for v in &vs {
            worst = worst.max(surface.point(*u, *v).distance(at(*u, *v)?));
        }
    }
    Ok(worst)
}
