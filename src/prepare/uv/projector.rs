//! One surface -> the feet of points on it, and its poles: which vertices they are, and which edges pass through them.

use super::foot::{Foot, Seeds, newton_step};
use super::lead::first_parameters;
use crate::math::boxes::around;
use crate::math::solve::{bisected, least_squares};
use crate::model::{CurveKind, Edge, Pole, Surface, SurfaceDerivatives};
use glam::{DVec2, DVec3};
use smallvec::{SmallVec, smallvec};
use std::cell::{Cell, OnceCell};

/// Steps of one projection, halved ones included. Quadratic convergence takes 3–5 from a good seed, slow tangential
/// convergence about 30.
const MAX_STEPS: u32 = 80;

/// Steps by first derivatives before second ones are used. Points on the surface are found by then.
const FIRST_STEPS: u32 = 4;

/// Consecutive searches of the whole surface that may fail to improve a projection. After that the march of this edge
/// goes on without searches: the edge lies off the surface. Marches of the face's other edges skip searches too, at
/// distances up to twice the mean of these failures: edges that lie off it do so by all distances from none to theirs.
const MAX_VAIN: u32 = 8;

/// No search has failed yet.
const NO_SEARCH: (u32, f64) = (0, 0.0);

/// Distance between an edge and the surface, in tolerances, beyond which the image is refined only to a share of that
/// distance. The edges of sound files lie nearer.
pub(super) const FAR_OFF: f64 = 3e3;

/// Length of the last step of a projection from beyond [`FAR_OFF`], as a share of the distance.
const FAR_ENOUGH: f64 = 0.005;

/// Distance from a pole, in tolerances, within which points are the pole.
const NEAR: f64 = 10.0;

/// Projects points onto one surface.
pub(crate) struct Projector<'a> {
    pub(super) surface: &'a Surface,
    /// Periods in u and v.
    pub(crate) period: [Option<f64>; 2],
    /// Natural domain; infinite where the surface is.
    pub(crate) domain: [(f64, f64); 2],
    /// Whether tangents are continuous, and do not vanish on a line.
    smooth: bool,
    /// Whether tangents may jump at a line.
    pub(super) may_jump: bool,
    /// Whether its speed may be odd about the middle of a piece: a spline of several spans or of degree 3, or swept
    /// from one.
    pub(super) is_uneven: bool,
    /// Distance from the surface, in tolerances, beyond which a projection is tried from elsewhere. It may stop at a
    /// crease between straight spans, next to the tooth where the point is.
    enough: f64,
    /// Parameter lines that collapse to a point. The points are those of B-rep vertices there, once adopted.
    pub(crate) poles: Vec<Pole>,
    /// The surface's own point at each pole.
    pub(super) tips: SmallVec<[DVec3; 2]>,
    /// Distance from each pole within which points are the pole: ten tolerances, or less where edges go round it.
    reaches: SmallVec<[f64; 2]>,
    /// Points of this face closer than this are one.
    pub(crate) tolerance: f64,
    seeds: OnceCell<Seeds>,
    /// Projections off the surface since the edge began, or since a search improved one.
    pub(super) vain: Cell<u32>,
    /// Searches without improvement since one improved, for all edges of the face, and the sum of their distances from
    /// the surface. Where one edge lies off the surface, others usually do.
    pub(super) vain_of_face: Cell<(u32, f64)>,
}

impl<'a> Projector<'a> {
    pub(crate) fn new(surface: &'a Surface, tolerance: f64) -> Self {
        let (period, poles) = (surface.period(), surface.poles());
        let may_jump = !surface.is_smooth(period);
        let is_faceted = |axis| surface.knots(axis).is_some_and(|(degree, knots)| degree == 1 && knots.len() > 4);
        let is_uneven = |axis| surface.knots(axis).is_some_and(|(degree, knots)| degree > 2 || knots.len() > 6);
        Self {
            surface,
            period,
            domain: surface.natural_domain(),
            smooth: poles.is_empty() && !may_jump,
            may_jump,
            is_uneven: is_uneven(0) || is_uneven(1),
            enough: if is_faceted(0) || is_faceted(1) { 10.0 } else { 1e3 },
            reaches: smallvec![NEAR * tolerance; poles.len()],
            tips: poles.iter().map(|pole| pole.point).collect(),
            poles,
            tolerance,
            seeds: OnceCell::new(),
            vain: Cell::new(0),
            vain_of_face: Cell::new(NO_SEARCH),
        }
    }

