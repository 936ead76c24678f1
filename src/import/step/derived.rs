//! Derived curves and points (offset curves, pcurves, lines of constant parameter, points on curves and surfaces) ->
//! curves and points in space. Exact where a closed form exists, else cubic pieces, refined until sampled errors are
//! within the tolerance.

use super::curve::Carrier;
use super::offset::fitted;
use super::parameters::{Parametric, StatedAxes};
use super::place::Geometry;
use super::replica::Similarity;
use super::table::{Entity, Read, Trouble, missing};
use super::units::Units;
use crate::model::{CurveTrouble, FitTrouble, Frame3, NurbsCurve3, StepTrouble, Surface, breaks};
use glam::{DAffine3, DMat3, DVec3};

/// The curve through (`u`, `v`) along `axis`: 0 along u, 1 along v. Exact; it runs as the parameter grows. `u` and `v`
/// are natural parameters within the surface's domain.
fn isoline(surface: &Surface, axis: usize, [u, v]: [f64; 2]) -> Carrier {
    let point = surface.point(u, v);
    match (surface, axis) {
        (Surface::Plane { frame }, 0) => Carrier::Line { point, along: frame.x },
        (Surface::Plane { .. } | Surface::Cylinder { .. } | Surface::Cone { .. } | Surface::Extrusion { .. }, 1) => {
            Carrier::Line { point, along: surface.tangents(u, v)[2] }
        }
        (Surface::Extrusion { curve, direction }, _) => {
            let points = curve.points.iter().map(|p| *p + *direction * v).collect();
            Carrier::spline(NurbsCurve3 { points, ..curve.clone() })
        }
        (Surface::Sphere { frame, radius }, 1) => meridian(frame, u, 0.0, *radius),
        (Surface::Torus { frame, major, minor }, 1) => meridian(frame, u, *major, *minor),
        (Surface::Revolution { curve, frame }, 1) => {
            let (sin, cos) = libm::sincos(u);
            let turn = |p: DVec3| DVec3::new(p.x * cos - p.y * sin, p.x * sin + p.y * cos, p.z);
            let points = curve.points.iter().map(|p| frame.place(turn(frame.local(*p)))).collect();
            Carrier::spline(NurbsCurve3 { points, ..curve.clone() })
        }
        (Surface::Nurbs(net), _) => Carrier::spline(net.iso_line(1 - axis, [v, u][axis]).curve()),
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

/// Maximum nesting of points defined by each other (through curves and surfaces).
const MAX_NESTING: u8 = 3;

/// What an `OFFSET_CURVE_3D` states.
struct Offset {
    id: u64,
    basis: u64,
    /// Millimetres.
    distance: f64,
    /// A unit vector.
    reference: DVec3,
}

impl Offset {
    /// The way from a point of the basis with this tangent to that of the offset. `None` if the tangent vanishes or
    /// runs along the reference direction.
    fn way(&self, tangent: DVec3) -> Option<DVec3> {
        Some(self.reference.cross(tangent).try_normalize()? * self.distance)
    }

    /// [`way`](Self::way) of a line or a circle.
    fn aside(&self, tangent: DVec3) -> Read<DVec3> {
        self.way(tangent).ok_or_else(|| Trouble::new(self.id, FitTrouble::AlongBasis))
    }

    /// Whether the offset of a circle or ellipse is a circle.
    fn is_circle(&self, frame: &Frame3, a: f64, b: f64) -> bool {
        a == b && frame.z.cross(self.reference).length() <= 1e-12
    }

    fn vanishes(&self) -> FitTrouble {
        FitTrouble::Vanishes { distance_mm: self.distance, leaves: "a point of the circle" }
    }

    /// The offset of a bounded basis, in cubic pieces.
    fn fitted(&self, basis: &NurbsCurve3, tolerance: f64) -> Read<NurbsCurve3> {
        if let Some(t) = basis.kinks().first() {
            return Err(Trouble::new(self.id, FitTrouble::Corner { parameter: *t }));
        }
        let breaks = breaks(basis.degree, &basis.knots);
        let curve = fitted(&breaks, tolerance, |t| {
            let d = basis.derivatives(t);
            Ok(d.point + self.way(d.d1).ok_or(FitTrouble::NoDirection)?)
        });
        curve.map_err(|what| Trouble::new(self.id, what))
    }
}

impl Geometry<'_> {
    /// The carrier of an `OFFSET_CURVE_3D`: the basis, moved by `distance` along reference direction × tangent.
    pub(super) fn offset_curve(&self, instance: Entity<'_>, depth: usize) -> Read<(Carrier, bool)> {
        let offset = self.read_offset(instance)?;
        let Offset { id, basis, distance, reference } = offset;
        match self.carrier(basis, depth + 1)? {
            (Carrier::Line { point, along }, same) => {
                let sense = if same { along } else { -along };
                return Ok((Carrier::Line { point: point + offset.aside(sense)?, along }, same));
            }
            // The offset of a circle about the reference direction is a circle; positive distances lead inwards.
            (Carrier::Round { mut frame, a, b }, same) if offset.is_circle(&frame, a, b) => {
                let inwards = if (frame.z.dot(reference) > 0.0) == same { distance } else { -distance };
                let radius = a - inwards;
                if radius.abs() <= 1e-12 * a {
                    return Err(Trouble::new(id, offset.vanishes()));
                }
                if radius < 0.0 {
                    // Beyond the centre, the same angles lie on the other side.
                    (frame.x, frame.y) = (-frame.x, -frame.y);
                }
                return Ok((Carrier::Round { frame, a: radius.abs(), b: radius.abs() }, same));
            }
            _ => {}
        }
        Ok((Carrier::spline(offset.fitted(&self.bounded(basis, depth + 1)?, self.fit)?), true))
    }

    /// An `OFFSET_CURVE_3D` between the ends of its basis, with the parameters of that.
    pub(super) fn bounded_offset(&self, instance: Entity<'_>, depth: usize) -> Read<NurbsCurve3> {
        let offset = self.read_offset(instance)?;
        let mut curve = self.bounded(offset.basis, depth + 1)?;
        let [start, tangent] = curve.tangent(curve.domain().0);
        match self.carrier(offset.basis, depth + 1)?.0 {
            Carrier::Line { .. } => {
                let aside = offset.aside(tangent)?;
                curve.points.iter_mut().for_each(|p| *p += aside);
            }
            // All of a circle is at the same distance from the offset: it is scaled about its centre.
            Carrier::Round { frame, a, b } if offset.is_circle(&frame, a, b) => {
                let out = start - frame.origin;
                let scale = 1.0 + offset.aside(tangent)?.dot(out) / out.length_squared();
                if scale.abs() <= 1e-12 {
                    return Err(Trouble::new(offset.id, offset.vanishes()));
                }
                curve.points.iter_mut().for_each(|p| *p = frame.origin + (*p - frame.origin) * scale);
            }
            _ => curve = offset.fitted(&curve, self.fit)?,
        }
        Ok(curve)
    }

    fn read_offset(&self, instance: Entity<'_>) -> Read<Offset> {
        let id = instance.id;
        let own = instance.fields("OFFSET_CURVE_3D", 1);
        let (basis, distance) = (own.reference(0)?, self.length(own.real(1)?, id)?);
        let reference = self.direction(own.reference(3)?)?.try_normalize();
        let reference = reference.ok_or_else(|| Trouble::new(id, missing("an offset", "reference direction")))?;
        Ok(Offset { id, basis, distance, reference })
    }

    /// Reads a `PCURVE` or a `DEGENERATE_PCURVE`. Returns the surface, and the curve in the file's parameters.
    pub(super) fn parameter_curve(
        &self,
        pcurve: Entity<'_>,
        name: &'static str,
        depth: usize,
    ) -> Read<(Parametric, NurbsCurve3)> {
        let own = pcurve.fields(name, 1);
        let on = self.parametric(own.reference(0)?, depth + 1)?;
        Ok((on, self.plain().bounded(self.in_parameters(pcurve, name)?, depth + 1)?))
    }

    /// The curve that a `PCURVE` or a `DEGENERATE_PCURVE` states in the parameters of its surface.
    fn in_parameters(&self, pcurve: Entity<'_>, name: &'static str) -> Read<u64> {
        let items = self.get(pcurve.fields(name, 1).reference(1)?)?.fields("REPRESENTATION", 1).links(0)?;
        items.into_iter().next().ok_or_else(|| Trouble::new(pcurve.id, missing("a parameter curve", "items")))
    }

    /// Reads parameters as plain numbers; the surface converts each to a length or an angle.
    fn plain(&self) -> Self {
        Geometry { units: Units { length: 1.0, ..self.units }, ..*self }
    }

    /// The carrier of a `PCURVE` in space, and whether the curve has its direction. Exact on a plane and along u or v,
    /// else approximated within the tolerance. The vertices of its edge bound a line; one that is neither on a plane
    /// nor along u or v must end where the surface does.
    pub(super) fn pcurve(&self, pcurve: Entity<'_>, depth: usize) -> Read<(Carrier, bool)> {
        let (plain, own) = (self.plain(), pcurve.fields("PCURVE", 1));
        let on = self.parametric(own.reference(0)?, depth + 1)?;
        let (carrier, same) = plain.carrier(self.in_parameters(pcurve, "PCURVE")?, depth + 1)?;
        if let (Surface::Plane { .. }, StatedAxes::Each(_)) = (&on.surface, &on.axes) {
            let [origin, x, y] = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(u, v)| on.point(u, v));
            let (x, y) = (x - origin, y - origin);
            let motion = DAffine3 { matrix3: DMat3::from_cols(x, y, x.cross(y) / x.length()), translation: origin };
            return Ok((Similarity::new(motion).carrier(carrier), same));
        }
        match carrier {
            Carrier::Line { point, along } => {
                if let Some((carrier, ahead)) = line_on(&on, point, along) {
                    return Ok((carrier, same == ahead));
                }
                let (low, high) = on.crossing([point.x, point.y], [along.x, along.y]);
                if !(low.is_finite() && high.is_finite() && low < high) {
                    return Err(Trouble::new(pcurve.id, CurveTrouble::Endless { keyword: "LINE".to_owned() }));
                }
                let at = |t: f64| point + along * t;
                let fitted = fitted(&[low, high], self.fit, |t| Ok(on.point(at(t).x, at(t).y)));
                Ok((Carrier::spline(fitted.map_err(|what| Trouble::new(pcurve.id, what))?), same))
            }
            _ => Ok((Carrier::spline(self.image(pcurve, depth)?), true)),
        }
    }

    /// A `PCURVE` with ends as a curve in space: exact on a plane, else approximated within the tolerance.
    fn image(&self, pcurve: Entity<'_>, depth: usize) -> Read<NurbsCurve3> {
        let (on, curve) = self.parameter_curve(pcurve, "PCURVE", depth)?;
        let at = |p: DVec3| on.point(p.x, p.y);
        if let Surface::Plane { .. } = on.surface {
            return Ok(NurbsCurve3 { points: curve.points.iter().map(|p| at(*p)).collect(), ..curve });
        }
        let fitted = fitted(&breaks(curve.degree, &curve.knots), self.fit, |t| Ok(at(curve.point(t))));
        fitted.map_err(|what| Trouble::new(pcurve.id, what))
    }

    /// A point other than a `CARTESIAN_POINT`; `None` for an instance that is not a point.
    pub(super) fn derived_point(&self, instance: Entity<'_>) -> Read<Option<DVec3>> {
        const KINDS: [&str; 5] =
            ["POINT_REPLICA", "POINT_ON_CURVE", "POINT_ON_SURFACE", "DEGENERATE_PCURVE", "EVALUATED_DEGENERATE_PCURVE"];
        if !instance.is_any(KINDS) {
            return Ok(None);
        }
        if self.nesting >= MAX_NESTING {
            return Err(Trouble::new(instance.id, StepTrouble::TooDeep { what: "points" }));
        }
        let inner = Geometry { nesting: self.nesting + 1, ..*self };
        let point = if instance.is("POINT_REPLICA") {
            let own = instance.fields("POINT_REPLICA", 1);
            inner.motion(own.reference(1)?)?.transform_point3(inner.point(own.reference(0)?)?)
        } else if instance.is("POINT_ON_CURVE") {
            inner.point_on_curve(instance)?
        } else if instance.is("POINT_ON_SURFACE") {
            let own = instance.fields("POINT_ON_SURFACE", 1);
            let on = inner.parametric(own.reference(0)?, 0)?;
            let (u, v) = (own.real(1)?, own.real(2)?);
            let (domain, period) = (on.surface.natural_domain(), on.surface.period());
            let at = on.natural(u, v);
            for k in (0..2).filter(|k| period[*k].is_none()) {
                within(at[k], domain[k], instance.id)?;
            }
            on.point(u, v)
        } else if instance.is("EVALUATED_DEGENERATE_PCURVE") {
            inner.point(instance.fields("EVALUATED_DEGENERATE_PCURVE", 3).reference(0)?)?
        } else {
            // The whole parameter curve is one point in space.
            let (on, curve) = inner.parameter_curve(instance, "DEGENERATE_PCURVE", 0)?;
            let at = curve.point(curve.domain().0);
            on.point(at.x, at.y)
        };
        if !point.is_finite() {
            return Err(Trouble::new(instance.id, StepTrouble::NotFinite { what: "a point" }));
        }
        Ok(Some(point))
    }

    fn point_on_curve(&self, instance: Entity<'_>) -> Read<DVec3> {
        let own = instance.fields("POINT_ON_CURVE", 1);
        let (basis, t) = (own.reference(0)?, own.real(1)?);
        if self.has_other_parameters(basis, 0) {
            return Err(Trouble::new(instance.id, CurveTrouble::OnComposite));
        }
        Ok(match self.carrier(basis, 0)?.0 {
            Carrier::Line { point, along } => point + along * t,
            Carrier::Round { frame, a, b } => {
                let (sin, cos) = libm::sincos(t * self.units.angle);
                frame.place(DVec3::new(a * cos, b * sin, 0.0))
            }
            Carrier::Hyperbola { frame, a, b } => frame.place(DVec3::new(a * libm::cosh(t), b * libm::sinh(t), 0.0)),
            Carrier::Parabola { frame, focal } => frame.place(DVec3::new(focal * t * t, 2.0 * focal * t, 0.0)),
            Carrier::Spline { curve, .. } => curve.point(within(t, curve.domain(), instance.id)?),
        })
    }

    /// The parent of a `CURVE_REPLICA`, and its motion.
    pub(super) fn curve_replica(&self, instance: Entity<'_>) -> Read<(u64, Similarity)> {
        let own = instance.fields("CURVE_REPLICA", 1);
        Ok((own.reference(0)?, Similarity::new(self.motion(own.reference(1)?)?)))
    }
}

/// The image of a line of a surface's parameters that is straight or along u or v, and whether it has the line's
/// direction.
fn line_on(on: &Parametric, point: DVec3, along: DVec3) -> Option<(Carrier, bool)> {
    let StatedAxes::Each(axes) = &on.axes else {
        let [point, next] = [point, point + along].map(|p| on.point(p.x, p.y));
        return Some((Carrier::Line { point, along: next - point }, true));
    };
    let axis = [along.y, along.x].into_iter().position(|across| across == 0.0)?;
    let ahead = (along[axis] > 0.0) == (axes[axis].factor > 0.0);
    Some((isoline(&on.surface, axis, on.within(point.x, point.y)), ahead))
}

/// Clamps a parameter that leaves the domain by at most a millionth of it (rounding); refuses others.
fn within(t: f64, (low, high): (f64, f64), id: u64) -> Read<f64> {
    let slack = 1e-6 * (high - low);
    if !(low - slack..=high + slack).contains(&t) {
        return Err(Trouble::new(id, CurveTrouble::Beyond { parameter: t, domain: (low, high) }));
    }
    Ok(t.clamp(low, high))
}
