//! Parameters that a file states on swept curves and on surfaces -> those of the model's curves and surfaces;
//! rectangular trimmed surfaces -> NURBS surfaces cut at such parameters.
//!
//! A circle's parameter is an angle in the file's unit, that of a line a multiple of its vector, and that of a trimmed
//! curve starts with 0 at the first trim. Where the model's form has other parameters that are not mapped, the stated
//! ones are refused.

use super::curve::{Carrier, SPLINES};
use super::face_location::{FaceLocation, Stated};
use super::place::Geometry;
use super::table::{Entity, Read, Trouble, check_depth};
use super::{revolution, spline};
use crate::model::{AxisMap, CurveTrouble, NurbsCurve3, Severity, StepOutcome, StepTrouble, Surface};
use glam::{DAffine2, DMat2, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Maps an angle in a full turn from 0 to the parameter of its NURBS arc.
const TURN: AxisMap = AxisMap::Arc { start: 0.0, step: FRAC_PI_2, spans: 4 };

/// Maps a parameter as stated to that of a NURBS curve, or to one of a surface's natural ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StatedAxis {
    /// Where the stated parameter is 0.
    start: f64,
    /// Millimetres, radians or parameters per unit of the stated one.
    pub(super) factor: f64,
    /// From there to the parameter of an arc.
    arc: AxisMap,
}

impl StatedAxis {
    const SAME: Self = Self::scaled(1.0);

    const fn scaled(factor: f64) -> Self {
        Self { start: 0.0, factor, arc: AxisMap::Identity }
    }

    fn natural(&self, stated: f64) -> f64 {
        let t = self.start + self.factor * stated;
        let AxisMap::Arc { start, step, spans } = self.arc else { return t };
        // Only a whole turn goes on beyond its ends.
        let sweep = step * f64::from(spans);
        let turns = if (sweep - TAU).abs() <= 1e-9 { ((t - start) / sweep).floor() } else { 0.0 };
        turns * sweep + self.arc.to_nurbs(t - turns * sweep)
    }

    /// The stated parameters at the ends of a domain, the smaller one first.
    fn ends(&self, domain: (f64, f64)) -> (f64, f64) {
        let (from, to) = match self.arc {
            AxisMap::Arc { start, step, spans } => (start, start + step * f64::from(spans)),
            AxisMap::Identity => domain,
        };
        let [from, to] = [from, to].map(|t| (t - self.start) / self.factor);
        (from.min(to), from.max(to))
    }

    /// The map of a trimmed curve or surface, whose parameter is 0 at `from` and grows as the trims say.
    fn trimmed(self, from: f64, along: bool) -> Self {
        let factor = if along { self.factor } else { -self.factor };
        Self { start: self.start + self.factor * from, factor, ..self }
    }
}

/// Maps both parameters of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) enum StatedAxes {
    Each([StatedAxis; 2]),
    /// A line that is swept along another direction and became a plane: the stated parameters are coordinates along
    /// both, with their lengths as units.
    Oblique(DAffine2),
}

/// A surface with the parameters that the file states on it.
pub(super) struct Parametric {
    pub(super) surface: Surface,
    pub(super) axes: StatedAxes,
    /// The difference from the file to report, with its severity.
    pub(super) note: Option<(Severity, StepOutcome)>,
}

impl Parametric {
    /// The natural parameters.
    pub(super) fn natural(&self, u: f64, v: f64) -> [f64; 2] {
        match &self.axes {
            StatedAxes::Each([along_u, along_v]) => [along_u.natural(u), along_v.natural(v)],
            StatedAxes::Oblique(map) => map.transform_point2(DVec2::new(u, v)).into(),
        }
    }

    /// The natural parameters within the domain. Closed directions repeat beyond their ends.
    pub(super) fn within(&self, u: f64, v: f64) -> [f64; 2] {
        let (domain, period) = (self.surface.natural_domain(), self.surface.period());
        let mut at = self.natural(u, v);
        for k in 0..2 {
            let (low, high) = domain[k];
            if let Some(period) = period[k].filter(|_| !(low..=high).contains(&at[k])) {
                at[k] = low + (at[k] - low).rem_euclid(period);
            }
        }
        at
    }

