//! Curves of ISO 10303-42 -> NURBS, either as the carrier of an edge between two vertices or as a bounded curve.
//!
//! Conics become rational quadratics (the model's arcs, and those of `spline`). B-splines stay as they are. Curves that
//! only wrap another one (surface curves, trimmed curves) are unwrapped. Segments of composite curves are joined to one
//! spline; composites may share segments, and be segments themselves.

use super::place::Geometry;
use super::spline::{self, hyperbolic_arc, parabolic_arc};
use super::stated_spline::{Form, check_degree, check_weights, drop_breaks, knots_of};
use super::table::{Entity, MAX_DEPTH, Read, Trouble, check_depth, missing, out_of_range};
use super::units::{Ends, ROUNDING, rounding};
use super::values::{Attribute, List, Map};
use crate::math::boxes::around;
use crate::model::{CurveKind, CurveTrouble, Frame3, NurbsCurve3, StepTrouble};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Ends of a spline closer than this are one point; millimetres.
const SAME_PLACE: f64 = 1e-6;

/// A curve with its parametrisation, before an edge or a trim bounds it. The unbounded kinds keep their form.
#[derive(Clone, Debug)]
pub(super) enum Carrier {
    Line {
        point: DVec3,
        along: DVec3,
    },
    /// Circle or ellipse.
    Round {
        frame: Frame3,
        a: f64,
        b: f64,
    },
    Hyperbola {
        frame: Frame3,
        a: f64,
        b: f64,
    },
    Parabola {
        frame: Frame3,
        focal: f64,
    },
    Spline {
        curve: NurbsCurve3,
        kind: CurveKind,
    },
}

impl Carrier {
    pub(super) fn spline(curve: NurbsCurve3) -> Self {
        Self::Spline { curve, kind: CurveKind::Spline }
    }

    /// The parameter of the foot of `p`; an angle on circles and ellipses.
    pub(super) fn parameter(&self, p: DVec3) -> f64 {
        match self {
            Self::Line { point, along } => (p - *point).dot(*along) / along.length_squared(),
            Self::Round { frame, a, b } => {
                let d = frame.local(p);
                libm::atan2(d.y / b, d.x / a)
            }
            Self::Hyperbola { frame, b, .. } => libm::asinh(frame.local(p).y / b),
            Self::Parabola { frame, focal } => frame.local(p).y / (2.0 * focal),
            Self::Spline { curve, .. } => spline::nearest(curve, p),
        }
    }

    /// The part over a range of parameters, low to high.
    pub(super) fn arc(&self, (low, high): (f64, f64)) -> NurbsCurve3 {
        match *self {
            Self::Line { point, along } => NurbsCurve3::line(point + along * low, point + along * high),
            Self::Round { frame, a, b } => NurbsCurve3::arc(&frame, a, b, low, high),
            Self::Hyperbola { frame, a, b } => hyperbolic_arc(frame.origin, frame.x * a, frame.y * b, (low, high)),
            Self::Parabola { frame, focal } => {
                parabolic_arc(frame.origin, frame.x * focal, frame.y * focal, (low, high))
            }
            Self::Spline { ref curve, .. } => spline::piece(curve, low, high),
        }
    }

    /// A conic in the other direction.
    fn turned(mut self) -> Self {
        if let Self::Round { frame, .. } | Self::Hyperbola { frame, .. } | Self::Parabola { frame, .. } = &mut self {
            (frame.y, frame.z) = (-frame.y, -frame.z);
        }
        self
    }
}

/// An edge's curve, running from its start vertex to its end vertex.
#[derive(Clone, Debug)]
pub(super) struct BoundedCurve {
    pub(super) curve: NurbsCurve3,
    pub(super) range: (f64, f64),
    pub(super) kind: CurveKind,
}

impl BoundedCurve {
    fn whole(curve: NurbsCurve3, kind: CurveKind) -> Self {
        Self { range: curve.domain(), curve, kind }
    }
}

/// The segment between two vertices; `None` if they coincide.
pub(super) fn straight(ends: Ends) -> Option<BoundedCurve> {
    (ends.start != ends.end).then(|| BoundedCurve::whole(NurbsCurve3::line(ends.start, ends.end), CurveKind::Line))
}

