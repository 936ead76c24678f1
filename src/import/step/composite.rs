//! Composite curves: segments joined to one spline. Composites may share segments, and be segments themselves.

use super::place::Geometry;
use super::spline;
use super::table::{Entity, MAX_DEPTH, Read, Trouble, missing};
use super::values::Map;
use crate::model::{NurbsCurve3, StepTrouble};

impl Geometry<'_> {
    /// The segments of a `COMPOSITE_CURVE`, joined. Single points among them join nothing.
    pub(super) fn composite(&self, instance: Entity<'_>, depth: usize) -> Read<NurbsCurve3> {
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
