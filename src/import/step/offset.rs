//! Surfaces -> offset surfaces. Exact where the offset is of the same kind, else cubic pieces, refined until sampled
//! errors are within the tolerance.

use super::face_location::{LocateFace, Range, face_part};
use super::revolution::{ON_AXIS, sheet};
use super::weld;
use crate::math::boxes::around;
use crate::model::{FitTrouble, NurbsCurve3, NurbsSurface, Severity, StepOutcome, Surface, breaks, knots_of_pieces};
use glam::{DVec2, DVec3};
use std::iter::once;

/// Maximum number of pieces per knot span and direction.
const MAX_PIECES: usize = 64;
/// Maximum number of control points of an approximation.
const MAX_POINTS: usize = 400_000;
/// Approximations are refined to this share of their size where that is less than the tolerance, so that small faces
/// are approximated as well as large ones. An error between the two is accepted.
const FINE: f64 = 1e-5;
/// A profile that is longer than its face may pass the axis by this share of its width.
const PASSES: f64 = 0.01;
/// An approximation whose error is within this share of its size is kept even if it misses the tolerance. The face
/// would be filled from its boundary, which is further off.
const BETTER_THAN_FILLED: f64 = 1e-4;
/// Pieces with larger errors may take this share of the domain in each direction, and [`SPOTS_AREA`] of its area: they
/// are spots or short creases, where the base bends so much that its offset has a cusp. A crease across the surface
/// takes all of one direction.
const SPOTS: f64 = 0.5;
const SPOTS_AREA: f64 = 0.125;

/// Offsets `base` by `distance` along its normal, with what to report if the result is approximated.
///
/// `reach` locates the face, for surfaces of several sheets, and for those that have no offset elsewhere.
pub(super) fn offset(
    base: &Surface,
    distance: f64,
    tolerance: f64,
    reach: LocateFace<'_>,
) -> Result<(Surface, Option<(Severity, StepOutcome)>), FitTrouble> {
    let nothing = FitTrouble::Vanishes { distance_mm: distance, leaves: "nothing" };
    let positive = |r: f64| if r > 0.0 { Ok(r) } else { Err(nothing) };
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
            // Moving the slant line sideways changes the radius at z = 0. If that is negative, the apex becomes the
            // origin.
            let moved = radius + distance / libm::cos(*half_angle);
            if moved >= 0.0 {
                Surface::Cone { frame: *frame, radius: moved, half_angle: *half_angle }
            } else {
                let mut frame = *frame;
                frame.origin -= frame.z * (moved / libm::tan(*half_angle));
                Surface::Cone { frame, radius: 0.0, half_angle: *half_angle }
            }
        }
        Surface::Sphere { frame, radius } => Surface::Sphere { frame: *frame, radius: positive(radius + distance)? },
        Surface::Torus { frame, major, minor } => {
            Surface::Torus { frame: *frame, major: *major, minor: positive(minor + distance)? }
        }
        Surface::Nurbs(net) => {
            let OffsetFit { surface: open, worst, bad } = offset_net(base, net, distance, tolerance, reach)?;
            let surface = weld::net(open.clone(), [false; 2], tolerance);
            let worst = worst + moved(&open.points, &surface.points);
            // Where normals turn round at once, the offset jumps by twice the distance.
            let at_spots = if bad.spread <= SPOTS && bad.area <= SPOTS_AREA { 2.0 * distance.abs() } else { 0.0 };
            let note = approximated(worst, tolerance, usable(&surface.points).max(at_spots), "the offset surface")?;
            return Ok((Surface::Nurbs(surface), Some(note)));
        }
        // The normal is constant along a sweep: the offset sweeps the offset profile.
        Surface::Extrusion { curve, direction } => {
            let (curve, note) = profile(curve, tolerance, |t| offset_point(base, t, 0.0, distance))?;
            return Ok((Surface::Extrusion { curve, direction: *direction }, Some(note)));
        }
        Surface::Revolution { curve, frame } => {
            let curve = sheet(curve, frame, &reach().on);
            let base = &Surface::Revolution { curve: curve.clone(), frame: *frame };
            let flat = |p: DVec3| frame.local(p).truncate();
            let width = |p: &DVec3| flat(*p).length_squared();
            let out = curve.points.iter().copied().max_by(|p, q| width(p).total_cmp(&width(q))).map_or(DVec2::X, flat);
            let least = curve.points.iter().map(|p| flat(*p).dot(out)).fold(f64::INFINITY, f64::min);
            // Beyond the axis, the normal that surfaces of revolution have is on the other side of the profile. One
            // that goes on a little there has no face there. A point on the axis has the normal of the points next to
            // it.
            let far = out.length_squared();
            let passes = least > -PASSES * far;
            let is_beyond = |t: f64| passes && flat(curve.point(t)).dot(out) < -ON_AXIS * far;
            let side = |t: f64| if is_beyond(t) { -distance } else { distance };
            let (curve, note) = profile(&curve, tolerance, |t| offset_point(base, 0.0, t, side(t)))?;
            return Ok((Surface::Revolution { curve, frame: *frame }, Some(note)));
        }
    };
    Ok((exact, None))
}

