//! The poles of a face's surface: which vertices they are, and which edges pass through them.

use super::Projector;
use crate::math::boxes::around;
use crate::math::solve::bisected;
use crate::model::{Edge, Pole};
use glam::DVec3;
use smallvec::SmallVec;

/// Distance from a pole, in tolerances, within which points are the pole.
pub(super) const NEAR: f64 = 10.0;

impl Projector<'_> {
    /// Reduces the reach of a pole that `edge` goes round, as the circle does in which a cone ends just below its apex,
    /// or that it leaves for another vertex within that reach. `is_seam`: whether the face uses the edge in both
    /// directions. Such an edge may end at the pole with the loop next to it.
    ///
    /// An edge counts if all of it is near the pole, and so exactly on the surface that it is not noise.
    pub(crate) fn keep_off_poles(&mut self, edge: &Edge, is_seam: impl Fn() -> bool) {
        /// Least distance from the pole, in tolerances. What is nearer may be rounding.
        const CLEAR: f64 = 1e-3;
        /// Largest distance from the surface, as a share of that from the pole.
        const SURE: f64 = 0.1;
        for k in 0..self.poles.len() {
            let pole = self.poles[k].point;
            // The control points of a circle are up to twice as far from its centre as the circle.
            if edge.curve.points.iter().any(|p| p.distance(pole) > 2.0 * NEAR * self.tolerance) {
                continue;
            }
            let points: Vec<DVec3> = self.first_parameters(edge).iter().map(|&t| edge.curve.point(t)).collect();
            let offs = points.iter().map(|p| p.distance(pole));
            let (least, most) = offs.fold((f64::INFINITY, 0.0_f64), |(low, high), off| (low.min(off), high.max(off)));
            let [a, b] = [edge.range.0, edge.range.1].map(|t| edge.curve.point(t).distance(pole));
            let leaves = a.min(b) <= SURE * a.max(b);
            let (off, from) = if leaves { (most, SURE * most) } else { (least, least) };
            let is_on = |p: &DVec3| self.foot(*p, None).off <= SURE * p.distance(pole);
            let counts = off > CLEAR * self.tolerance && !(leaves && (off > self.reaches[k] || is_seam()));
            if counts && points.iter().filter(|p| p.distance(pole) >= from).all(is_on) {
                self.reaches[k] = self.reaches[k].min(0.5 * off);
            }
        }
    }

    /// Moves each pole's point to the nearest B-rep vertex within its reach, so that all faces there share one point.
    ///
    /// A vertex farther off is the pole, too, if its distance from the surface explains that: in a file of few decimals,
    /// the apex of a cone and the vertex there are two points. That is so if a tenth of the way from the pole to the
    /// vertex leads off the surface; a fiftieth suffices `within` the file's tolerance, where points are one.
    pub(crate) fn adopt(&mut self, vertices: impl Iterator<Item = DVec3>, within: f64) {
        /// Largest distance of a vertex from the pole, in tolerances: a hundredth of the face.
        const WIDEST: f64 = 1e4;
        let widest = |reach: f64| if reach < NEAR * self.tolerance { reach } else { WIDEST * self.tolerance };
        let mut nearest: SmallVec<[_; 2]> = self.reaches.iter().map(|&reach| (widest(reach), None)).collect();
        for v in vertices {
            for ((pole, reach), (least, found)) in self.poles.iter().zip(&self.reaches).zip(&mut nearest) {
                let off = pole.point.distance(v);
                let is_off = || self.foot(v, None).off > if off <= within { 0.02 } else { 0.1 } * off;
                if off <= *least && (off <= *reach || is_off()) {
                    (*least, *found) = (off, Some(v));
                }
            }
        }
        for (pole, (_, found)) in self.poles.iter_mut().zip(nearest) {
            pole.point = found.unwrap_or(pole.point);
        }
    }

    /// The pole at `p`.
    pub(crate) fn pole_at(&self, p: DVec3) -> Option<usize> {
        self.poles.iter().zip(&self.reaches).position(|(pole, &reach)| pole.point.distance(p) <= reach)
    }

    /// The pole at `p`. `None` if there are two, as where a torus touches its axis.
    pub(crate) fn only_pole_at(&self, p: DVec3) -> Option<usize> {
        let first = self.pole_at(p)?;
        (first + 1..self.poles.len()).all(|k| self.poles[k].point.distance(p) > self.reaches[k]).then_some(first)
    }

    /// Interior parameters at which an edge passes through a pole, increasing. Its image jumps there.
    pub(crate) fn pole_passages(&self, edge: &Edge) -> Vec<f64> {
        if self.poles.is_empty() {
            return Vec::new();
        }
        let near = NEAR * self.tolerance;
        // A curve lies in the box of its points. Most poles are far from it; twice the distance leaves room for rounding.
        let [low, high] = around(edge.curve.points.iter().copied());
        let may_pass = |pole: &Pole| pole.point.distance(pole.point.max(low).min(high)) <= 2.0 * near;
        let poles: SmallVec<[(&Pole, f64); 2]> =
            self.poles.iter().zip(self.reaches.iter().copied()).filter(|(pole, _)| may_pass(pole)).collect();
        if poles.is_empty() {
            return Vec::new();
        }
        let ts = self.first_parameters(edge);
        let tangents: Vec<[DVec3; 2]> = ts.iter().map(|&t| edge.curve.tangent(t)).collect();
        let ends = [edge.curve.point(edge.range.0), edge.curve.point(edge.range.1)];
        let mut out = Vec::new();
        for (pole, reach) in poles {
            // Where the distance to the pole stops falling.
            let slope = |[point, d1]: [DVec3; 2]| (point - pole.point).dot(d1);
            for (w, along) in ts.windows(2).zip(tangents.windows(2)) {
                if slope(along[0]) >= 0.0 || slope(along[1]) < 0.0 {
                    continue;
                }
                let [_, t] = bisected([w[0], w[1]], 60, |t| slope(edge.curve.tangent(t)) < 0.0);
                // Not at the ends: loops handle poles at vertices.
                let p = edge.curve.point(t);
                let clear = ends.iter().all(|end| end.distance(p) > 10.0 * near);
                if clear && p.distance(pole.point) <= reach {
                    out.push(t);
                }
            }
        }
        out.sort_by(f64::total_cmp);
        out.dedup_by(|b, a| *b - *a <= 1e-6 * (edge.range.1 - edge.range.0));
        out
    }
}
