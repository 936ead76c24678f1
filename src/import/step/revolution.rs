//! Profiles of surfaces of revolution -> the part of an unbounded profile that sweeps over a face; the sheet of a face
//! on a surface whose profile meets its axis.

use super::curve::Carrier;
use super::face_location::{FaceLocation, Stated, extent, reaching, widened};
use super::spline;
use crate::math::solve::bisected;
use crate::model::{Frame3, NurbsCurve3, Surface};
use glam::{DVec2, DVec3};
use std::cell::OnceCell;
use std::f64::consts::PI;

/// A profile point within this share of the profile's size lies on the axis: files print axis directions with as few as
/// seven digits.
pub(super) const ON_AXIS: f64 = 1e-7;
/// For offsets: a profile that changes sides within this share of its size crosses the axis. Rounded points leave
/// profile and axis skew, and the normal flips in between.
const PASSING: f64 = 1e-3;
/// The most that a boundary lies off its surface, as a share of the boundary's size.
const OFF_SHEET: f64 = 1e-3;
/// Sheets within this share of the profile's size are the same surface, and so are a ring and the pole in it.
const COINCIDENT: f64 = 1e-6;
/// Directions within this angle of parallel or perpendicular are so: a cone's half angle is larger, and files print
/// directions with as few as seven digits.
const TILT: f64 = 1e-6;
/// A boundary whose heights differ by less than this share of its distance from the axis is at one height.
const ONE_HEIGHT: f64 = 1e-6;
/// Samples of a profile per control point.
const SAMPLES: usize = 16;

/// The part of a line that sweeps over all of `reach` when rotated; it may cross the axis.
pub(super) fn line(frame: &Frame3, point: DVec3, along: DVec3, reach: &FaceLocation) -> Option<NurbsCurve3> {
    let (start, step) = (frame.local(point), along.try_normalize()?);
    let climb = step.dot(frame.z);
    let flat = |v: DVec3| DVec3::new(v.x, v.y, 0.0);
    let direction = DVec3::new(step.dot(frame.x), step.dot(frame.y), 0.0);
    if climb.abs() > TILT {
        let along = |p: &DVec3| (frame.local(*p).z - start.z) / climb;
        let (mut low, mut high) = extent(reach.hull.iter().map(along))?;
        let out = direction.length();
        if out > TILT {
            // A boundary at one height encloses the apex: the line's nearest point to the axis.
            let apex = -flat(start).dot(direction) / (out * out);
            if high - low <= ONE_HEIGHT * out * (low - apex).abs() {
                (low, high) = (low.min(apex), high.max(apex));
            }
        }
        let (from, to) = widened(low, high)?;
        return Some(NurbsCurve3::line(point + step * from, point + step * to));
    }
    // A line perpendicular to the axis sweeps a flat ring: distances from the axis bound it, not heights.
    let middle = -flat(start).dot(direction);
    let closest = (flat(start) + direction * middle).length_squared();
    let far = reach.hull.iter().map(|p| (flat(frame.local(*p)).length_squared() - closest).max(0.0).sqrt());
    let (near, far) = extent(far)?;
    let (_, far) = widened(near, far)?;
    // Stay on the side of the axis of the stated point.
    let (low, high) = if middle <= 0.0 { (middle, middle + far) } else { (middle - far, middle) };
    Some(NurbsCurve3::line(point + step * low, point + step * high))
}