    /// Length in space of a small step in (u,v), to first order.
    pub(crate) fn length(&self, at: DVec2, step: DVec2) -> f64 {
        self.lengths(at)(step)
    }

    /// Lengths in space of small steps from one place.
    pub(crate) fn lengths(&self, at: DVec2) -> impl Fn(DVec2) -> f64 {
        let [_, du, dv] = self.tangents(at);
        move |step| (du * step.x + dv * step.y).length()
    }

    /// Area in space per area in (u,v).
    pub(crate) fn area(&self, at: DVec2) -> f64 {
        let [_, du, dv] = self.tangents(at);
        du.cross(dv).length()
    }

    /// The surface's point. Periodic parameters may lie outside the domain.
    pub(crate) fn point(&self, at: DVec2) -> DVec3 {
        let w = self.wrap(at);
        self.surface.point(w.x, w.y)
    }

    /// The surface's point and its derivative along `step`. Periodic parameters may lie outside the domain.
    pub(crate) fn along(&self, at: DVec2, step: DVec2) -> (DVec3, DVec3) {
        let [point, du, dv] = self.tangents(at);
        (point, du * step.x + dv * step.y)
    }

    /// The surface's point and its derivatives by u and v. Periodic parameters may lie outside the domain.
    pub(super) fn tangents(&self, at: DVec2) -> [DVec3; 3] {
        let w = self.wrap(at);
        self.surface.tangents(w.x, w.y)
    }

    fn derivatives(&self, at: DVec2) -> SurfaceDerivatives {
        let w = self.wrap(at);
        self.surface.derivatives(w.x, w.y)
    }

    /// Moves `uv` by whole periods as close to `near` as possible.
    pub(crate) fn unwrap(&self, mut uv: DVec2, near: DVec2) -> DVec2 {
        for axis in 0..2 {
            if let Some(p) = self.period[axis] {
                uv[axis] += p * ((near[axis] - uv[axis]) / p).round();
            }
        }
        uv
    }

    /// So many periods in u and in v; nothing in a direction without one.
    pub(crate) fn turns(&self, counts: [f64; 2]) -> DVec2 {
        DVec2::from_array(counts) * DVec2::from_array(self.period.map(|period| period.unwrap_or(0.0)))
    }

    /// Parameters of the surface point nearest to `p`; on the sheet of `seed`, if given.
    pub(crate) fn project(&self, p: DVec3, seed: Option<DVec2>) -> DVec2 {
        self.foot(p, seed).uv
    }

    pub(super) fn foot(&self, p: DVec3, seed: Option<DVec2>) -> Foot {
        if let Some(uv) = self.surface.invert(p) {
            return self.foot_at(seed.map_or(uv, |s| self.unwrap(uv, s)), p);
        }
        let Some(s) = seed else { return self.search(p) };
        let near = self.newton(p, s);
        if near.off <= self.near() || self.vain.get() >= MAX_VAIN {
            return near;
        }
        let (count, sum) = self.vain_of_face.get();
        let others_failed = count >= MAX_VAIN && near.off <= 2.0 * sum / f64::from(count);
        if !others_failed {
            let far = self.search(p);
            if far.off < 0.5 * near.off {
                self.vain.set(0);
                self.vain_of_face.set(NO_SEARCH);
                return Foot { uv: self.unwrap(far.uv, s), ..far };
            }
            self.vain_of_face.set((count + 1, sum + near.off));
        }
        self.vain.set(self.vain.get() + 1);
        near
    }