/// What to report of an approximation. Refuses one that is off by more than `most`.
fn approximated(
    error_mm: f64,
    tolerance: f64,
    most: f64,
    what: &'static str,
) -> Result<(Severity, StepOutcome), FitTrouble> {
    let severity = if error_mm <= tolerance {
        Severity::Note
    } else if error_mm <= most {
        Severity::Warning
    } else {
        return Err(FitTrouble::Inexact { what, error_mm });
    };
    Ok((severity, StepOutcome::Approximated { error_mm }))
}

/// The largest error of an approximation with these control points that is better than a filled face.
fn usable(points: &[DVec3]) -> f64 {
    BETTER_THAN_FILLED * size(points)
}

/// Diagonal of the box of points, of which there is one at least.
fn size(points: &[DVec3]) -> f64 {
    let [low, high] = around(points.iter().copied());
    low.distance(high)
}

/// The point at `distance` along the normal.
fn offset_point(base: &Surface, u: f64, v: f64, distance: f64) -> Result<DVec3, FitTrouble> {
    let normal = base.normal(u, v).ok_or(FitTrouble::NoNormal)?;
    Ok(base.point(u, v) + normal * distance)
}

/// The longest way from a point to the one that replaces it.
fn moved(from: &[DVec3], to: &[DVec3]) -> f64 {
    from.iter().zip(to).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max)
}

/// Fits cubic pieces to `at` over the domain and knots of `base`. Returns the curve and what to report.
///
/// The tangents of an approximated base differ at both ends, and so do the ends of its offset. Those of a closed base
/// are joined. How far they move counts as an error.
fn profile(
    base: &NurbsCurve3,
    tolerance: f64,
    at: impl Fn(f64) -> Result<DVec3, FitTrouble>,
) -> Result<(NurbsCurve3, (Severity, StepOutcome)), FitTrouble> {
    let (open, error) = closest(&breaks(base.degree, &base.knots), tolerance, at)?;
    let (a, b) = base.domain();
    let ends = if base.point(a) == base.point(b) { f64::INFINITY } else { tolerance };
    let curve = weld::curve(open.clone(), ends);
    let error = error + moved(&open.points, &curve.points);
    let note = approximated(error, tolerance, usable(&curve.points), "the profile of the offset surface")?;
    Ok((curve, note))
}

/// Fits cubic pieces to `at` over the knots `spans`, within the tolerance.
pub(super) fn fitted(
    spans: &[f64],
    tolerance: f64,
    at: impl Fn(f64) -> Result<DVec3, FitTrouble>,
) -> Result<NurbsCurve3, FitTrouble> {
    let (curve, error_mm) = closest(spans, tolerance, at)?;
    let close = error_mm <= tolerance;
    close.then_some(curve).ok_or(FitTrouble::Inexact { what: "the approximation", error_mm })
}

