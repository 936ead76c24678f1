//! Rectangular trimmed surfaces without topology -> NURBS surfaces cut at the four trim parameters.

use super::face_location::{FaceLocation, Stated};
use super::parameters::{Parametric, StatedAxes, StatedAxis};
use super::place::Geometry;
use super::table::{Entity, Read, Trouble};
use super::{revolution, spline};
use crate::model::{AxisMap, NurbsCurve3, Severity, StepOutcome, StepTrouble, Surface};

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