/// The part of a parabola or of a hyperbola's branch, in a plane through the axis, that sweeps over all of `reach` when
/// rotated; it may cross the axis.
pub(super) fn conic(frame: &Frame3, carrier: &Carrier, reach: &FaceLocation) -> Option<NurbsCurve3> {
    let (plane, tip) = match carrier {
        Carrier::Hyperbola { frame, a, .. } => (frame, frame.origin + frame.x * *a),
        Carrier::Parabola { frame, .. } => (frame, frame.origin),
        Carrier::Line { .. } | Carrier::Round { .. } | Carrier::Spline { .. } => return None,
    };
    let out = frame.z.cross(plane.z).try_normalize()?;
    let across = (plane.origin - frame.origin).dot(plane.z);
    let size = reach.hull.iter().map(|p| p.distance(frame.origin)).fold(0.0, f64::max);
    if frame.z.dot(plane.z).abs() > ON_AXIS || across.abs() > ON_AXIS * size.max(plane.origin.distance(frame.origin)) {
        return None;
    }
    // If both sides fit, take the one of positive conic parameters.
    let out = if out.dot(plane.y) < -ON_AXIS { -out } else { out };
    let miss = |p: DVec3| {
        let at = plane.local(p);
        match carrier {
            Carrier::Hyperbola { a, b, .. } => (at.x - a * libm::hypot(at.y / b, 1.0)).abs(),
            Carrier::Parabola { focal, .. } => (at.x - at.y * at.y / (4.0 * focal)).abs(),
            Carrier::Line { .. } | Carrier::Round { .. } | Carrier::Spline { .. } => f64::INFINITY,
        }
    };
    let turned = |p: &DVec3| {
        let DVec2 { x: radius, y: height } = frame.meridian(*p);
        let foot = frame.origin + frame.z * height;
        let [near, far] = [foot + out * radius, foot - out * radius];
        if miss(near) <= miss(far) + COINCIDENT * size { near } else { far }
    };
    let mut points: Vec<DVec3> = reach.hull.iter().chain(&reach.on).map(turned).collect();
    // The boundary may enclose the tip, if that is on the axis.
    if frame.meridian(tip).x <= ON_AXIS * size && !points.is_empty() {
        points.push(tip);
    }
    reaching(carrier, &points, |p, _| *p)
}

/// Moves the axis to an end of the profile that is within `tolerance` of it, or within a millionth of its size, so that
/// the surface has a pole there. A ring as small as the gaps between edges would have the boundary wind around it. The
/// other end moves onto the axis if it is as near.
///
/// The axis moves rather than the end, because edges meet at the end.
pub(super) fn onto_axis(mut curve: NurbsCurve3, mut frame: Frame3, tolerance: f64) -> (NurbsCurve3, Frame3) {
    let (a, b) = curve.domain();
    let widest = curve.points.iter().map(|p| frame.meridian(*p).x).fold(0.0, f64::max);
    let near = tolerance.max(COINCIDENT * widest).min(PASSING * widest);
    let is_near = |(t, k): &(f64, usize)| {
        let end = curve.points[*k];
        // The first control point of a curve without clamped knots is not its end.
        frame.radial(end).length() <= near && curve.point(*t).distance(end) <= near
    };
    let ends: Vec<(f64, usize)> = [(a, 0), (b, curve.points.len() - 1)].into_iter().filter(is_near).collect();
    if let Some((_, first)) = ends.first() {
        let off = frame.radial(curve.points[*first]);
        frame.origin += off;
    }
    for (_, k) in ends {
        let off = frame.radial(curve.points[k]);
        curve.points[k] -= off;
    }
    (curve, frame)
}

/// Size of a profile, including its distance from the axis.
fn size(curve: &NurbsCurve3, frame: &Frame3) -> f64 {
    let Some(first) = curve.points.first().map(|p| frame.meridian(*p)) else { return 0.0 };
    let away = |p: &DVec3| {
        let at = frame.meridian(*p);
        at.x.max((at.y - first.y).abs())
    };
    curve.points.iter().map(away).fold(0.0, f64::max)
}

/// Whether a profile certainly keeps further than `near` from the axis: all its control points lie beyond a plane that
/// is parallel to the axis. So do those of most profiles.
fn keeps_off(curve: &NurbsCurve3, frame: &Frame3, near: f64) -> bool {
    let across = |p: &DVec3| frame.local(*p).truncate();
    let direction = curve.points.first().and_then(|p| across(p).try_normalize());
    direction.is_some_and(|direction| curve.points.iter().all(|p| across(p).dot(direction) > near))
}

