//! Surfaces of ISO 10303-42 -> the model's surfaces in natural parameters.

use super::curve::Carrier;
use super::face_location::{FaceLocation, LocateFace, Stated, reaching};
use super::place::Geometry;
use super::replica::Similarity;
use super::revolution::{self, spindle};
use super::stated_spline::{Form, check_degree, check_weights, drop_net_breaks, knots_of};
use super::table::{Entity, Fields, Read, Trouble, check_depth, missing, out_of_range};
use super::values::Attribute;
use super::weld;
use crate::model::{CurveTrouble, Frame3, NurbsSurface, Severity, StepOutcome, StepTrouble, Surface};
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

const SPLINES: [&str; 6] = [
    "B_SPLINE_SURFACE",
    "B_SPLINE_SURFACE_WITH_KNOTS",
    "RATIONAL_B_SPLINE_SURFACE",
    "QUASI_UNIFORM_SURFACE",
    "UNIFORM_SURFACE",
    "BEZIER_SURFACE",
];

impl Geometry<'_> {
    /// Surface `id` of a face.
    pub(super) fn surface(&self, id: u64, reach: LocateFace<'_>, depth: usize) -> Read<Stated> {
        let instance = self.get(id)?;
        check_depth(depth, id, "surfaces")?;
        let frame = || self.frame(instance.fields("ELEMENTARY_SURFACE", 1).reference(0)?);
        let radius = |own: Fields<'_>, i: usize| -> Read<f64> {
            let r = self.length(own.real(i)?, id)?;
            if r > 0.0 { Ok(r) } else { Err(Trouble::new(id, out_of_range("a radius", r, "mm"))) }
        };
        if instance.is("PLANE") {
            Ok(Stated::exact(Surface::Plane { frame: frame()? }))
        } else if instance.is("CYLINDRICAL_SURFACE") {
            let radius = radius(instance.fields("CYLINDRICAL_SURFACE", 2), 0)?;
            Ok(Stated::exact(Surface::Cylinder { frame: frame()?, radius }))
        } else if instance.is("CONICAL_SURFACE") {
            self.cone(instance, frame()?)
        } else if instance.is("SPHERICAL_SURFACE") {
            let radius = radius(instance.fields("SPHERICAL_SURFACE", 2), 0)?;
            Ok(Stated::exact(Surface::Sphere { frame: frame()?, radius }))
        } else if instance.is("TOROIDAL_SURFACE") || instance.is("DEGENERATE_TOROIDAL_SURFACE") {
            let own = instance.fields("TOROIDAL_SURFACE", 2);
            let (major, minor) = (self.length(own.real(0)?, id)?, radius(own, 1)?);
            if major < 0.0 {
                return Err(Trouble::new(id, out_of_range("a torus major radius", major, "mm")));
            }
            let frame = frame()?;
            // A torus that only touches its axis has a single point there; rounded radii must not make it two.
            let major = if (minor - major).abs() <= 1e-9 * minor { minor } else { major };
            if instance.is("DEGENERATE_TOROIDAL_SURFACE") && minor > major {
                let outer = instance.fields("DEGENERATE_TOROIDAL_SURFACE", 4).flag(0, true);
                return Ok(Stated::exact(spindle(&frame, major, minor, outer)));
            }
            Ok(Stated::exact(Surface::Torus { frame, major, minor }))
        } else if instance.is("SURFACE_OF_LINEAR_EXTRUSION") {
            self.extrusion(instance, reach, depth)
        } else if instance.is("SURFACE_OF_REVOLUTION") {
            self.revolution(instance, reach, depth)
        } else if instance.is_any(SPLINES) {
            Ok(Stated::exact(Surface::Nurbs(self.b_spline_surface(instance)?)))
        } else if instance.is("OFFSET_SURFACE") {
            let own = instance.fields("OFFSET_SURFACE", 1);
            let distance = self.length(own.real(1)?, id)?;
            // The base of the face is that far from it.
            let base = self.surface(own.reference(0)?, &|| reach().grown(distance.abs()), depth + 1)?;
            let distance = if base.turned { -distance } else { distance };
            let (surface, note) = super::offset::offset(&base.surface, distance, self.fit, reach)
                .map_err(|what| Trouble::new(id, what))?;
            Ok(Stated { surface, turned: base.turned, note: note.or(base.note) })
        } else if instance.is("RECTANGULAR_TRIMMED_SURFACE") {
            let own = instance.fields("RECTANGULAR_TRIMMED_SURFACE", 1);
            let base = self.surface(own.reference(0)?, reach, depth + 1)?;
            let turned = base.turned != (own.flag(5, true) != own.flag(6, true));
            Ok(Stated { turned, ..base })
        } else if instance.is("SURFACE_REPLICA") {
            let own = instance.fields("SURFACE_REPLICA", 1);
            let motion = self.motion(own.reference(1)?)?;
            // `reach` locates the replica, not the original.
            let back = motion.inverse();
            let moved = |points: Vec<DVec3>| points.into_iter().map(|p| back.transform_point3(p)).collect();
            let reach_of_original = || {
                let FaceLocation { hull, on } = reach();
                FaceLocation { hull: moved(hull), on: moved(on) }
            };
            let base = self.surface(own.reference(0)?, &reach_of_original, depth + 1)?;
            let (surface, turned) = Similarity::new(motion).surface(base.surface);
            Ok(Stated { surface, turned: base.turned != turned, note: base.note })
        } else if instance.is("CURVE_BOUNDED_SURFACE") {
            let base = instance.fields("CURVE_BOUNDED_SURFACE", 1).reference(0)?;
            self.surface(base, reach, depth + 1)
        } else {
            Err(instance.not_read("surfaces"))
        }
    }

    fn cone(&self, instance: Entity<'_>, frame: Frame3) -> Read<Stated> {
        let own = instance.fields("CONICAL_SURFACE", 2);
        let radius = self.length(own.real(0)?, instance.id)?;
        let stated = own.real(1)?;
        let mut half_angle = stated * self.units.angle;
        let mut note = None;
        if half_angle.abs() >= FRAC_PI_2 && stated.abs() < 90.0 {
            half_angle = stated.to_radians();
            note = Some((Severity::Note, StepOutcome::Degrees { half_angle: stated }));
        }
        if radius < 0.0 || !(1e-12..FRAC_PI_2).contains(&half_angle.abs()) {
            if radius > 0.0 && half_angle.abs() < 1e-12 {
                return Ok(Stated::exact(Surface::Cylinder { frame, radius }));
            }
            return Err(Trouble::new(instance.id, StepTrouble::Cone { radius_mm: radius, half_angle: stated }));
        }
        Ok(Stated { surface: Surface::Cone { frame, radius, half_angle }, turned: false, note })
    }

    fn extrusion(&self, instance: Entity<'_>, reach: LocateFace<'_>, depth: usize) -> Read<Stated> {
        let own = instance.fields("SURFACE_OF_LINEAR_EXTRUSION", 1);
        let (swept, direction) = (own.reference(0)?, self.vector(own.reference(1)?)?);
        if direction == DVec3::ZERO {
            return Err(Trouble::new(instance.id, missing("an extrusion", "direction")));
        }
        let curve = match self.bounded(swept, depth + 1) {
            Ok(curve) => curve,
            Err(trouble) => match self.carrier(swept, depth + 1)? {
                // A swept line is a plane; the sweep's parameters give its normal.
                (Carrier::Line { point, along }, same) => {
                    let along = if same { along } else { -along };
                    let frame = Frame3::from_axis(point, along.cross(direction), along)
                        .ok_or_else(|| Trouble::new(instance.id, CurveTrouble::AlongItself))?;
                    return Ok(Stated::exact(Surface::Plane { frame }));
                }
                (carrier, same) => {
                    let flat = |p: &DVec3, frame: &Frame3| {
                        let slope = direction.dot(frame.z);
                        *p - direction * ((*p - frame.origin).dot(frame.z) / slope)
                    };
                    let curve = reaching(&carrier, &reach().hull, flat).ok_or(trouble)?;
                    if same { curve } else { curve.reversed() }
                }
            },
        };
        let curve = weld::curve(curve, self.units.tolerance);
        Ok(Stated::exact(Surface::Extrusion { curve, direction }))
    }

    fn revolution(&self, instance: Entity<'_>, reach: LocateFace<'_>, depth: usize) -> Read<Stated> {
        let own = instance.fields("SURFACE_OF_REVOLUTION", 1);
        let (swept, frame) = (own.reference(0)?, self.frame(own.reference(1)?)?);
        let curve = match self.bounded(swept, depth + 1) {
            Ok(curve) => curve,
            Err(trouble) => {
                let (carrier, same) = self.carrier(swept, depth + 1)?;
                let curve = match carrier {
                    Carrier::Line { point, along } => revolution::line(&frame, point, along, &reach()),
                    carrier => revolution::conic(&frame, &carrier, &reach()),
                };
                let curve = curve.ok_or(trouble)?;
                if same { curve } else { curve.reversed() }
            }
        };
        let curve = weld::curve(curve, self.units.tolerance);
        let (curve, frame) = revolution::onto_axis(curve, frame, self.units.tolerance);
        Ok(Stated::exact(Surface::Revolution { curve, frame }))
    }

    fn b_spline_surface(&self, instance: Entity<'_>) -> Read<NurbsSurface> {
        let id = instance.id;
        let shape = instance.fields("B_SPLINE_SURFACE", 1);
        let (degree_u, degree_v) = (shape.count(0)?, shape.count(1)?);
        let mut points = Vec::new();
        let mut count_v = 0;
        for row in shape.rows(2, "control points", "lists of rows")? {
            let row = self.points(row?.iter().filter_map(Attribute::link))?;
            if count_v != 0 && row.len() != count_v {
                let what = StepTrouble::Layout { what: "rows of control points", wanted: "of one length" };
                return Err(Trouble::new(id, what));
            }
            count_v = row.len();
            points.extend(row);
        }
        let count_u = shape.list(2)?.len();
        check_degree(degree_u, count_u, id)?;
        check_degree(degree_v, count_v, id)?;
        let form = Form::of(instance, "SURFACE");
        let (stated_u, stated_v) = if instance.is("B_SPLINE_SURFACE_WITH_KNOTS") {
            let own = instance.fields("B_SPLINE_SURFACE_WITH_KNOTS", 8);
            (Some((own.counts(0)?, own.reals(2)?)), Some((own.counts(1)?, own.reals(3)?)))
        } else {
            (None, None)
        };
        let knots_u = knots_of(stated_u, form, count_u, degree_u, id)?;
        let knots_v = knots_of(stated_v, form, count_v, degree_v, id)?;
        let weights = if instance.is("RATIONAL_B_SPLINE_SURFACE") {
            let mut weights = Vec::with_capacity(points.len());
            for row in instance.fields("RATIONAL_B_SPLINE_SURFACE", 8).rows(0, "weights", "lists of rows")? {
                weights.extend(row?.iter().filter_map(Attribute::number));
            }
            check_weights(weights, points.len(), id)?
        } else {
            Vec::new()
        };
        let mut net = NurbsSurface { degree_u, degree_v, knots_u, knots_v, points, weights };
        drop_net_breaks(&mut net, self.units.tolerance, id)?;
        // Writers that do not know whether a surface is closed state `.U.`.
        Ok(weld::net(net, [shape.flag(4, true), shape.flag(5, true)], self.units.tolerance))
    }
}