    /// The range of `t` in which the stated parameters `at` + `t` `along` are within the domain. Closed directions have
    /// no ends.
    pub(super) fn crossing(&self, at: [f64; 2], along: [f64; 2]) -> (f64, f64) {
        let StatedAxes::Each(axes) = &self.axes else { return ENDLESS };
        let (domain, period) = (self.surface.natural_domain(), self.surface.period());
        let open = (0..2).filter(|k| period[*k].is_none() && along[*k] != 0.0);
        open.fold(ENDLESS, |(low, high), k| {
            let (from, to) = axes[k].ends(domain[k]);
            let [from, to] = [from, to].map(|end| (end - at[k]) / along[k]);
            (low.max(from.min(to)), high.min(from.max(to)))
        })
    }

    /// The point at stated parameters. Closed directions repeat beyond their ends.
    pub(super) fn point(&self, u: f64, v: f64) -> DVec3 {
        let [u, v] = self.within(u, v);
        self.surface.point(u, v)
    }
}

const ENDLESS: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// What some types have none of.
const PARAMETERS: &str = "parameters on curves and surfaces";

impl Geometry<'_> {
    /// A surface, with the map from the file's parameters to its natural ones. Flipped surfaces and replicas are
    /// refused.
    pub(super) fn parametric(&self, id: u64, depth: usize) -> Read<Parametric> {
        let on = self.surface(id, &FaceLocation::default, depth)?;
        if on.turned {
            return Err(Trouble::new(id, StepTrouble::ReplicaParameters));
        }
        let axes = self.stated_axes(id, &on.surface, depth)?;
        Ok(Parametric { surface: on.surface, axes, note: on.note })
    }

    /// The parameters of instance `id`, which was read as `surface`.
    fn stated_axes(&self, id: u64, surface: &Surface, depth: usize) -> Read<StatedAxes> {
        use StatedAxes::{Each, Oblique};
        let instance = self.get(id)?;
        let (length, angle) = (StatedAxis::scaled(self.units.length), StatedAxis::scaled(self.units.angle));
        let inner = |name: &'static str| self.stated_axes(instance.fields(name, 1).reference(0)?, surface, depth + 1);
        let own = |name: &'static str| instance.fields(name, 1);
        check_depth(depth, id, "surfaces")?;
        if instance.is("SURFACE_REPLICA") {
            Err(Trouble::new(id, StepTrouble::ReplicaParameters))
        } else if let Some(name) = instance.first_of(["OFFSET_SURFACE", "CURVE_BOUNDED_SURFACE"]) {
            inner(name)
        } else if instance.is("RECTANGULAR_TRIMMED_SURFACE") {
            let trims = own("RECTANGULAR_TRIMMED_SURFACE");
            let ([u, v], along) = ([trims.real(1)?, trims.real(3)?], [5, 6].map(|i| trims.flag(i, true)));
            Ok(match inner("RECTANGULAR_TRIMMED_SURFACE")? {
                Each([of_u, of_v]) => Each([of_u.trimmed(u, along[0]), of_v.trimmed(v, along[1])]),
                Oblique(map) => {
                    let steps = along.map(|along| if along { 1.0 } else { -1.0 });
                    Oblique(map * DAffine2::from_scale_angle_translation(steps.into(), 0.0, DVec2::new(u, v)))
                }
            })
        } else if instance.is("SURFACE_OF_LINEAR_EXTRUSION") {
            let (swept, direction) = (own("SURFACE_OF_LINEAR_EXTRUSION"), StatedAxis::SAME);
            match surface {
                Surface::Plane { frame } => {
                    let along = self.vector(swept.reference(1)?)?;
                    let (Carrier::Line { along: line, .. }, same) = self.carrier(swept.reference(0)?, depth + 1)?
                    else {
                        return Err(instance.not_read(PARAMETERS));
                    };
                    let line = if same { line } else { -line };
                    let flat = |v: DVec3| DVec2::new(v.dot(frame.x), v.dot(frame.y));
                    Ok(Oblique(DAffine2::from_mat2(DMat2::from_cols(flat(line), flat(along)))))
                }
                _ => Ok(Each([self.stated_axis(swept.reference(0)?, depth + 1)?, direction])),
            }
        } else if instance.is("SURFACE_OF_REVOLUTION") {
            let swept = own("SURFACE_OF_REVOLUTION").reference(0)?;
            Ok(Each([angle, self.stated_axis(swept, depth + 1)?]))
        } else {
            match surface {
                Surface::Plane { .. } => Ok(Each([length, length])),
                Surface::Cylinder { .. } | Surface::Cone { .. } => Ok(Each([angle, length])),
                Surface::Sphere { .. } | Surface::Torus { .. } => Ok(Each([angle, angle])),
                // A torus that meets its own axis; the angle is that of the torus.
                Surface::Revolution { curve, .. } => {
                    let (start, end) = curve.domain();
                    let spans = (curve.points.len() - 1) / 2;
                    Ok(Each([angle, StatedAxis { arc: arc((start, end), spans), ..angle }]))
                }
                Surface::Extrusion { .. } => Err(instance.not_read(PARAMETERS)),
                Surface::Nurbs(_) => Ok(Each([StatedAxis::SAME; 2])),
            }
        }
    }

    /// Maps the parameter of a curve with ends to that of [`bounded`](Self::bounded).
    fn stated_axis(&self, id: u64, depth: usize) -> Read<StatedAxis> {
        let instance = self.unwrap(id, depth)?;
        check_depth(depth, id, "curves")?;
        if self.has_other_parameters(id, depth) {
            Err(Trouble::new(id, CurveTrouble::OnComposite))
        } else if instance.is("CIRCLE") || instance.is("ELLIPSE") {
            Ok(StatedAxis { start: 0.0, factor: self.units.angle, arc: TURN })
        } else if let Some(name) = instance.first_of(["CURVE_REPLICA", "OFFSET_CURVE_3D"]) {
            self.stated_axis(instance.fields(name, 1).reference(0)?, depth + 1)
        } else if instance.is("TRIMMED_CURVE") {
            self.trimmed_axis(instance, depth)
        } else if instance.is("POLYLINE") || instance.is_any(SPLINES) {
            Ok(StatedAxis::SAME)
        } else {
            Err(instance.not_read(PARAMETERS))
        }
    }

    /// Maps the parameter of a `TRIMMED_CURVE`, which is 0 at the first trim and grows up to the second. The NURBS form
    /// starts there, too.
    fn trimmed_axis(&self, instance: Entity<'_>, depth: usize) -> Read<StatedAxis> {
        let basis = instance.fields("TRIMMED_CURVE", 1).reference(0)?;
        let curve = self.bounded(instance.id, depth)?;
        let (start, end) = curve.domain();
        let axis = StatedAxis { start, ..StatedAxis::SAME };
        match self.carrier(basis, depth + 1)?.0 {
            Carrier::Line { along, .. } => {
                let length = curve.point(end).distance(curve.point(start));
                Ok(StatedAxis { factor: (end - start) * along.length() / length, ..axis })
            }
            Carrier::Round { .. } => {
                let spans = (curve.points.len() - 1) / 2;
                Ok(StatedAxis { factor: self.units.angle, arc: arc((start, end), spans), ..axis })
            }
            Carrier::Parabola { .. } => Ok(axis),
            Carrier::Spline { .. } if self.stated_axis(basis, depth + 1)? == StatedAxis::SAME => Ok(axis),
            // A hyperbola's NURBS form has other parameters inside its spans.
            Carrier::Hyperbola { .. } | Carrier::Spline { .. } => Err(instance.not_read(PARAMETERS)),
        }
    }
}