    /// Distance from the surface within which a point is on it.
    fn near(&self) -> f64 {
        self.enough * self.tolerance
    }

    fn foot_at(&self, uv: DVec2, p: DVec3) -> Foot {
        Foot::new(uv, p, self.tangents(uv))
    }

    /// Moves parameters into the domain: by whole periods, or clamped where the surface is not periodic.
    fn wrap(&self, uv: DVec2) -> DVec2 {
        let mut uv = self.clamp(uv);
        if self.period == [None, None] {
            return uv;
        }
        for axis in 0..2 {
            let (lo, hi) = self.domain[axis];
            if let Some(p) = self.period[axis]
                && lo.is_finite()
                && (uv[axis] < lo || uv[axis] > hi)
            {
                uv[axis] = lo + (uv[axis] - lo).rem_euclid(p);
            }
        }
        uv
    }

    /// Clamps parameters to the domain where the surface is not periodic.
    #[inline]
    fn clamp(&self, mut uv: DVec2) -> DVec2 {
        for axis in 0..2 {
            if self.period[axis].is_none() {
                uv[axis] = uv[axis].clamp(self.domain[axis].0, self.domain[axis].1);
            }
        }
        uv
    }

    /// The foot point of `p`: by first derivatives (Gauss–Newton), and where these converge slowly, because `p` is off
    /// the surface, by second ones too (Newton). The first steps may swing. Later ones start at the nearest point so
    /// far and are halved until the distance falls.
    fn newton(&self, p: DVec3, start: DVec2) -> Foot {
        let mut uv = self.clamp(start);
        let mut best = Foot::none(uv);
        for step in 0..MAX_STEPS {
            let mut second = (step >= FIRST_STEPS).then(|| self.derivatives(uv));
            let mut here = second.map_or_else(|| self.foot_at(uv, p), |s| Foot::new(uv, p, [s.point, s.du, s.dv]));
            let off = best.off.min(here.off);
            let is_far = off > FAR_OFF * self.tolerance && self.vain.get() >= MAX_VAIN;
            let enough = if is_far { FAR_ENOUGH * off } else { 1e-4 * self.tolerance };
            let length = |step: DVec2, [_, du, dv]: [DVec3; 3]| du.length() * step.x.abs() + dv.length() * step.y.abs();
            if here.off < best.off {
                best = here;
            } else if step == FIRST_STEPS {
                (uv, here, second) = (best.uv, best, Some(self.derivatives(best.uv)));
            } else if step > FIRST_STEPS {
                if length(uv - best.uv, best.tangents) <= enough {
                    return best;
                }
                uv = 0.5 * (uv + best.uv);
                continue;
            }
            let next = self.next_step(&here, p, second.as_ref());
            if length(next - uv, here.tangents) <= enough {
                // The step is too short for point and tangents to differ, unless the surface has a crease or a pole.
                let next = if self.smooth && !is_far { Foot { uv: next, ..here } } else { self.foot_at(next, p) };
                return if next.off <= best.off { next } else { best };
            }
            uv = next;
        }
        best
    }

