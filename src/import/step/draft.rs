//! Edges before their vertices have ids: ends and the piece of the curve between them.

use super::curve::BoundedCurve;
use super::ends::{Ends, rounding};
use super::loops::{EdgeKey, VertexKey};
use super::table::{Read, Trouble};
use super::units::Units;
use super::values::Map;
use crate::control::Call;
use crate::math::boxes::around;
use crate::model::{EdgeId, StepCause, StepTrouble};
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

    /// Whether both vertices are in one place, and the curve within the file's tolerance of it and no larger than `near`.
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
