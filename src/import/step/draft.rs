//! Edges before their vertices have ids: ends, the piece of the curve between them, and the corners that ends share.
//!
//! Boundary curves of curve-bounded surfaces are edges, too. Their segments are often unbounded curves in space, whose
//! ends only the parameter curve states.

use super::curve::{BoundedCurve, WRAPPERS};
use super::loops::{EdgeKey, VertexKey};
use super::place::Geometry;
use super::table::{Entity, Read, Trouble, missing};
use super::units::{Ends, Units, Whole, rounding};
use super::values::Map;
use crate::control::Call;
use crate::math::boxes::around;
use crate::math::graph::DisjointSets;
use crate::model::{CurveKind, EdgeId, StepCause, StepTrouble};
use glam::DVec3;

/// A curve up to this share of the part's size may be a single point. Some files state a tolerance above the size of
/// their smallest circles.
const POINT: f64 = 1e-6;

/// An edge before its vertices have ids.
pub(super) struct EdgeDraft {
    pub(super) ends: [VertexKey; 2],
    pub(super) points: [DVec3; 2],
    /// The corners of both ends, or others merged with them; `None` until the first look-up.
    pub(super) corners: Option<[usize; 2]>,
    /// The edge of the part that the curve has moved to.
    pub(super) id: Option<EdgeId>,
    /// `None` for an edge without length, and after the curve has moved to the part.
    pub(super) curve: Option<BoundedCurve>,
    /// Ends of the curve; those of the vertices for an edge without length.
    pub(super) tips: [DVec3; 2],
    /// Whether the edge has no length.
    pub(super) empty: bool,
    /// Largest distance between an end of the curve and its vertex.
    pub(super) gap: f64,
    /// Largest distance by which a vertex of a closed edge was moved to the end of the curve.
    pub(super) moved: f64,
    /// Why the curve was not read, if that made the edge straight.
    pub(super) straightened: Option<StepCause>,
    pub(super) units: Units,
    pub(super) entity: u64,
}

/// The edges of a part, in the order in which its faces use them first.
#[derive(Default)]
pub(super) struct EdgeDrafts {
    /// Places in `drafts`, which may still be empty.
    pub(super) places: Map<EdgeKey, usize>,
    pub(super) drafts: Vec<Read<EdgeDraft>>,
}

impl EdgeDrafts {
    pub(super) fn get(&self, key: EdgeKey) -> Option<&Read<EdgeDraft>> {
        self.drafts.get(*self.places.get(&key)?)
    }

    pub(super) fn get_mut(&mut self, key: EdgeKey) -> Option<&mut Read<EdgeDraft>> {
        self.drafts.get_mut(*self.places.get(&key)?)
    }

    /// Diagonal of the box of all curves' control points.
    pub(super) fn size(&self, call: Call<'_>) -> f64 {
        let drafts = self.drafts.iter().take_while(|_| !call.is_cancelled());
        let curves = drafts.flatten().filter_map(|draft| draft.curve.as_ref());
        let [low, high] = around(curves.flat_map(|bounded| bounded.curve.points.iter().copied()));
        (high - low).max(DVec3::ZERO).length()
    }

    /// Empties edges whose curves are single points: some writers state an edge at a pole or an apex, where a side of
    /// the surface's domain has no length. Two faces that share one do not meet along it.
    pub(super) fn empty_points(&mut self, size: f64, call: Call<'_>) {
        for draft in self.drafts.iter_mut().take_while(|_| !call.is_cancelled()).flatten() {
            if draft.is_point(POINT * size) {
                draft.curve = None;
                draft.empty = true;
            }
        }
    }
}