/// Inner parameters where a profile meets the axis, increasing: local minima of its distance that are on the axis, or
/// within `share` of the profile's size if it changes sides there.
fn axis_points(curve: &NurbsCurve3, frame: &Frame3, share: f64) -> Vec<f64> {
    let (a, b) = curve.domain();
    let size = size(curve, frame);
    let (on, near) = (ON_AXIS * size, share * size);
    let flat = |v: DVec3| v - frame.z * v.dot(frame.z);
    if keeps_off(curve, frame, 2.0 * near) {
        return Vec::new();
    }
    let slope = |t: f64| {
        let [point, tangent] = curve.tangent(t);
        flat(point - frame.origin).dot(flat(tangent))
    };
    let steps = SAMPLES * curve.points.len();
    let at = |i: usize| a + (b - a) * i as f64 / steps as f64;
    let ends = [curve.point(a), curve.point(b)];
    let mut found = Vec::new();
    let mut falling = slope(a) < 0.0;
    for i in 1..=steps {
        let before = std::mem::replace(&mut falling, slope(at(i)) < 0.0);
        if !before || falling {
            continue;
        }
        let [_, high] = bisected([at(i - 1), at(i)], 60, |t| slope(t) < 0.0);
        // A cut next to a knot would leave an empty span.
        let knot = curve.knots.iter().copied().find(|k| (k - high).abs() <= spline::SAME_PARAMETER * (b - a));
        let t = knot.unwrap_or(high);
        let point = curve.point(t);
        let passes = || {
            let [before, after] = [at(i - 1), at(i)].map(|t| flat(curve.point(t) - frame.origin));
            before.dot(after) < 0.0
        };
        let off = frame.meridian(point).x;
        if off <= near && (off <= on || passes()) && ends.iter().all(|end| end.distance(point) > near) {
            found.push(t);
        }
    }
    found
}

/// Cuts a profile where it meets the axis, or crosses it within `share` of its size. The piece with the profile's start
/// comes first. Empty if there is no cut. Cut ends lie exactly on the axis.
fn cut_at_axis(curve: &NurbsCurve3, frame: &Frame3, share: f64) -> Vec<NurbsCurve3> {
    let (a, b) = curve.domain();
    let mut cuts = axis_points(curve, frame, share);
    let Some(&first) = cuts.first() else { return Vec::new() };
    let size = size(curve, frame);
    let near = share * size;
    let start = curve.point(a);
    let through = start.distance(curve.point(b)) <= ON_AXIS * size && frame.meridian(start).x > near;
    let curve = if through {
        let moved = spline::restart(curve, first);
        let (start, end) = moved.domain();
        cuts[0] = start;
        cuts.push(end);
        moved
    } else {
        cuts.insert(0, a);
        cuts.push(b);
        curve.clone()
    };
    let mut pieces: Vec<NurbsCurve3> = cuts.windows(2).map(|ends| spline::piece(&curve, ends[0], ends[1])).collect();
    pieces.iter_mut().for_each(|piece| ends_onto_axis(piece, frame, near));
    if through {
        pieces.rotate_right(1);
    }
    pieces
}

/// Moves ends within `near` of the axis exactly onto it: they are poles of the surface.
pub(super) fn ends_onto_axis(curve: &mut NurbsCurve3, frame: &Frame3, near: f64) {
    for k in [0, curve.points.len() - 1] {
        let DVec2 { x: off, y: height } = frame.meridian(curve.points[k]);
        if off <= near {
            curve.points[k] = frame.origin + frame.z * height;
        }
    }
}

/// A profile rotated into the half plane of distance and height.
struct Meridian<'a> {
    curve: &'a NurbsCurve3,
    frame: &'a Frame3,
    /// Points along it and the longest distance between neighbours, made when they are asked for.
    points: OnceCell<(Vec<DVec2>, f64)>,
    /// Centre and radius of a half circle between two points of the axis.
    round: Option<(DVec2, f64)>,
}

impl<'a> Meridian<'a> {
    /// `sphere`: the one that the profile sweeps, if it is known to.
    fn new(curve: &'a NurbsCurve3, frame: &'a Frame3, sphere: Option<&(Surface, bool)>) -> Self {
        let round = match sphere {
            Some((Surface::Sphere { frame: about, radius }, _)) => Some((frame.meridian(about.origin), *radius)),
            _ => None,
        };
        Self { curve, frame, points: OnceCell::new(), round }
    }

    fn points(&self) -> &(Vec<DVec2>, f64) {
        self.points.get_or_init(|| {
            let steps = SAMPLES * self.curve.points.len();
            let points: Vec<DVec2> = (0..=steps).map(|i| self.at(i as f64 / steps as f64)).collect();
            let longest = points.windows(2).map(|w| w[0].distance(w[1])).fold(0.0, f64::max);
            (points, longest)
        })
    }

    /// Whether it begins and ends within this distance of the axis.
    fn spans_axis(&self, within: f64) -> bool {
        let (points, _) = self.points();
        points[0].x <= within && points[points.len() - 1].x <= within
    }