/// Maps the angles of an arc with equal spans.
fn arc((start, end): (f64, f64), spans: usize) -> AxisMap {
    let spans = u32::try_from(spans).unwrap_or(1).max(1);
    AxisMap::Arc { start, step: (end - start) / f64::from(spans), spans }
}

impl Geometry<'_> {
    /// A surface that is a face by itself.
    pub(super) fn whole_surface(&self, id: u64) -> Read<Stated> {
        let instance = self.get(id)?;
        if instance.is("RECTANGULAR_TRIMMED_SURFACE") {
            return self.rectangle(instance);
        }
        self.surface(id, &FaceLocation::default, 0)
    }

    fn rectangle(&self, instance: Entity<'_>) -> Read<Stated> {
        let own = instance.fields("RECTANGULAR_TRIMMED_SURFACE", 1);
        let refused = |range, beyond| Trouble::new(instance.id, StepTrouble::SurfaceTrim { range, beyond });
        let (surface, axes, mut note) = match self.turned_between(own.reference(0)?, (own.real(3)?, own.real(4)?))? {
            Some((surface, axes)) => (surface, axes, None),
            None => {
                let on = self.parametric(own.reference(0)?, 1)?;
                let note = on.note.clone();
                let (surface, axes) = match on.axes {
                    StatedAxes::Each(axes) => (on.surface, axes),
                    StatedAxes::Oblique(_) => {
                        let range = (own.real(1)?, own.real(2)?);
                        swept_line(&on, range).ok_or_else(|| refused(range, false))?
                    }
                };
                (surface, axes, note)
            }
        };
        let whole = surface.natural_domain();
        let mut range = [(0.0, 0.0); 2];
        for axis in 0..2 {
            let at = |i: usize| -> Read<f64> { Ok(axes[axis].natural(own.real(i)?)) };
            let (first, second) = (at(1 + 2 * axis)?, at(2 + 2 * axis)?);
            let along = own.flag(5 + axis, true) == (axes[axis].factor > 0.0);
            let (from, mut to) = if along { (first, second) } else { (second, first) };
            if to <= from {
                // The trim crosses the seam of a closed surface.
                to += surface.period()[axis].unwrap_or(0.0);
            }
            if to <= from {
                return Err(refused((first, second), false));
            }
            // More than one period would cover the surface twice.
            let most = match surface.period()[axis] {
                Some(period) => (from, to.min(from + period)),
                None => (from.max(whole[axis].0), to.min(whole[axis].1)),
            };
            let slack = 1e-6 * (to - from);
            if most.0 >= most.1 {
                return Err(refused((first, second), true));
            }
            if most.0 > from + slack || most.1 < to - slack {
                note = Some((Severity::Warning, StepOutcome::TrimBeyond { range: (first, second) }));
            }
            range[axis] = most;
        }
        let (net, maps) = surface.to_nurbs(range[0], range[1]);
        let cut = [0, 1].map(|axis| (maps[axis].to_nurbs(range[axis].0), maps[axis].to_nurbs(range[axis].1)));
        let net = spline::patch(&net, cut[0], cut[1]);
        let turned = own.flag(5, true) != own.flag(6, true);
        Ok(Stated { surface: Surface::Nurbs(net), turned, note })
    }

    /// The surface of revolution of a curve without ends, of its part between two parameters. `None` if the curve has
    /// ends, if the parameters are equal, and for other surfaces.
    fn turned_between(&self, id: u64, (first, second): (f64, f64)) -> Read<Option<Patch>> {
        let instance = self.get(id)?;
        if !instance.is("SURFACE_OF_REVOLUTION") || first == second {
            return Ok(None);
        }
        let own = instance.fields("SURFACE_OF_REVOLUTION", 1);
        let (swept, frame) = (own.reference(0)?, self.frame(own.reference(1)?)?);
        if self.bounded(swept, 1).is_ok() {
            return Ok(None);
        }
        let (low, high) = (first.min(second), first.max(second));
        let (carrier, same) = self.carrier(swept, 1)?;
        let curve = carrier.arc((low, high));
        let (curve, frame) = revolution::onto_axis(curve, frame, self.units.tolerance);
        let (start, end) = curve.domain();
        let factor = (end - start) / (high - low);
        let along = StatedAxis { start: start - low * factor, factor, arc: AxisMap::Identity };
        let around = StatedAxis::scaled(self.units.angle);
        Ok(same.then_some((Surface::Revolution { curve, frame }, [around, along])))
    }
}

/// A surface with its stated parameters.
type Patch = (Surface, [StatedAxis; 2]);

/// The plane of a line that is swept along another direction, as the sweep of the line's piece between two parameters.
/// `None` if these are equal.
fn swept_line(on: &Parametric, (first, second): (f64, f64)) -> Option<Patch> {
    let (low, high) = (first.min(second), first.max(second));
    let length = high - low;
    let axis = StatedAxis { start: -low / length, factor: 1.0 / length, arc: AxisMap::Identity };
    let direction = on.point(low, 1.0) - on.point(low, 0.0);
    let curve = NurbsCurve3::line(on.point(low, 0.0), on.point(high, 0.0));
    (length > 0.0)
        .then_some((Surface::Extrusion { curve, direction }, [axis, StatedAxis { start: 0.0, factor: 1.0, ..axis }]))
}