const COMPOSITES: [&str; 4] =
    ["COMPOSITE_CURVE", "COMPOSITE_CURVE_ON_SURFACE", "BOUNDARY_CURVE", "OUTER_BOUNDARY_CURVE"];

/// Curves that only add pcurves to another curve. A complex instance states both in SURFACE_CURVE, so
/// that comes first.
pub(super) const WRAPPERS: [&str; 4] = ["SURFACE_CURVE", "SEAM_CURVE", "INTERSECTION_CURVE", "BOUNDED_SURFACE_CURVE"];

impl Geometry<'_> {
    /// The part of curve `id` between two vertices, along or against the curve's sense. `None` for an edge without
    /// length.
    pub(super) fn between_ends(&self, id: u64, ends: Ends, same_sense: bool) -> Read<Option<BoundedCurve>> {
        self.along(self.carrier(id, 0)?, ends, same_sense, id)
    }

    /// Like [`between_ends`](Self::between_ends), for a curve already read: its carrier, and whether it has its
    /// direction.
    pub(super) fn along(
        &self,
        (carrier, same): (Carrier, bool),
        ends: Ends,
        same_sense: bool,
        id: u64,
    ) -> Read<Option<BoundedCurve>> {
        let tolerance = self.units.tolerance;
        let forward = same == same_sense;
        let carrier = if forward { carrier } else { carrier.turned() };
        let chord = ends.start.distance(ends.end);
        let rounding = |size: f64| rounding([ends.start, ends.end], size);
        let bounded = match carrier {
            Carrier::Line { .. } => return Ok(straight(ends)),
            Carrier::Round { frame, a, b } => {
                let from = carrier.parameter(ends.start);
                let sweep = (carrier.parameter(ends.end) - from).rem_euclid(TAU);
                let rounding = rounding(frame.origin.abs().max_element() + a.max(b));
                let whole = ends.whole.holds(chord, spline::ROUNDED * 2.0 * a.max(b), rounding, self.units);
                // Rounding may give an empty sweep either sign.
                if !whole && chord <= rounding {
                    return Ok(None);
                }
                if !whole && from + sweep <= from {
                    return Err(Trouble::new(id, CurveTrouble::SameParameter));
                }
                let sweep = if whole { TAU } else { sweep };
                let kind = if a == b { CurveKind::Circle } else { CurveKind::Conic };
                BoundedCurve::whole(carrier.arc((from, from + sweep)), kind)
            }
            Carrier::Hyperbola { .. } | Carrier::Parabola { .. } => {
                // On an open curve the ends alone determine the arc; a contradicting sense is ignored.
                let [from, to] = [ends.start, ends.end].map(|p| carrier.parameter(p));
                let arc = if from <= to {
                    carrier.arc(increasing(from, to, id)?)
                } else {
                    carrier.arc(increasing(to, from, id)?).reversed()
                };
                BoundedCurve::whole(arc, CurveKind::Conic)
            }
            Carrier::Spline { curve, kind } => {
                let curve = if forward { curve } else { curve.reversed() };
                let [low, high] = around(curve.points.iter().copied());
                let near = spline::ROUNDED * low.distance(high);
                let together = ends.whole.holds(chord, near, rounding(0.0), self.units);
                match cut((curve, near), ends, together, tolerance) {
                    Some((curve, range)) => BoundedCurve { curve: spline::window(curve, range), range, kind },
                    None if chord <= tolerance => return Ok(None),
                    None => return Err(Trouble::new(id, CurveTrouble::SameParameter)),
                }
            }
        };
        Ok(Some(bounded))
    }

    /// Whether a curve is closed, so that two points on it bound two arcs.
    pub(super) fn is_closed(&self, id: u64) -> bool {
        match self.carrier(id, 0) {
            Ok((Carrier::Round { .. }, _)) => true,
            Ok((Carrier::Spline { curve, .. }, _)) => {
                let (a, b) = curve.domain();
                curve.point(a).distance(curve.point(b)) <= SAME_PLACE.min(self.units.tolerance)
            }
            _ => false,
        }
    }

    /// Whether a curve is an untrimmed circle or ellipse.
    pub(super) fn is_conic(&self, id: u64) -> bool {
        self.unwrap(id, 0).is_ok_and(|curve| curve.is("CIRCLE") || curve.is("ELLIPSE"))
    }

    /// Whether the NURBS form of a curve has other parameters than the file: that of a composite of several segments,
    /// of a polyline that repeats points, which are dropped, and of what is defined by such a curve.
    pub(super) fn has_other_parameters(&self, id: u64, depth: usize) -> bool {
        let Ok(curve) = self.unwrap(id, depth) else { return false };
        if curve.is("POLYLINE") {
            let points = curve.fields("POLYLINE", 1).links(0).and_then(|links| self.points(links));
            return points.is_ok_and(|points| points.windows(2).any(|pair| pair[0] == pair[1]));
        }
        let kind = curve.first_of(["TRIMMED_CURVE", "CURVE_REPLICA", "OFFSET_CURVE_3D"]);
        let parent = kind.and_then(|kind| curve.fields(kind, 1).optional(0)).filter(|_| depth < MAX_DEPTH);
        curve.is_any(COMPOSITES) || parent.is_some_and(|parent| self.has_other_parameters(parent, depth + 1))
    }

    /// A curve with ends of its own, in its own direction. Circles and ellipses count as bounded: one turn from angle
    /// 0.
    pub(super) fn bounded(&self, id: u64, depth: usize) -> Read<NurbsCurve3> {
        let instance = self.unwrap(id, depth)?;
        check_depth(depth, id, "curves")?;
        if instance.is("TRIMMED_CURVE") {
            return self.trimmed(instance, depth);
        }
        if instance.is("CURVE_REPLICA") {
            let (parent, similarity) = self.curve_replica(instance)?;
            return Ok(similarity.curve(self.bounded(parent, depth + 1)?));
        }
        if instance.is("OFFSET_CURVE_3D") {
            return self.bounded_offset(instance, depth);
        }
        match self.carrier(instance.id, depth)?.0 {
            carrier @ Carrier::Round { .. } => Ok(carrier.arc((0.0, TAU))),
            Carrier::Spline { curve, .. } => Ok(curve),
            Carrier::Line { .. } | Carrier::Hyperbola { .. } | Carrier::Parabola { .. } => {
                Err(Trouble::new(instance.id, CurveTrouble::Endless { keyword: instance.keyword() }))
            }
        }
    }

    /// Follows references through curves that only add pcurves to another curve.
    pub(super) fn unwrap(&self, id: u64, depth: usize) -> Read<Entity<'_>> {
        let mut instance = self.get(id)?;
        for _ in depth..MAX_DEPTH {
            let Some(kind) = instance.first_of(WRAPPERS) else { return Ok(instance) };
            instance = self.get(instance.fields(kind, 1).reference(0)?)?;
        }
        Err(Trouble::new(id, StepTrouble::TooDeep { what: "curves" }))
    }

    /// The carrier of a curve, and whether the curve has the carrier's direction.
    pub(super) fn carrier(&self, id: u64, depth: usize) -> Read<(Carrier, bool)> {
        let instance = self.unwrap(id, depth)?;
        let id = instance.id;
        check_depth(depth, id, "curves")?;
        let refused = |value| Trouble::new(id, out_of_range("a radius or axis", value, "mm"));
        let positive = |value: f64| if value > 0.0 && value.is_finite() { Ok(value) } else { Err(refused(value)) };
        let length = self.units.length;
        let carrier = if instance.is("LINE") {
            let fields = instance.fields("LINE", 1);
            Carrier::Line { point: self.point(fields.reference(0)?)?, along: self.vector(fields.reference(1)?)? }
        } else if instance.is("CIRCLE") {
            let radius = instance.fields("CIRCLE", 2).real(0)? * length;
            let radius = if radius == 0.0 { Err(Trouble::new(id, CurveTrouble::OnePoint)) } else { positive(radius) }?;
            Carrier::Round { frame: self.conic_frame(instance)?, a: radius, b: radius }
        } else if let Some(kind) = instance.first_of(["ELLIPSE", "HYPERBOLA"]) {
            let own = instance.fields(kind, 2);
            let (a, b) = (positive(own.real(0)? * length)?, positive(own.real(1)? * length)?);
            let frame = self.conic_frame(instance)?;
            if kind == "ELLIPSE" { Carrier::Round { frame, a, b } } else { Carrier::Hyperbola { frame, a, b } }
        } else if instance.is("PARABOLA") {
            let focal = positive(instance.fields("PARABOLA", 2).real(0)? * length)?;
            Carrier::Parabola { frame: self.conic_frame(instance)?, focal }
        } else if instance.is("TRIMMED_CURVE") {
            let fields = instance.fields("TRIMMED_CURVE", 1);
            let (carrier, same) = self.carrier(fields.reference(0)?, depth + 1)?;
            return Ok((carrier, same == fields.flag(3, true)));
        } else if instance.is("CURVE_REPLICA") {
            let (parent, similarity) = self.curve_replica(instance)?;
            let (carrier, same) = self.carrier(parent, depth + 1)?;
            return Ok((similarity.carrier(carrier), same));
        } else if instance.is("OFFSET_CURVE_3D") {
            return self.offset_curve(instance, depth);
        } else if instance.is("PCURVE") {
            return self.pcurve(instance, depth);
        } else if instance.is("POLYLINE") {
            let mut points = self.points(instance.fields("POLYLINE", 1).links(0)?)?;
            points.dedup();
            Carrier::Spline { curve: polyline(points, id)?, kind: CurveKind::Polyline }
        } else if instance.is_any(COMPOSITES) {
            Carrier::spline(self.composite(instance, depth)?)
        } else if instance.is_any(SPLINES) {
            Carrier::spline(self.b_spline(instance)?)
        } else {
            return Err(instance.not_read("curves"));
        };
        Ok((carrier, true))
    }

    fn conic_frame(&self, conic: Entity<'_>) -> Read<Frame3> {
        self.frame(conic.fields("CONIC", 1).reference(0)?)
    }

    /// A `TRIMMED_CURVE`, from its first trim to its second.
    fn trimmed(&self, instance: Entity<'_>, depth: usize) -> Read<NurbsCurve3> {
        let id = instance.id;
        let fields = instance.fields("TRIMMED_CURVE", 1);
        let basis = fields.reference(0)?;
        let (carrier, same) = self.carrier(basis, depth + 1)?;
        let sense = fields.flag(3, true);
        let only_points_tell = self.has_other_parameters(basis, depth + 1);
        for trim in [fields.list(1)?, fields.list(2)?] {
            if only_points_tell && !trim.iter().any(|of| of.link().is_some()) {
                return Err(Trouble::new(id, CurveTrouble::OnComposite));
            }
        }
        let by_point = only_points_tell || fields.keyword(4) == "CARTESIAN";
        let t1 = self.trim(&carrier, fields.list(1)?, by_point, id)?;
        let t2 = self.trim(&carrier, fields.list(2)?, by_point, id)?;
        // `low` to `high` follows the carrier; the trimmed curve has that direction if both senses agree.
        let (mut low, mut high) = if sense { (t1, t2) } else { (t2, t1) };
        if !same {
            (low, high) = (high, low);
        }
        let curve = match carrier {
            Carrier::Line { .. } if low == high => return Err(Trouble::new(id, CurveTrouble::OnePoint)),
            Carrier::Line { .. } => carrier.arc((low, high)),
            Carrier::Round { .. } => {
                let sweep = (high - low).rem_euclid(TAU);
                // Rounded trims of a full turn may end a little above it. Two trims at one angle are a full turn, too.
                let whole = sweep <= ROUNDING || (high - low > PI && sweep < 1e-6);
                let sweep = if whole { TAU } else { sweep };
                carrier.arc((low, low + sweep))
            }
            Carrier::Hyperbola { .. } | Carrier::Parabola { .. } => carrier.arc(increasing(low, high, id)?),
            Carrier::Spline { curve, .. } => {
                let (a, b) = curve.domain();
                let (low, high) = (low.clamp(a, b), high.clamp(a, b));
                let closed = curve.point(a).distance(curve.point(b)) <= self.units.tolerance;
                // At the seam of a closed curve, a piece starts at the first parameter and ends at the last.
                let slack = if closed { spline::SAME_PARAMETER * (b - a) } else { -1.0 };
                let (low, high) = (if low >= b - slack { a } else { low }, if high <= a + slack { b } else { high });
                if low < high {
                    spline::piece(&curve, low, high)
                } else if closed {
                    let moved = spline::restart(&curve, low);
                    let (start, end) = moved.domain();
                    spline::piece(&moved, start, (start + (high - low) + (b - a)).min(end))
                } else {
                    return Err(Trouble::new(id, missing("a trimmed curve", "length")));
                }
            }
        };
        Ok(if sense == same { curve } else { curve.reversed() })
    }

    /// The parameter of one trim on the carrier, angles in radians.
    fn trim(&self, carrier: &Carrier, select: List<'_>, by_point: bool, id: u64) -> Read<f64> {
        let value = select.iter().find_map(Attribute::number).map(|value| match carrier {
            Carrier::Round { .. } => value * self.units.angle,
            _ => value,
        });
        let point = select.iter().find_map(Attribute::link);
        let t = match (value, point) {
            (Some(value), point) if !by_point || point.is_none() => value,
            (_, Some(point)) => carrier.parameter(self.point(point)?),
            _ => return Err(Trouble::new(id, CurveTrouble::Trim)),
        };
        if t.is_finite() { Ok(t) } else { Err(Trouble::new(id, StepTrouble::NotFinite { what: "a trim" })) }
    }

    /// A B-spline curve of any form.
    fn b_spline(&self, instance: Entity<'_>) -> Read<NurbsCurve3> {
        let id = instance.id;
        let shape = instance.fields("B_SPLINE_CURVE", 1);
        let degree = shape.count(0)?;
        let points = self.points(shape.links(1)?)?;
        let count = points.len();
        check_degree(degree, count, id)?;
        let stated = instance.is("B_SPLINE_CURVE_WITH_KNOTS").then(|| instance.fields("B_SPLINE_CURVE_WITH_KNOTS", 6));
        let stated = stated.map(|own| Ok((own.counts(0)?, own.reals(1)?))).transpose()?;
        let knots = knots_of(stated, Form::of(instance, "CURVE"), count, degree, id)?;
        let weights = if instance.is("RATIONAL_B_SPLINE_CURVE") {
            check_weights(instance.fields("RATIONAL_B_SPLINE_CURVE", 6).reals(0)?, count, id)?
        } else {
            Vec::new()
        };
        let mut curve = NurbsCurve3 { degree, knots, points, weights };
        drop_breaks(&mut curve, self.units.tolerance, id)?;
        Ok(curve)
    }
}

