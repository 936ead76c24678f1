//! Boundary curves of curve-bounded surfaces to edges. Their segments are often unbounded curves in space whose ends only
//! the parameter curve tells.

use super::curve::{Bounded, Ends};
use super::place::Geometry;
use super::table::{Instance, Read, Trouble};
use super::units::Units;
use crate::model::{CurveKind, NurbsCurve3, Surface};
use glam::DVec3;

impl Geometry<'_> {
    /// The curve of a `COMPOSITE_CURVE_SEGMENT` on the boundary of surface `bounded`, in the curve's own direction.
    pub(super) fn segment(&self, id: u64, bounded: u64) -> Read<(Ends, Bounded)> {
        let parent = self.get(id)?.fields("COMPOSITE_CURVE_SEGMENT", 0).reference(2)?;
        let instance = self.get(parent)?;
        if !instance.is("PCURVE")
            && let Ok(curve) = self.bounded(parent, 0)
        {
            let range = curve.domain();
            let (start, end) = (curve.point(range.0), curve.point(range.1));
            let closed = start.distance(end) <= self.units.tolerance;
            return Ok((Ends { start, end, closed }, Bounded { curve, range, kind: CurveKind::Spline }));
        }
        let base = self.get(bounded)?.fields("CURVE_BOUNDED_SURFACE", 1).reference(0)?;
        let pcurve = if instance.is("PCURVE") { Some(instance) } else { self.pcurve_on(instance, base)? };
        let pcurve = pcurve.ok_or_else(|| Trouble::new(id, "a boundary segment without ends"))?;
        let (start, end) = self.pcurve_ends(pcurve)?;
        let closed = start.distance(end) <= self.units.tolerance;
        let ends = Ends { start, end, closed };
        if instance.is("PCURVE") {
            return Err(Trouble::new(id, "a boundary segment that is given in parameters only"));
        }
        let between = self.between(parent, ends, true)?;
        let curve = between.ok_or_else(|| Trouble::new(id, "a boundary segment without length"))?;
        Ok((ends, curve))
    }

    /// The pcurve of a surface curve that lies on `surface`.
    fn pcurve_on(&self, curve: Instance<'_>, surface: u64) -> Read<Option<Instance<'_>>> {
        for id in curve.fields("SURFACE_CURVE", 1).links(1)? {
            let pcurve = self.get(id)?;
            if pcurve.is("PCURVE") && pcurve.fields("PCURVE", 1).optional(0) == Some(surface) {
                return Ok(Some(pcurve));
            }
        }
        Ok(None)
    }

    /// Where in space a pcurve starts and ends.
    fn pcurve_ends(&self, pcurve: Instance<'_>) -> Read<(DVec3, DVec3)> {
        let own = pcurve.fields("PCURVE", 1);
        let no_reach = Vec::new;
        let on = self.surface(own.reference(0)?, &no_reach, f64::INFINITY, 0)?.surface;
        let items = self.get(own.reference(1)?)?.fields("REPRESENTATION", 1).links(0)?;
        let curve = items.into_iter().next().ok_or_else(|| Trouble::new(pcurve.id, "an empty parameter curve"))?;
        // Parameters are read as numbers, then made lengths (millimetres) and angles (radians) one by one.
        let plain = Geometry { table: self.table, units: Units { length: 1.0, ..self.units } };
        let curve: NurbsCurve3 = plain.bounded(curve, 0)?;
        let (length, angle) = (self.units.length, self.units.angle);
        let [u, v] = match on {
            Surface::Plane { .. } => [length, length],
            Surface::Cylinder { .. } | Surface::Cone { .. } => [angle, length],
            Surface::Sphere { .. } | Surface::Torus { .. } => [angle, angle],
            Surface::Revolution { .. } => [angle, 1.0],
            Surface::Extrusion { .. } | Surface::Nurbs(_) => [1.0, 1.0],
        };
        let at = |t: f64| {
            let p = curve.point(t);
            on.point(p.x * u, p.y * v)
        };
        let (a, b) = curve.domain();
        Ok((at(a), at(b)))
    }
}