    /// Where a step from `here` leads, within the domain: by second derivatives if they are given and the distance is
    /// convex, else by first ones.
    fn next_step(&self, here: &Foot, p: DVec3, second: Option<&SurfaceDerivatives>) -> DVec2 {
        let Foot { uv, tangents: [point, du, dv], .. } = *here;
        let r = p - point;
        let bent = second.and_then(|second| newton_step(second, r));
        let mut next = uv + bent.unwrap_or_else(|| least_squares(du, dv, r));
        for axis in 0..2 {
            let (lo, hi) = self.domain[axis];
            if self.period[axis].is_none() && (next[axis] < lo || next[axis] > hi) {
                next[axis] = next[axis].clamp(lo, hi);
                // Solve the other coordinate along the border.
                let other = 1 - axis;
                let (along, fixed) = if other == 0 { (du, dv) } else { (dv, du) };
                let rest = r - fixed * (next[axis] - uv[axis]);
                let g = along.length_squared();
                let bend =
                    second.filter(|_| bent.is_some()).map_or(0.0, |s| rest.dot(if other == 0 { s.duu } else { s.dvv }));
                if g > 0.0 {
                    next[other] = uv[other] + rest.dot(along) / if g - bend > 1e-3 * g { g - bend } else { g };
                }
            }
        }
        // After the borders: where one is a pole, the step along it is as long as rounding makes it.
        for axis in 0..2 {
            if let Some(period) = self.period[axis] {
                let limit = 0.25 * period;
                next[axis] = uv[axis] + (next[axis] - uv[axis]).clamp(-limit, limit);
            }
        }
        self.clamp(next)
    }

    fn seeds(&self) -> &Seeds {
        self.seeds.get_or_init(|| Seeds::of(self.surface, self.domain, self.period))
    }

    /// The foot of `p` nearest to it, or the first one found on the surface.
    fn search(&self, p: DVec3) -> Foot {
        if let (Surface::Nurbs(net), [None, None], []) = (self.surface, self.period, &self.poles[..]) {
            // Most vertices are corners of the net, or not far from a control point. A lattice of seeds takes thousands
            // of points.
            let found = self.newton(p, net.nearest_control(p));
            if found.off <= self.tolerance {
                return found;
            }
        }
        let mut answer = Foot::none(DVec2::ZERO);
        for start in self.seeds().starts(p) {
            let found = self.newton(p, start);
            if found.off < answer.off {
                answer = found;
            }
            if answer.off <= self.tolerance {
                break;
            }
        }
        answer
    }

    /// Parameters of the surface points at `p`, one on each sheet that passes there.
    pub(crate) fn sheets_at(&self, p: DVec3) -> SmallVec<[DVec2; 2]> {
        let mut sheets: SmallVec<[Foot; 2]> = SmallVec::new();
        for start in self.seeds().starts(p) {
            let found = self.newton(p, start);
            let is_same = |foot: &Foot| self.length(foot.uv, self.unwrap(found.uv, foot.uv) - foot.uv) <= self.near();
            if found.off <= self.near() && !sheets.iter().any(is_same) {
                sheets.push(found);
            }
        }
        sheets.sort_by(|a, b| a.off.total_cmp(&b.off));
        sheets.iter().map(|foot| foot.uv).collect()
    }

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
            let points: Vec<DVec3> =
                first_parameters(edge, self.is_exact(edge)).iter().map(|&t| edge.curve.point(t)).collect();
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
    /// A vertex farther off is the pole, too, if its distance from the surface explains that: in a file of few
    /// decimals, the apex of a cone and the vertex there are two points. That is so if a tenth of the way from the pole
    /// to the vertex leads off the surface; a fiftieth suffices `within` the file's tolerance, where points are one.
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
        let near = NEAR * self.tolerance;
        // A curve lies in the box of its points. Most poles are far from it; twice the distance leaves room for
        // rounding.
        let [low, high] = around(edge.curve.points.iter().copied());
        let may_pass = |pole: &Pole| pole.point.distance(pole.point.max(low).min(high)) <= 2.0 * near;
        let poles: SmallVec<[(&Pole, f64); 2]> =
            self.poles.iter().zip(self.reaches.iter().copied()).filter(|(pole, _)| may_pass(pole)).collect();
        if poles.is_empty() {
            return Vec::new();
        }
        let ts = first_parameters(edge, self.is_exact(edge));
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

    /// Whether two samples are exact: a straight edge in a plane.
    pub(super) fn is_exact(&self, edge: &Edge) -> bool {
        edge.kind == CurveKind::Line && matches!(self.surface, Surface::Plane { .. })
    }
}

#[cfg(test)]
mod tests;