/// Fits cubic pieces to `at` over the knots `spans`, until the error is within the tolerance and [`FINE`], or pieces
/// are as short as allowed. Returns the curve and its largest sampled error.
fn closest(
    spans: &[f64],
    tolerance: f64,
    at: impl Fn(f64) -> Result<DVec3, FitTrouble>,
) -> Result<(NurbsCurve3, f64), FitTrouble> {
    let mut spans = FitSpan::of_breaks(spans);
    loop {
        let breaks = breaks_at(&spans);
        let ts = thirds(&breaks);
        let mut points = ts.iter().map(|t| at(*t)).collect::<Result<Vec<_>, _>>()?;
        let wanted = tolerance.min(FINE * size(&points));
        to_bezier(&mut points, |k| k, ts.len());
        let curve = NurbsCurve3 { degree: 3, knots: knots_of_pieces(3, &breaks), points, weights: Vec::new() };
        let mut errors = vec![0.0; spans.len()];
        for (k, t) in probes(&breaks).into_iter().enumerate() {
            let error: &mut f64 = &mut errors[k / 3];
            *error = error.max(curve.point(t).distance(at(t)?));
        }
        let worst = errors.iter().copied().fold(0.0, f64::max);
        if worst <= wanted || !split(&mut spans, &errors, wanted) {
            return Ok((curve, worst));
        }
    }
}

/// An approximation of the offset of a net.
struct OffsetFit {
    surface: NurbsSurface,
    /// The largest sampled error, which may exceed the tolerance.
    worst: f64,
    bad: BadPieces,
}

/// The pieces of an approximation that are worse than [`usable`].
#[derive(Clone, Copy)]
struct BadPieces {
    /// The share of the domain that they take, in the direction in which they take more.
    spread: f64,
    /// Their share of the domain's area.
    area: f64,
}

/// The offset of a net over its whole domain, or over the face's part of it if it cannot be fitted elsewhere: a net may
/// have a cusp, or may have been extended until it folds. Returns the closest surface.
fn offset_net(
    base: &Surface,
    net: &NurbsSurface,
    distance: f64,
    tolerance: f64,
    reach: LocateFace<'_>,
) -> Result<OffsetFit, FitTrouble> {
    let at = |u: f64, v: f64| offset_point(base, u, v, distance);
    let (domain_u, domain_v) = net.domain();
    let whole = approximate(net, [domain_u, domain_v], tolerance, &at);
    if whole.as_ref().is_ok_and(|whole| whole.worst <= tolerance) {
        return whole;
    }
    let part = face_part(base, &reach().on, |u, v| at(u, v).ok());
    let part = part.map(|part| approximate(net, part, tolerance, &at));
    match (whole, part) {
        (whole, None | Some(Err(_))) => whole,
        (Ok(whole), Some(Ok(part))) if whole.worst <= part.worst => Ok(whole),
        (_, Some(part)) => part,
    }
}

/// Fits bicubic pieces to `at` over a part of the net's domain. Returns the closest surface.
fn approximate(
    net: &NurbsSurface,
    part: [Range; 2],
    tolerance: f64,
    at: &impl Fn(f64, f64) -> Result<DVec3, FitTrouble>,
) -> Result<OffsetFit, FitTrouble> {
    let mut spans_u = FitSpan::of_breaks(&breaks_within(&net.knots_u, part[0]));
    let mut spans_v = FitSpan::of_breaks(&breaks_within(&net.knots_v, part[1]));
    let wanted = tolerance.min(FINE * size(&net.points));
    let mut coarser = None;
    loop {
        let (breaks_u, breaks_v) = (breaks_at(&spans_u), breaks_at(&spans_v));
        if 9 * breaks_u.len() * breaks_v.len() > MAX_POINTS {
            return coarser.ok_or(FitTrouble::TooManyPoints { limit: MAX_POINTS });
        }
        let surface = fit(&breaks_u, &breaks_v, at)?;
        let off = FitErrors::of(&surface, &breaks_u, &breaks_v, wanted, at)?;
        // Errors that are as small as wanted split nothing.
        let split = [split(&mut spans_u, &off.along_u, wanted), split(&mut spans_v, &off.along_v, wanted)];
        let fit = OffsetFit { surface, worst: off.worst, bad: off.bad };
        if split == [false, false] {
            return Ok(fit);
        }
        coarser = Some(fit);
    }
}

