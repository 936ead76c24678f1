//! Boundary curves of curve-bounded surfaces -> edges. Their segments are often unbounded curves in space, whose ends
//! only the parameter curve states.

use super::curve::{BoundedCurve, WRAPPERS};
use super::ends::{Ends, Whole};
use super::place::Geometry;
use super::table::{Entity, Read, Trouble, missing};
use crate::model::CurveKind;
use glam::DVec3;

impl Geometry<'_> {
    /// The curve of a `COMPOSITE_CURVE_SEGMENT` on the boundary of surface `bounded`, in the curve's own direction.
    pub(super) fn segment(&self, id: u64, bounded: u64) -> Read<(Ends, BoundedCurve)> {
        let parent = self.get(id)?.fields("COMPOSITE_CURVE_SEGMENT", 0).reference(2)?;
        let instance = self.get(parent)?;
        let base = self.get(bounded)?.fields("CURVE_BOUNDED_SURFACE", 1).reference(0)?;
        let pcurve = self.pcurve_on(instance, base);
        let trouble = match self.bounded(parent, 0) {
            Ok(curve) => {
                // A circle is bounded by itself. Only the parameter curve shows if the segment is an arc of it.
                let whole = self.is_conic(parent);
                let ends = whole.then(|| self.pcurve_ends(pcurve.clone().ok()??).ok()).flatten();
                if let Some((start, end)) = ends.filter(|(start, end)| start.distance(*end) > self.units.tolerance) {
                    let ends = Ends { start, end, whole: Whole::Never };
                    if let Some(arc) = self.between_ends(parent, ends, true)? {
                        return Ok((ends, arc));
                    }
                }
                let range = curve.domain();
                let (start, end) = (curve.point(range.0), curve.point(range.1));
                let whole = self.whole_between(start, end);
                let kind = if curve.points.len() == 2 { CurveKind::Line } else { CurveKind::Spline };
                return Ok((Ends { start, end, whole }, BoundedCurve { curve, range, kind }));
            }
            Err(trouble) => trouble,
        };
        let pcurve = pcurve?.ok_or(trouble)?;
        let (start, end) = self.pcurve_ends(pcurve)?;
        let ends = Ends { start, end, whole: self.whole_between(start, end) };
        let between = self.between_ends(parent, ends, true)?;
        let curve = between.ok_or_else(|| Trouble::new(id, missing("a boundary segment", "length")))?;
        Ok((ends, curve))
    }

    /// A boundary segment has no vertices. It is closed if its ends meet within the tolerance.
    fn whole_between(&self, start: DVec3, end: DVec3) -> Whole {
        if start.distance(end) <= self.units.tolerance { Whole::OneVertex } else { Whole::Never }
    }

    /// The pcurve of a surface curve that lies on `surface`.
    fn pcurve_on(&self, curve: Entity<'_>, surface: u64) -> Read<Option<Entity<'_>>> {
        if !WRAPPERS.into_iter().any(|kind| curve.is(kind)) {
            return Ok(None);
        }
        for id in curve.fields("SURFACE_CURVE", 1).links(1)? {
            let pcurve = self.get(id)?;
            if pcurve.is("PCURVE") && pcurve.fields("PCURVE", 1).optional(0) == Some(surface) {
                return Ok(Some(pcurve));
            }
        }
        Ok(None)
    }

    /// First and last point of a pcurve in space.
    fn pcurve_ends(&self, pcurve: Entity<'_>) -> Read<(DVec3, DVec3)> {
        let (on, curve) = self.parameter_curve(pcurve, "PCURVE", 0)?;
        let at = |t: f64| {
            let p = curve.point(t);
            on.point(p.x, p.y)
        };
        let (a, b) = curve.domain();
        Ok((at(a), at(b)))
    }
}
