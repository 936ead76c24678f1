//! Parameter curves that a file states for the edges of a face -> profile parameters of its boundary.
//!
//! Edges are placed by their curves in space. Only where sheets of a surface coincide does the shape not tell which one
//! the face is on.

use super::curve::WRAPPERS;
use super::loops::{Bound, EdgeKey, StatedFace};
use super::place::Geometry;

/// Steps between points per parameter curve; its ends are left out.
const STEPS: usize = 8;

impl Geometry<'_> {
    /// Profile parameters of points on a face's boundary, as the parameter curves of its edges on its surface of
    /// revolution state them. Empty if the file has none that can be read.
    pub(super) fn profile_parameters(&self, face: &StatedFace) -> Vec<f64> {
        let edges = face.bounds.iter().flat_map(|bound| match bound {
            Bound::Edges(uses) => uses.as_slice(),
            Bound::Vertex(_) => &[],
        });
        let curves = edges.filter_map(|edge| match edge.edge {
            EdgeKey::Curve(id) => Some(self.edge_curve(id).ok()?.0),
            EdgeKey::Side(..) | EdgeKey::Segment(_) => None,
        });
        let mut stated = Vec::new();
        for pcurve in curves.flat_map(|curve| self.pcurves(curve)).filter_map(|id| self.get(id).ok()) {
            let on = pcurve.is("PCURVE").then(|| pcurve.fields("PCURVE", 1).reference(0));
            if !matches!(on, Some(Ok(surface)) if surface == face.surface) {
                continue;
            }
            let Ok((on, curve)) = self.parameter_curve(pcurve, "PCURVE", 0) else { continue };
            let (a, b) = curve.domain();
            let points = (1..STEPS).map(|i| curve.point(a + (b - a) * i as f64 / STEPS as f64));
            stated.extend(points.map(|p| on.natural(p.x, p.y)[1]));
        }
        stated
    }

    /// The parameter curves that are stated with a curve in space.
    fn pcurves(&self, curve: u64) -> Vec<u64> {
        let Ok(curve) = self.get(curve) else { return Vec::new() };
        let Some(kind) = WRAPPERS.into_iter().find(|kind| curve.is(kind)) else { return Vec::new() };
        let declared = if curve.is("SURFACE_CURVE") { "SURFACE_CURVE" } else { kind };
        curve.fields(declared, 1).links(1).map_or_else(|_| Vec::new(), Iterator::collect)
    }
}