/// The distinct knots within a range, and its ends.
fn breaks_within(knots: &[f64], range: Range) -> Vec<f64> {
    let inside = knots.iter().copied().filter(|&k| k > range.0 && k < range.1);
    let mut breaks: Vec<f64> = once(range.0).chain(inside).chain(once(range.1)).collect();
    breaks.dedup();
    breaks
}

/// A piece of a knot span during refinement.
#[derive(Clone, Copy)]
struct FitSpan {
    from: f64,
    to: f64,
    /// Minimum length of a piece.
    least: f64,
}

impl FitSpan {
    fn of_breaks(breaks: &[f64]) -> Vec<Self> {
        let span = |ends: &[f64]| {
            let least = (ends[1] - ends[0]) / MAX_PIECES as f64;
            Self { from: ends[0], to: ends[1], least }
        };
        breaks.windows(2).map(span).collect()
    }
}

/// Ends of adjacent spans, each once.
fn breaks_at(spans: &[FitSpan]) -> Vec<f64> {
    spans.iter().map(|span| span.from).chain(spans.last().map(|span| span.to)).collect()
}

/// Splits only the spans whose error is too large: most surfaces are hard to fit in few places. Returns whether any was
/// split.
fn split(spans: &mut Vec<FitSpan>, errors: &[f64], tolerance: f64) -> bool {
    let mut fine = Vec::with_capacity(2 * spans.len());
    for (span, error) in spans.iter().zip(errors) {
        // The error of a cubic falls with the fourth power of the length.
        let wanted = if *error > tolerance { 2 + usize::from(*error > 16.0 * tolerance) * 2 } else { 1 };
        let length = span.to - span.from;
        let most = (2..=wanted).rev().find(|n| length / *n as f64 > 0.999 * span.least);
        let pieces = most.unwrap_or(1);
        let at = |i: usize| if i == pieces { span.to } else { span.from + length * i as f64 / pieces as f64 };
        fine.extend((0..pieces).map(|i| FitSpan { from: at(i), to: at(i + 1), ..*span }));
    }
    let split = fine.len() > spans.len();
    *spans = fine;
    split
}

/// Parameters at the thirds of every piece; joints once.
fn thirds(breaks: &[f64]) -> Vec<f64> {
    let mut out = vec![breaks[0]];
    for ends in breaks.windows(2) {
        let third = (ends[1] - ends[0]) / 3.0;
        out.extend([ends[0] + third, ends[1] - third, ends[1]]);
    }
    out
}

/// Fits bicubic pieces to 4 × 4 points each; neighbours share their border.
fn fit(
    breaks_u: &[f64],
    breaks_v: &[f64],
    at: &impl Fn(f64, f64) -> Result<DVec3, FitTrouble>,
) -> Result<NurbsSurface, FitTrouble> {
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
        knots_u: knots_of_pieces(3, breaks_u),
        knots_v: knots_of_pieces(3, breaks_v),
        points,
        weights: Vec::new(),
    })
}

/// Replaces the values at the thirds of cubic pieces by their inner Bézier points, along one line of the net.
fn to_bezier(points: &mut [DVec3], index: impl Fn(usize) -> usize, count: usize) {
    for start in (0..count - 1).step_by(3) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| points[index(start + k)]);
        points[index(start + 1)] = (a * -5.0 + b * 18.0 - c * 9.0 + d * 2.0) / 6.0;
        points[index(start + 2)] = (a * 2.0 - b * 9.0 + c * 18.0 - d * 5.0) / 6.0;
    }
}

/// Parameters at the middles of the thirds of every piece, where the error of a cubic through the thirds is largest.
fn probes(breaks: &[f64]) -> Vec<f64> {
    breaks.windows(2).flat_map(|e| [1.0, 3.0, 5.0].map(|k| e[0] + (e[1] - e[0]) * k / 6.0)).collect()
}

/// Errors of an approximation between the interpolated points.
struct FitErrors {
    worst: f64,
    /// By span along u: the largest error that splitting the span would reduce, in pieces above the tolerance.
    along_u: Vec<f64>,
    along_v: Vec<f64>,
    bad: BadPieces,
}