    /// Whether the normal of the surface of a profile between two points of the axis leads outwards: the sign of the
    /// volume in it.
    fn leads_outwards(&self) -> bool {
        let square = |a: f64, b: f64| a * a + a * b + b * b;
        self.points().0.windows(2).map(|w| square(w[0].x, w[1].x) * (w[1].y - w[0].y)).sum::<f64>() > 0.0
    }

    /// The point at this share of the parameters.
    fn at(&self, share: f64) -> DVec2 {
        let (a, b) = self.curve.domain();
        self.frame.meridian(self.curve.point(a + (b - a) * share))
    }

    /// Distance from the polyline through its points, and the segment that is nearest; from a half circle itself.
    fn nearest(&self, p: DVec2) -> (f64, usize) {
        if let Some((centre, radius)) = self.round {
            return ((p.distance(centre) - radius).abs(), 0);
        }
        let to = |pair: &[DVec2]| {
            let along = pair[1] - pair[0];
            let share = (p - pair[0]).dot(along) / along.length_squared();
            p.distance(pair[0] + along * if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 })
        };
        let all = self.points().0.windows(2).map(to).zip(0..);
        all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0))
    }

    /// Distance from the profile itself, given what is [`nearest`](Self::nearest): a golden-section search around that
    /// segment. One that is at most `enough` may be too large.
    fn exact_distance(&self, p: DVec2, (distance, k): (f64, usize), enough: f64) -> f64 {
        /// Each step keeps this share of the interval, and one of the two points inside it.
        const KEPT: f64 = 0.618_033_988_749_894_9;
        if self.round.is_some() {
            return distance;
        }
        let steps = (self.points().0.len() - 1) as f64;
        let at = |share: f64| (self.at(share).distance(p), share);
        let (mut low, mut high) = ((k as f64 - 1.0).max(0.0) / steps, (k as f64 + 2.0).min(steps) / steps);
        let (mut a, mut b) = (at(high - KEPT * (high - low)), at(low + KEPT * (high - low)));
        for _ in 0..34 {
            if a.0.min(b.0) <= enough {
                break;
            }
            if a.0 <= b.0 {
                (high, b) = (b.1, a);
                a = at(high - KEPT * (high - low));
            } else {
                (low, a) = (a.1, b);
                b = at(low + KEPT * (high - low));
            }
        }
        a.0.min(b.0)
    }

    /// Whether its points are at most `near` from another one.
    fn is_along(&self, other: &Self, near: f64) -> bool {
        match (self.round, other.round) {
            (Some((p, r)), Some((q, s))) => p.distance(q) + (r - s).abs() <= near,
            _ => self.points().0.iter().all(|p| other.exact_distance(*p, other.nearest(*p), near) <= near),
        }
    }
}

/// At most 1024 of the points, since each is compared with every step of a profile.
fn thinned(points: &[DVec3]) -> impl Iterator<Item = &DVec3> {
    points.iter().step_by(points.len().div_ceil(1024).max(1))
}

/// The piece of a profile between two meetings with the axis whose surface is nearest to `on`. At a crossing with the
/// axis the normal flips, so that an offset separates into sheets.
pub(super) fn sheet(curve: &NurbsCurve3, frame: &Frame3, on: &[DVec3]) -> NurbsCurve3 {
    let miss = |piece: &NurbsCurve3| -> f64 {
        let profile = Meridian::new(piece, frame, None);
        thinned(on).map(|p| profile.nearest(frame.meridian(*p)).0).sum()
    };
    let pieces = cut_at_axis(curve, frame, PASSING).into_iter().map(|piece| (miss(&piece), piece));
    pieces.min_by(|p, q| p.0.total_cmp(&q.0)).map_or_else(|| curve.clone(), |(_, piece)| piece)
}