pub(super) const SPLINES: [&str; 6] = [
    "B_SPLINE_CURVE",
    "B_SPLINE_CURVE_WITH_KNOTS",
    "RATIONAL_B_SPLINE_CURVE",
    "QUASI_UNIFORM_CURVE",
    "UNIFORM_CURVE",
    "BEZIER_CURVE",
];

fn increasing(from: f64, to: f64, id: u64) -> Read<(f64, f64)> {
    if from < to && (to - from).is_finite() { Ok((from, to)) } else { Err(Trouble::new(id, CurveTrouble::WrongOrder)) }
}

fn polyline(points: Vec<DVec3>, id: u64) -> Read<NurbsCurve3> {
    if points.len() < 2 {
        return Err(Trouble::new(id, CurveTrouble::OnePoint));
    }
    let last = (points.len() - 1) as f64;
    let mut knots = vec![0.0];
    knots.extend((0..points.len()).map(|i| i as f64));
    knots.push(last);
    Ok(NurbsCurve3 { degree: 1, knots, points, weights: Vec::new() })
}

/// The part of a spline between two vertices, forward; on a closed curve, possibly across its seam. Its ends are one
/// within `closes`.
fn cut(
    (curve, closes): (NurbsCurve3, f64),
    ends: Ends,
    together: bool,
    tolerance: f64,
) -> Option<(NurbsCurve3, (f64, f64))> {
    let (a, b) = curve.domain();
    let (first, last) = (curve.point(a), curve.point(b));
    let whole = (a, b);
    // Almost every edge uses its whole curve. Both ends of a short arc of a closed curve may lie near its seam.
    let chord = ends.start.distance(ends.end);
    let near = SAME_PLACE.min(tolerance).min(if together { f64::INFINITY } else { 0.25 * chord });
    if first.distance(ends.start) <= near && last.distance(ends.end) <= near {
        return Some((curve, whole));
    }
    let loops = first.distance(last) <= tolerance.max(closes);
    if together && !loops {
        return Some((curve, whole));
    }
    let slack = spline::SAME_PARAMETER * (b - a);
    let seam = |t: f64, p: DVec3| first.distance(p) <= near || t <= a + slack || t >= b - slack;
    let from = spline::nearest(&curve, ends.start);
    if together {
        if seam(from, ends.start) {
            return Some((curve, whole));
        }
        let moved = spline::restart(&curve, from);
        let range = moved.domain();
        return Some((moved, range));
    }
    let to = spline::nearest(&curve, ends.end);
    if !loops {
        return if from < to {
            Some((curve, (from, to)))
        } else if from > to {
            // The sense flag contradicts the vertices; the vertices decide.
            let range = ((a + b - from).max(a), (a + b - to).min(b));
            Some((curve.reversed(), range))
        } else {
            None
        };
    }
    let from = if seam(from, ends.start) { a } else { from };
    let to = if seam(to, ends.end) { b } else { to };
    if from < to {
        return Some((curve, (from, to)));
    }
    if !(a < from && from < b && to < from) {
        return None;
    }
    let moved = spline::restart(&curve, from);
    let (start, end) = moved.domain();
    Some((moved, (start, (to + (b - a)).min(end))))
}