impl EdgeDraft {
    pub(super) fn new(
        entity: u64,
        ends: [VertexKey; 2],
        at: Ends,
        curve: Option<BoundedCurve>,
        units: Units,
    ) -> Read<Self> {
        let points = [at.start, at.end];
        let (tips, gap) = curve.as_ref().map_or((points, 0.0), |BoundedCurve { curve, range, .. }| {
            let tips = [range.0, range.1].map(|t| curve.point(t));
            (tips, tips[0].distance(points[0]).max(tips[1].distance(points[1])))
        });
        if !gap.is_finite() {
            return Err(Trouble::new(entity, StepTrouble::NotFinite { what: "an end of the edge" }));
        }
        if let Some(Err(error)) = curve.as_ref().map(|bounded| bounded.curve.check()) {
            return Err(Trouble::new(entity, error));
        }
        Ok(Self {
            ends,
            points,
            corners: None,
            id: None,
            empty: curve.is_none(),
            curve,
            tips,
            gap,
            moved: 0.0,
            straightened: None,
            units,
            entity,
        })
    }

    /// Whether both vertices are in one place, and the curve within the file's tolerance of it and no larger than
    /// `near`.
    fn is_point(&self, near: f64) -> bool {
        let [start, end] = self.points;
        let tolerance = self.units.tolerance;
        let stays = |points: &[DVec3]| {
            let first = points.first().copied().unwrap_or(start);
            points.iter().all(|p| p.distance(first) <= near.min(tolerance) && p.distance(start) <= tolerance)
        };
        start.distance(end) <= rounding([start, end], 0.0)
            && self.curve.as_ref().is_some_and(|of| stays(&of.curve.points))
    }

    /// Points on the edge from start to end, four per control point; none for an edge without length.
    pub(super) fn samples(&self) -> impl Iterator<Item = DVec3> + '_ {
        const STEPS: usize = 4;
        self.curve.iter().flat_map(|BoundedCurve { curve, range: (a, b), .. }| {
            let steps = STEPS * curve.points.len();
            (0..=steps).map(move |i| curve.point(a + (b - a) * i as f64 / steps as f64))
        })
    }
}

/// Merges vertices that are one: those with the same number in the file, and coincident ones of neighbours in a loop.
#[derive(Default)]
pub(super) struct Corners {
    index: Map<VertexKey, usize>,
    merged: DisjointSets,
    pub(super) points: Vec<DVec3>,
}

impl Corners {
    pub(super) fn of(&mut self, key: VertexKey, point: DVec3) -> usize {
        let fresh = self.merged.len();
        let at = *self.index.entry(key).or_insert(fresh);
        if at == fresh {
            self.merged.push();
            self.points.push(point);
        }
        self.root(at)
    }

    /// The corner of a vertex that an edge ends at.
    pub(super) fn find(&mut self, key: VertexKey) -> Option<usize> {
        let at = *self.index.get(&key)?;
        Some(self.root(at))
    }

    pub(super) fn root(&mut self, at: usize) -> usize {
        self.merged.root(at as u32) as usize
    }

    /// Merges two corners; the one that comes first in the file stays.
    pub(super) fn unite(&mut self, a: usize, b: usize) {
        self.merged.join(a as u32, b as u32);
    }

    /// The two corners of a coedge, in loop order.
    pub(super) fn ends(&mut self, edge: &mut EdgeDraft, reversed: bool) -> (usize, usize) {
        let known = edge.corners.unwrap_or_else(|| [0, 1].map(|i| self.of(edge.ends[i], edge.points[i])));
        edge.corners = Some(known);
        let [a, b] = known.map(|at| self.root(at));
        if reversed { (b, a) } else { (a, b) }
    }
}

/// Which edges of a loop, given by their corners, must be reversed to run head to tail, given whether the first is.
/// `None` if the loop is open then.
pub(super) fn head_to_tail(ends: &[(usize, usize)], first: bool) -> Option<Vec<bool>> {
    let Some(&(tail, head)) = ends.first() else { return Some(Vec::new()) };
    let (start, mut at) = if first { (head, tail) } else { (tail, head) };
    let mut turned = Vec::with_capacity(ends.len());
    turned.push(first);
    for &(tail, head) in &ends[1..] {
        turned.push(tail != at);
        at = match at {
            _ if at == tail => head,
            _ if at == head => tail,
            _ => return None,
        };
    }
    (at == start).then_some(turned)
}

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
        if !curve.is_any(WRAPPERS) {
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