/// Reduces a surface of revolution whose profile meets the axis to the one sheet that contains a face's boundary `on`,
/// as a sphere if it is one. Other surfaces are unchanged.
///
/// Sheets that coincide (a circle rotated about its diameter) have opposite normals. The face is on the one with most
/// of the profile parameters that the file states (`along`). If it states none, `is_outwards` chooses the half of a
/// sphere from the centre and the way to a pole: whether the surface's normal leads away from the centre. Else the face
/// is on the sheet of the profile's start.
///
/// If the boundary is only points of the axis, and its sheets begin and end there and are no spheres, the face is on
/// the first of them whose normal leads outwards if `same_sense`, else inwards: the inner or the outer sheet of a torus
/// that meets its axis.
///
/// Keeps all sheets if none leads that way, if the boundary lies on several sheets otherwise, or if there is no
/// boundary. All sheets of a circle become a torus.
///
/// A torus that touches its axis ends there, at both sides, unless an edge comes to that point (`meets`; `None` for a
/// face without edges): such an edge may go on at the other side.
pub(super) fn one_sheet(
    stated: Stated,
    on: impl FnOnce() -> Vec<DVec3>,
    along: impl FnOnce() -> Vec<f64>,
    is_outwards: impl FnOnce(DVec3, DVec3) -> Option<bool>,
    meets: impl FnOnce(DVec3) -> Option<bool>,
    same_sense: bool,
) -> Stated {
    let stated = horn(stated);
    if let Surface::Torus { frame, major, minor } = &stated.surface
        && major == minor
        && meets(frame.origin) == Some(false)
    {
        return Stated { surface: spindle(frame, *major, *minor, true), ..stated };
    }
    let Surface::Revolution { curve, frame } = &stated.surface else { return stated };
    let pieces = cut_at_axis(curve, frame, ON_AXIS);
    if pieces.is_empty() {
        return stated;
    }
    let spheres: Vec<Option<(Surface, bool)>> = pieces.iter().map(|piece| sphere(piece, frame)).collect();
    let profiles: Vec<Meridian> =
        pieces.iter().zip(&spheres).map(|(piece, s)| Meridian::new(piece, frame, s.as_ref())).collect();
    let on: Vec<DVec2> = thinned(&on()).map(|p| frame.meridian(*p)).collect();
    let first = on.first().copied().unwrap_or_default();
    let same = COINCIDENT * size(curve, frame);
    let extent = on.iter().map(|p| p.x.max((p.y - first.y).abs())).fold(0.0, f64::max);
    let widest = same.max(OFF_SHEET * extent);
    let misses: Vec<Vec<f64>> = on.iter().map(|p| misses(&profiles, *p, widest, 0.5 * same)).collect();
    let least = |misses: &Vec<f64>| misses.iter().copied().fold(f64::INFINITY, f64::min);
    // A boundary as far off its surface as its worst point may be nearer to another sheet at the others. A boundary
    // that is one vertex has no size.
    let slack = same.max((2.0 * misses.iter().map(least).fold(0.0, f64::max)).min(OFF_SHEET * extent));
    let mut holds = vec![true; pieces.len()];
    for misses in &misses {
        let most = least(misses) + slack;
        holds.iter_mut().zip(misses).for_each(|(holds, miss)| *holds &= *miss <= most);
    }
    let held: Vec<usize> = (0..pieces.len()).filter(|k| holds[*k]).collect();
    let is_along = |k: usize, other: usize| profiles[k].is_along(&profiles[other], same);
    let chosen = match held.as_slice() {
        [] => None,
        [only] => Some(*only),
        [_, ..]
            if !on.is_empty()
                && on.iter().all(|p| p.x <= same)
                && held.iter().all(|&k| spheres[k].is_none() && profiles[k].spans_axis(same)) =>
        {
            held.iter().copied().find(|&k| profiles[k].leads_outwards() == (same_sense != stated.turned))
        }
        [first, others @ ..] => {
            others.iter().all(|&other| is_along(*first, other) && is_along(other, *first)).then(|| {
                let (a, b) = curve.domain();
                let along = along();
                let stated = |k: usize| along.iter().filter(|t| is_inside(&pieces[k], **t, b - a)).count();
                let halves = || held.iter().filter_map(|&k| Some((k, spheres[k].as_ref()?)));
                let by_side = || {
                    let (_, (Surface::Sphere { frame, radius }, _)) = halves().next()? else { return None };
                    let outwards = is_outwards(frame.origin, frame.z * *radius)?;
                    halves().find(|(_, (_, inwards))| *inwards != outwards).map(|(k, _)| k)
                };
                let by_side = if along.is_empty() { by_side() } else { None };
                // The first of those with as many.
                by_side.unwrap_or_else(|| held.iter().copied().rev().max_by_key(|k| stated(*k)).unwrap_or(*first))
            })
        }
    };
    drop(profiles);
    let frame = *frame;
    let (simple, profile) = match chosen.and_then(|k| pieces.into_iter().zip(spheres).nth(k)) {
        Some((piece, sphere)) => (sphere, piece),
        None => (torus(curve, &frame), curve.clone()),
    };
    match simple {
        Some((surface, inwards)) => Stated { surface, turned: stated.turned != inwards, note: stated.note },
        None => Stated { surface: Surface::Revolution { curve: profile, frame }, ..stated },
    }
}