impl Geometry<'_> {
    /// The segments of a `COMPOSITE_CURVE`, joined. Single points among them join nothing.
    fn composite(&self, instance: Entity<'_>, depth: usize) -> Read<NurbsCurve3> {
        let limit = self.table.budget.max_visits();
        if self.visits(instance, 0, &mut Map::default()) > limit {
            return Err(Trouble::new(instance.id, StepTrouble::TooManyVisits { what: "segments of curves", limit }));
        }
        let (mut pieces, mut point) = (Vec::new(), None);
        for segment in instance.fields("COMPOSITE_CURVE", 1).links(0)? {
            let fields = self.get(segment)?.fields("COMPOSITE_CURVE_SEGMENT", 0);
            match self.bounded(fields.reference(2)?, depth + 1) {
                Ok(piece) => pieces.push(if fields.flag(1, true) { piece } else { piece.reversed() }),
                Err(trouble) if trouble.is_point() => point = Some(trouble),
                Err(trouble) => return Err(trouble),
            }
        }
        let empty = || point.unwrap_or_else(|| Trouble::new(instance.id, missing("a composite curve", "segments")));
        spline::join(&pieces).ok_or_else(empty)
    }

    /// Number of instances that reading a curve visits, each as often as lists lead to it. `known`: what is counted.
    fn visits(&self, curve: Entity<'_>, depth: usize, known: &mut Map<u64, usize>) -> usize {
        if let Some(count) = known.get(&curve.id) {
            return *count;
        }
        // Curves that contain themselves are refused when they are read.
        known.insert(curve.id, 1);
        let mut count = 1_usize;
        curve.references(&mut |id| {
            let is_curve = |i: &Entity<'_>| i.types().any(|name| name.contains("CURVE") || name == "POLYLINE");
            let inner = self.table.find(id).filter(|inner| depth < MAX_DEPTH && is_curve(inner));
            count = count.saturating_add(inner.map_or(1, |inner| self.visits(inner, depth + 1, known)));
        });
        known.insert(curve.id, count);
        count
    }
}