impl FitErrors {
    fn of(
        surface: &NurbsSurface,
        breaks_u: &[f64],
        breaks_v: &[f64],
        tolerance: f64,
        at: &impl Fn(f64, f64) -> Result<DVec3, FitTrouble>,
    ) -> Result<Self, FitTrouble> {
        let largest = |us: &[f64], vs: &[f64]| -> Result<f64, FitTrouble> {
            let mut largest: f64 = 0.0;
            for u in us {
                for v in vs {
                    largest = largest.max(surface.point(*u, *v).distance(at(*u, *v)?));
                }
            }
            Ok(largest)
        };
        let (nodes_u, nodes_v) = (thirds(breaks_u), thirds(breaks_v));
        let (probes_u, probes_v) = (probes(breaks_u), probes(breaks_v));
        let (mut along_u, mut along_v) = (vec![0.0; breaks_u.len() - 1], vec![0.0; breaks_v.len() - 1]);
        let [shares_u, shares_v] = [breaks_u, breaks_v].map(|breaks| {
            let whole = breaks[breaks.len() - 1] - breaks[0];
            breaks.windows(2).map(|ends| (ends[1] - ends[0]) / whole).collect::<Vec<f64>>()
        });
        let (mut bad_u, mut bad_v, mut area) = (vec![0.0; along_u.len()], vec![0.0; along_v.len()], 0.0);
        let (mut worst, usable): (f64, _) = (0.0, usable(&surface.points));
        for (i, in_u) in probes_u.chunks(3).enumerate() {
            for (j, in_v) in probes_v.chunks(3).enumerate() {
                let error = largest(in_u, in_v)?;
                worst = worst.max(error);
                if error <= tolerance {
                    continue;
                }
                if error > usable {
                    (bad_u[i], bad_v[j]) = (shares_u[i], shares_v[j]);
                    area += shares_u[i] * shares_v[j];
                }
                // On lines through interpolated points of one direction, the error comes from the other direction
                // alone.
                let u = largest(in_u, &nodes_v[3 * j..3 * j + 4])?;
                let v = largest(&nodes_u[3 * i..3 * i + 4], in_v)?;
                // Two errors may add up to more than the tolerance: the larger one counts as the whole error.
                let u: f64 = if u >= v { error } else { u };
                let v: f64 = if v >= u { error } else { v };
                along_u[i] = u.max(along_u[i]);
                along_v[j] = v.max(along_v[j]);
            }
        }
        let spread = bad_u.iter().sum::<f64>().max(bad_v.iter().sum());
        Ok(Self { worst, along_u, along_v, bad: BadPieces { spread, area } })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::step::face_location::FaceLocation;

    /// A plane net of 20 × 20 spans with one control point pulled out of it.
    fn bump(height: f64) -> Surface {
        const COUNT: usize = 23;
        let knots = |i: usize| (i.clamp(3, COUNT) - 3) as f64;
        let knots: Vec<f64> = (0..COUNT + 4).map(knots).collect();
        let z = |i: usize, j: usize| if (i, j) == (11, 11) { height } else { 0.0 };
        let points = (0..COUNT * COUNT).map(|k| (k / COUNT, k % COUNT));
        let points = points.map(|(i, j)| DVec3::new(i as f64, j as f64, z(i, j))).collect();
        let net = NurbsSurface {
            degree_u: 3,
            degree_v: 3,
            knots_u: knots.clone(),
            knots_v: knots,
            points,
            weights: Vec::new(),
        };
        Surface::Nurbs(net)
    }

    #[test]
    fn an_offset_is_refined_only_where_it_bends() {
        let base = bump(2.0);
        let (surface, _) = offset(&base, 0.5, 1e-4, &FaceLocation::default).expect("an offset");
        let Surface::Nurbs(net) = &surface else { panic!("no spline") };
        // Halving all spans until the bump passes takes 8 times as many along both directions: 481 × 481 points.
        assert!(net.points.len() < 40_000, "{} points", net.points.len());
        for (i, j) in (0..60).flat_map(|i| (0..60).map(move |j| (i, j))) {
            let (u, v) = (f64::from(i) / 3.0 + 0.05, f64::from(j) / 3.0 + 0.05);
            let exact = offset_point(&base, u, v, 0.5).expect("a normal");
            assert!(surface.point(u, v).distance(exact) < 2e-4, "at {u}, {v}");
        }
    }

    /// A net of bilinear spans with these heights.
    fn bilinear(height: impl Fn(DVec3) -> f64) -> Surface {
        let Surface::Nurbs(mut net) = bump(0.0) else { panic!("no spline") };
        (net.degree_u, net.degree_v) = (1, 1);
        let knots: Vec<f64> = (0..25).map(|i: usize| (i.clamp(1, 23) - 1) as f64).collect();
        (net.knots_u, net.knots_v) = (knots.clone(), knots);
        net.points.iter_mut().for_each(|p| p.z = height(*p));
        Surface::Nurbs(net)
    }

    /// Two planes that meet at `x = 11`.
    fn kinked(slope: f64) -> Surface {
        bilinear(|p| slope * (p.x - 11.0).max(0.0))
    }

    #[test]
    fn an_offset_with_a_bad_spot_is_kept_and_told() {
        let pyramid = bilinear(|p| if (p.x, p.y) == (11.0, 11.0) { 0.5 } else { 0.0 });
        let (surface, note) = offset(&pyramid, 0.5, 1e-4, &FaceLocation::default).expect("an offset");
        let Some((Severity::Warning, StepOutcome::Approximated { error_mm })) = note else { panic!("{note:?}") };
        assert!(error_mm > 1e-2 && error_mm < 0.5, "{error_mm}");
        for (u, v) in [(3.3, 4.7), (11.5, 2.0), (10.5, 10.5), (19.0, 11.0)] {
            let exact = offset_point(&pyramid, u, v, 0.5).expect("a normal");
            assert!(surface.point(u, v).distance(exact) < 2e-4, "at {u}, {v}");
        }
    }

    #[test]
    fn an_offset_of_a_kinked_net_is_refused() {
        let error = offset(&kinked(1.0), 0.5, 1e-4, &FaceLocation::default).expect_err("a kink");
        assert!(matches!(error, FitTrouble::Inexact { .. }), "{error}");
    }

    #[test]
    fn a_kink_outside_the_face_does_not_matter() {
        let base = kinked(1.0);
        // A triangle on the offset of the slope.
        let corners =
            [(13.0, 2.0), (20.0, 3.0), (15.0, 9.0)].map(|(u, v)| offset_point(&base, u, v, 0.5).expect("a normal"));
        let side = |k: usize| (0..8).map(move |i| corners[k].lerp(corners[(k + 1) % 3], f64::from(i) / 8.0));
        let on: Vec<DVec3> = (0..3).flat_map(side).collect();
        let reach = || FaceLocation { hull: on.clone(), on: on.clone() };
        let (surface, _) = offset(&base, 0.5, 1e-4, &reach).expect("an offset");
        let [(u0, u1), (v0, v1)] = surface.natural_domain();
        assert!(u0 > 12.0 && u0 <= 13.0 && (20.0..21.0).contains(&u1), "{u0} {u1}");
        assert!(v0 > 1.0 && v0 <= 2.0 && (9.0..10.0).contains(&v1), "{v0} {v1}");
        assert!(surface.point(15.0, 4.0).distance(offset_point(&base, 15.0, 4.0, 0.5).expect("a normal")) < 1e-4);
        // Points that are not on the offset locate nothing.
        let across =
            || FaceLocation { hull: Vec::new(), on: on.iter().map(|p| *p - DVec3::new(5.0, 0.0, 5.0)).collect() };
        offset(&base, 0.5, 1e-4, &across).expect_err("a kink");
    }

    #[test]
    fn an_offset_that_misses_the_tolerance_by_little_is_kept_and_told() {
        let (surface, note) = offset(&kinked(1e-4), 0.5, 1e-6, &FaceLocation::default).expect("an offset");
        let Some((Severity::Warning, StepOutcome::Approximated { error_mm })) = note else { panic!("{note:?}") };
        assert!(error_mm > 1e-6 && error_mm < 1e-4, "{error_mm}");
        assert!(surface.point(15.0, 4.0).distance(DVec3::new(15.0 - 5e-5, 4.0, 0.5 + 4e-4)) < 1e-6);
    }
}