/// Distances of a point from profiles. One of at most `enough` may be too large. Of one that exceeds the least by more
/// than `slack`, only that it does is known.
fn misses(profiles: &[Meridian<'_>], p: DVec2, slack: f64, enough: f64) -> Vec<f64> {
    let nearest: Vec<(f64, usize)> = profiles.iter().map(|profile| profile.nearest(p)).collect();
    // A profile is taken to be no further from its polyline than two of its points are from each other.
    let off = |profile: &Meridian<'_>| if profile.round.is_some() { 0.0 } else { profile.points().1 };
    let ends = profiles.iter().zip(&nearest).map(|(profile, near)| near.0 + off(profile));
    let most = ends.fold(f64::INFINITY, f64::min) + slack;
    let exact = |(profile, near): (&Meridian<'_>, (f64, usize))| {
        if near.0 - off(profile) > most { near.0 } else { profile.exact_distance(p, near, enough) }
    };
    profiles.iter().zip(nearest).map(exact).collect()
}

/// Whether a parameter of a closed curve, any number of periods on, is between the ends of its piece.
fn is_inside(piece: &NurbsCurve3, t: f64, period: f64) -> bool {
    let (a, b) = piece.domain();
    let (edge, after) = (COINCIDENT * period, (t - a).rem_euclid(period));
    edge < after && after < b - a - edge
}

/// The sphere that a half circle between two points of the axis sweeps, and whether the sweep's normal points inwards.
/// `None` for other profiles.
fn sphere(piece: &NurbsCurve3, frame: &Frame3) -> Option<(Surface, bool)> {
    let (a, b) = piece.domain();
    let ends = [a, b].map(|t| frame.meridian(piece.point(t)));
    let radius = 0.5 * (ends[1].y - ends[0].y).abs();
    let tolerance = 1e-9 * radius;
    let origin = frame.origin + frame.z * (0.5 * (ends[0].y + ends[1].y));
    let [middle, tangent] = piece.tangent(0.5 * (a + b));
    let side = frame.z.cross(middle - origin).try_normalize()?;
    let round = ends[0].x.max(ends[1].x) <= tolerance && is_round(piece, (origin, side), radius, tolerance);
    round.then(|| {
        (Surface::Sphere { frame: Frame3 { origin, ..*frame }, radius }, side.cross(tangent).dot(middle - origin) < 0.0)
    })
}

/// The torus of a circle that touches the axis of revolution. Other surfaces are unchanged.
fn horn(stated: Stated) -> Stated {
    let Surface::Revolution { curve, frame } = &stated.surface else { return stated };
    let (a, b) = curve.domain();
    if curve.point(a).distance(curve.point(b)) > ON_AXIS * size(curve, frame) {
        return stated;
    }
    match torus(curve, frame) {
        Some((Surface::Torus { frame, major, minor }, inwards)) if (major - minor).abs() <= ON_AXIS * minor => {
            let surface = Surface::Torus { frame, major: minor, minor };
            Stated { surface, turned: stated.turned != inwards, note: stated.note }
        }
        _ => stated,
    }
}

/// The outer ("apple") or inner ("lemon") part of a torus that meets its own axis, as the surface of revolution of an
/// arc.
///
/// The arc's ends lie exactly on the axis. Parameters are the torus's, up to the arc's parametrisation.
pub(super) fn spindle(frame: &Frame3, major: f64, minor: f64, outer: bool) -> Surface {
    // The tube's circle crosses the axis at this angle.
    let half = libm::acos(-major / minor);
    let (middle, half) = if outer { (0.0, half) } else { (PI, PI - half) };
    let plane = Frame3 { origin: frame.origin + frame.x * major, x: frame.x, y: frame.z, z: -frame.y };
    let mut curve = NurbsCurve3::arc(&plane, minor, minor, middle - half, middle + half);
    ends_onto_axis(&mut curve, frame, f64::INFINITY);
    Surface::Revolution { curve, frame: *frame }
}

/// The torus that a whole circle in a plane through the axis sweeps, and whether the sweep's normal points inwards.
/// `None` for other profiles.
fn torus(curve: &NurbsCurve3, frame: &Frame3) -> Option<(Surface, bool)> {
    let (a, b) = curve.domain();
    let [p, q, r] = [0.0, 1.0, 2.0].map(|k| curve.point(a + (b - a) * k / 3.0));
    let (to_q, to_r) = (q - p, r - p);
    let across = to_q.cross(to_r);
    let centre = across.cross(to_q) * to_r.length_squared() + to_r.cross(across) * to_q.length_squared();
    let centre = p + centre / (2.0 * across.length_squared());
    let (minor, out) = (p.distance(centre), frame.radial(centre));
    let (x, major) = (out.try_normalize()?, out.length());
    let (side, tolerance) = (frame.z.cross(x), 1e-9 * (minor + major));
    let round = p.distance(curve.point(b)) <= tolerance && is_round(curve, (centre, side), minor, tolerance);
    round.then(|| {
        let frame = Frame3 { origin: centre - out, x, y: side, z: frame.z };
        let inwards = (p - centre).cross(curve.tangent(a)[1]).dot(side) > 0.0;
        (Surface::Torus { frame, major, minor }, inwards)
    })
}

/// Whether a curve lies on the circle of this centre, normal and radius, to `tolerance`.
fn is_round(curve: &NurbsCurve3, (centre, normal): (DVec3, DVec3), radius: f64, tolerance: f64) -> bool {
    let (a, b) = curve.domain();
    // A span of degree p that is not on the circle meets it at most 2 p times.
    let samples = (2 * curve.degree + 1) * curve.points.len();
    let on = |i: usize| {
        let out = curve.point(a + (b - a) * i as f64 / samples as f64) - centre;
        (out.length() - radius).abs() <= tolerance && out.dot(normal).abs() <= tolerance
    };
    radius > 0.0 && (0..=samples).all(on)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_that_keep_off_the_axis_meet_it_nowhere() {
        let frame = Frame3 { origin: DVec3::new(1.0, 2.0, 3.0), ..Frame3::WORLD };
        let profile = |from: f64| {
            NurbsCurve3::bezier(
                [(5.0, 0.0), (from, 1.0), (5.0, 2.0)].map(|(x, z)| frame.place(DVec3::new(x, 0.0, z))).to_vec(),
                Vec::new(),
            )
        };
        // The curve's middle is at `2.5 + from / 2`.
        for (from, keeps, meetings) in [(1.0, true, 0), (-4.0, false, 0), (-5.0, false, 1), (-9.0, false, 2)] {
            assert_eq!(keeps_off(&profile(from), &frame, 1e-6), keeps, "{from}");
            assert_eq!(axis_points(&profile(from), &frame, 1e-6).len(), meetings, "{from}");
        }
    }

    #[test]
    fn distances_from_half_circles_are_those_of_the_search() {
        let frame = Frame3 { origin: DVec3::new(1.0, 2.0, 3.0), ..Frame3::WORLD };
        let plane = Frame3 { origin: frame.place(DVec3::Z), x: frame.z, y: frame.x, z: frame.y };
        let half = NurbsCurve3::arc(&plane, 2.0, 2.0, 0.0, std::f64::consts::PI);
        let found = sphere(&half, &frame);
        let whole = Meridian::new(&half, &frame, found.as_ref());
        assert!(whole.round.is_some());
        let other = NurbsCurve3::line(frame.place(DVec3::new(9.0, 0.0, 0.0)), frame.place(DVec3::new(9.0, 0.0, 1.0)));
        let profiles = [Meridian::new(&half, &frame, None), Meridian::new(&other, &frame, None)];
        for (x, y) in [(0.0, 3.0), (1.0, 0.5), (2.0, 1.0), (3.5, -2.0), (1.0, 1.0), (8.0, 0.5)] {
            let p = DVec2::new(x, y);
            let exact = whole.nearest(p).0;
            let searched = misses(&profiles, p, 1e-3, 0.0);
            let is_near = exact <= searched[1];
            assert!(if is_near { (exact - searched[0]).abs() < 1e-6 } else { searched[0] > searched[1] + 1e-3 }, "{p}");
            assert_eq!(searched[1] > exact + 1e-3, is_near, "{p}");
        }
    }
}
