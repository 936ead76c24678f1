//! An edge's curve in space -> its pcurve, in the edge's parameter. The curve in space is the master.
//!
//! Each sample is projected from the neighbourhood of its predecessor (march projection), so that the image stays on
//! one sheet of a folded or periodic surface. Samples carry derivatives and are joined by cubic Hermite pieces, which
//! are refined until the fit stays within a tolerance of the projection.

use super::foot::{Foot, jacobian_solve, newton_step};
use super::halves::halves_fit;
use super::lead::{EndBlend, before_breaks, leads, only_neighbour};
use super::seeds::Seeds;
use super::uv_curve::UvSample;
use crate::math::lanes::larger;
use crate::math::solve::{equal_pieces, least_squares};
use crate::model::{CurveKind, Edge, Pole, Surface, SurfaceDerivatives};
use glam::{DVec2, DVec3};
use smallvec::{SmallVec, smallvec};
use std::cell::{Cell, OnceCell};

/// Depth of bisection below the first samples of a pcurve. Ten levels turn 8 samples into 8 000. An edge that needs
/// more is noise, and its gap is reported.
const MAX_DEPTH: u32 = 10;

/// Depth of bisection next to a pole, where the image turns by half a period within a few times the distance to the
/// pole. That distance is at least 1e-5 of the face: a nearer edge passes through the pole.
const MAX_DEPTH_AT_POLE: u32 = 24;

/// A pcurve with this many samples is not refined further. Real ones have 2 to 500; more would be noise and take
/// seconds.
const MAX_SAMPLES: usize = 20_000;

/// Steps of one projection, halved ones included. Quadratic convergence takes 3–5 from a good seed, slow tangential
/// convergence about 30.
const MAX_STEPS: u32 = 80;

/// Steps by first derivatives before second ones are used. Points on the surface are found by then.
const FIRST_STEPS: u32 = 4;

/// Consecutive searches of the whole surface that may fail to improve a projection. After that the march of this edge
/// goes on without searches: the edge lies off the surface.
const MAX_VAIN: u32 = 8;

/// Distance between an edge and the surface, in tolerances, beyond which the image is refined only to a share of that
/// distance. The edges of sound files lie nearer.
const FAR_OFF: f64 = 3e3;

/// Accuracy of the image beyond [`FAR_OFF`], as a share of the distance.
const SHARE_OF_GAP: f64 = 0.2;

/// Largest error of a piece of an image whose middle is right, as a share of the piece.
const ODD: f64 = 0.01;

/// Depth of bisection from which on the middle of a piece stands for all of it. A kink has two slopes at any depth. A
/// first piece of 64 mirrored spans takes six levels.
const ODD_DEPTH: u32 = 6;

/// Length of the last step of a projection from beyond [`FAR_OFF`], as a share of the distance.
const FAR_ENOUGH: f64 = 0.005;

/// Projects points onto one surface.
pub(crate) struct Projector<'a> {
    surface: &'a Surface,
    /// Periods in u and v.
    pub(crate) period: [Option<f64>; 2],
    /// Natural domain; infinite where the surface is.
    pub(crate) domain: [(f64, f64); 2],
    /// Whether tangents are continuous, and do not vanish on a line.
    smooth: bool,
    /// Whether tangents may jump at a line.
    may_jump: bool,
    /// Whether its speed may be odd about the middle of a piece: a spline of several spans or of degree 3, or swept from
    /// one.
    is_uneven: bool,
    /// Distance from the surface, in tolerances, beyond which a projection is tried from elsewhere. It may stop at a
    /// crease between straight spans, next to the tooth where the point is.
    enough: f64,
    /// Parameter lines that collapse to a point. The points are those of B-rep vertices there, once adopted.
    pub(crate) poles: Vec<Pole>,
    /// The surface's own point at each pole.
    tips: SmallVec<[DVec3; 2]>,
    /// Distance from each pole within which points are the pole: ten tolerances, or less where edges go round it.
    reaches: SmallVec<[f64; 2]>,
    /// Points of this face closer than this are one.
    pub(crate) tolerance: f64,
    seeds: OnceCell<Seeds>,
    /// Searches without improvement since the last one that improved, or since the edge began.
    vain: Cell<u32>,
}

/// The image of one edge in one face.
pub(crate) struct Marched {
    /// In order of the edge's parameter.
    pub(crate) samples: Vec<UvSample>,
    /// Largest distance between edge and surface, at the samples and in the middles between them.
    pub(crate) gap: f64,
    /// Longest leap of the image, in space: from one sheet of the surface to another. 0 without a leap.
    pub(crate) leap: f64,
    /// Poles at the ends, in order of the edge's parameter.
    pub(crate) poles: [Option<usize>; 2],
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
            reaches: smallvec![poles::NEAR * tolerance; poles.len()],
            tips: poles.iter().map(|pole| pole.point).collect(),
            poles,
            tolerance,
            seeds: OnceCell::new(),
            vain: Cell::new(0),
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
    fn tangents(&self, at: DVec2) -> [DVec3; 3] {
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

    fn foot(&self, p: DVec3, seed: Option<DVec2>) -> Foot {
        if let Some(uv) = self.surface.invert(p) {
            return self.foot_at(seed.map_or(uv, |s| self.unwrap(uv, s)), p);
        }
        let Some(s) = seed else { return self.search(p) };
        let near = self.newton(p, s);
        if near.off <= self.near() || self.vain.get() >= MAX_VAIN {
            return near;
        }
        let far = self.search(p);
        let found = far.off < 0.5 * near.off;
        self.vain.set(if found { 0 } else { self.vain.get() + 1 });
        if found { Foot { uv: self.unwrap(far.uv, s), ..far } } else { near }
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
    /// the surface, by second ones too (Newton). The first steps may swing. Later ones start at the nearest point so far
    /// and are halved until the distance falls.
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

    /// Marches the image of `edge` in loop direction from `seed`. `ends` are the edge's vertices.
    pub(crate) fn march(&self, edge: &Edge, ends: [DVec3; 2], reversed: bool, seed: Option<DVec2>) -> Marched {
        let (t0, t1) = edge.range;
        self.vain.set(0);
        let end_poles = [self.pole_at(ends[0]), self.pole_at(ends[1])];
        let mut ts = self.first_parameters(edge);
        if reversed {
            ts.reverse();
        }
        // At a pole the image follows the curve to the surface's point, round which it does not turn.
        let ends = [0, 1].map(|k| end_poles[k].map_or(ends[k], |pole| self.tips[pole]));
        let leads = leads(edge, ends, self.tolerance);
        let is_whole = edge.curve.degree == 2 && edge.range == edge.curve.domain() && leads.iter().all(Option::is_none);
        let is_circle = edge.kind == CurveKind::Circle && is_whole;
        let walk = Walk { projector: self, edge, ends, leads, is_circle, leap: Cell::new(0.0) };
        let order = |pair: [Option<usize>; 2]| if reversed { [pair[1], pair[0]] } else { pair };
        let [first_pole, last_pole] = order(end_poles);
        let mut out: Vec<(UvSample, f64)> = Vec::with_capacity(2 * ts.len());
        let span = (t1 - t0) * if reversed { -1.0 } else { 1.0 };
        let near_end = |t: f64, inward: f64, pole: usize, seed: Option<DVec2>| {
            let inner = walk.sample(t + inward, seed);
            walk.at_pole(t, &self.poles[pole], &inner.0)
        };
        let first = match first_pole {
            Some(pole) => near_end(ts[0], 1e-3 * span, pole, None),
            None => walk.sample(ts[0], seed),
        };
        out.push(walk.on_its_side(first, &ts, 0));
        for (k, &end) in ts.iter().enumerate().skip(1) {
            walk.advance(end, 0, &mut out, &|t, previous| match last_pole {
                Some(pole) if k + 1 == ts.len() && t == end => near_end(t, -1e-3 * span, pole, Some(previous.uv)),
                _ if t == end => walk.on_its_side(walk.sample(t, Some(walk.guess(previous, t))), &ts, k),
                _ => walk.sample(t, Some(walk.guess(previous, t))),
            });
        }
        let gap = out.iter().map(|s| s.1).fold(0.0, f64::max);
        let mut samples = Vec::with_capacity(out.len());
        samples.extend(out.iter().map(|s| s.0));
        if !self.poles.is_empty() {
            self.unwind(&mut samples);
        }
        if reversed {
            samples.reverse();
        }
        fill_slopes(&mut samples);
        Marched { samples, gap, leap: walk.leap.get(), poles: end_poles }
    }

    /// Moves samples by whole periods next to their predecessors. The first samples of an edge that passes a pole are
    /// too coarse to show on which side it passes. A wrong guess shows as a jump between refined samples.
    fn unwind(&self, samples: &mut [UvSample]) {
        for axis in 0..2 {
            let Some(p) = self.period[axis] else { continue };
            let mut by = 0.0;
            for k in 1..samples.len() {
                samples[k].uv[axis] += by;
                let (a, b) = (samples[k - 1], samples[k]);
                let step = 0.5 * (a.d[axis] + b.d[axis]) * (b.t - a.t);
                let step = if step.abs() < 0.5 * p { step } else { 0.0 };
                let jump = p * ((b.uv[axis] - a.uv[axis] - step) / p).round();
                samples[k].uv[axis] -= jump;
                by -= jump;
            }
        }
    }

    /// Whether two samples are exact: a straight edge in a plane.
    fn is_exact(&self, edge: &Edge) -> bool {
        edge.kind == CurveKind::Line && matches!(self.surface, Surface::Plane { .. })
    }

    fn first_parameters(&self, edge: &Edge) -> Vec<f64> {
        let (t0, t1) = edge.range;
        let margin = 1e-9 * (t1 - t0);
        let knots = edge.curve.knots.iter().copied().filter(|&k| k > t0 + margin && k < t1 - margin);
        let mut ts: SmallVec<[f64; 16]> = std::iter::once(t0).chain(knots).chain([t1]).collect();
        ts.dedup();
        let pieces = match edge.kind {
            CurveKind::Line if self.is_exact(edge) => 1,
            CurveKind::Line | CurveKind::Circle | CurveKind::Conic => 2,
            CurveKind::Polyline => 1,
            CurveKind::Spline if ts.len() > 32 => 1,
            CurveKind::Spline => (8 / (ts.len() - 1).max(1)).max(2),
        };
        let mut fine = Vec::with_capacity(pieces * (ts.len() - 1) + 1);
        fine.extend(equal_pieces(&ts, pieces));
        if matches!(edge.kind, CurveKind::Spline | CurveKind::Polyline) {
            fine.extend(before_breaks(edge));
            fine.sort_by(f64::total_cmp);
        }
        fine.push(t1);
        fine
    }
}

/// One edge on one surface.
struct Walk<'a> {
    projector: &'a Projector<'a>,
    edge: &'a Edge,
    ends: [DVec3; 2],
    leads: [Option<EndBlend>; 2],
    /// Whether it has the even spans of an arc, of a right angle or less.
    is_circle: bool,
    /// Longest leap so far.
    leap: Cell<f64>,
}

impl Walk<'_> {
    /// The sample at `t` and its distance from the edge.
    fn sample(&self, t: f64, seed: Option<DVec2>) -> (UvSample, f64) {
        let (sample, gap, _) = self.sample_with_speeds(t, seed);
        (sample, gap)
    }

    /// Like [`sample`](Self::sample), with the lengths of the surface's derivatives by u and v.
    fn sample_with_speeds(&self, t: f64, seed: Option<DVec2>) -> (UvSample, f64, DVec2) {
        let [mut point, mut d1] = self.edge.curve.tangent(t);
        for [off, slope] in self.leads.iter().flatten().map(|lead| lead.at(t)) {
            point += off;
            d1 += slope;
        }
        let p = if t == self.edge.range.0 {
            self.ends[0]
        } else if t == self.edge.range.1 {
            self.ends[1]
        } else {
            point
        };
        let Foot { uv, tangents: [point, du, dv], .. } = self.projector.foot(p, seed);
        let d = jacobian_solve(du, dv, d1);
        (UvSample { t, uv, d }, point.distance(p), DVec2::new(du.length(), dv.length()))
    }

    /// Adds the samples up to `t`, each by `sample` from its parameter and the one before. Takes more than one step if the
    /// image may turn by more than a quarter of a period, by its slope at either end: after half of a period, nothing
    /// tells one turn from the next.
    fn advance(
        &self,
        t: f64,
        depth: u32,
        out: &mut Vec<(UvSample, f64)>,
        sample: &dyn Fn(f64, &UvSample) -> (UvSample, f64),
    ) {
        let previous = out[out.len() - 1].0;
        let next = sample(t, &previous);
        let turns = |axis: usize| {
            let step = previous.d[axis].abs().max(next.0.d[axis].abs()) * (t - previous.t).abs();
            self.projector.period[axis].is_some_and(|period| step > 0.25 * period)
        };
        if depth < MAX_DEPTH && out.len() < MAX_SAMPLES && (turns(0) || turns(1)) {
            self.advance(0.5 * (previous.t + t), depth + 1, out, sample);
            self.advance(t, depth + 1, out, sample);
            return;
        }
        if !self.projector.is_exact(self.edge) {
            self.refine(&previous, &next.0, 0, out);
        }
        out.push(next);
    }

    /// The seed at `t`: a step along the slope at `from`, limited to a quarter of the period or half of the domain.
    fn guess(&self, from: &UvSample, t: f64) -> DVec2 {
        let step = if from.d.is_finite() { from.d * (t - from.t) } else { DVec2::ZERO };
        let mut scale = 1.0_f64;
        for axis in 0..2 {
            let (lo, hi) = self.projector.domain[axis];
            let room = self.projector.period[axis].map_or(hi - lo, |p| 0.5 * p);
            if room.is_finite() && step[axis].abs() > 0.5 * room {
                scale = scale.min(0.5 * room / step[axis].abs());
            }
        }
        from.uv + step * scale
    }

    /// A sample at `ts[k]`. At ends and kinks, which bound cubics on one side only, its slope is the one of that side.
    /// Where the surface's tangents jump, at a seam or along a knot, rounding decides which side a point is on. A slope
    /// from the other side may be many times too large, and the image folds back however short its last cubic is.
    fn on_its_side(&self, (mut sample, gap): (UvSample, f64), ts: &[f64], k: usize) -> (UvSample, f64) {
        /// Where to look, as a share of the way to the next sample.
        const INWARD: f64 = 1e-6;
        /// Slopes that differ by less than this share of the longer one are on the same side.
        const SAME: f64 = 0.01;
        if let Some(next) = only_neighbour(ts, k).filter(|_| self.projector.may_jump) {
            let (near, _) = self.sample(sample.t + INWARD * (next - sample.t), Some(sample.uv));
            if (near.d - sample.d).length() > SAME * near.d.length().max(sample.d.length()) {
                sample.d = near.d;
            }
        }
        (sample, gap)
    }

    /// The sample at a pole: one coordinate is the pole's, the collapsed one continues from `inner`.
    fn at_pole(&self, t: f64, pole: &Pole, inner: &UvSample) -> (UvSample, f64) {
        let step = inner.d * (t - inner.t);
        let small = (0..2).all(|axis| {
            let (lo, hi) = self.projector.domain[axis];
            step[axis].abs() <= 0.1 * self.projector.period[axis].unwrap_or(hi - lo)
        });
        let mut uv = inner.uv + if step.is_finite() && small { step } else { DVec2::ZERO };
        // The pole line, or periodic copy of one, nearest to `inner`: a closed profile meets its axis twice.
        let fixed = pole.axis;
        let from = inner.uv[fixed];
        let images = self.projector.poles.iter().filter(|p| p.axis == fixed && p.point == pole.point).map(|p| {
            p.at + self.projector.period[fixed].map_or(0.0, |period| period * ((from - p.at) / period).round())
        });
        uv[fixed] = images.min_by(|a, b| (a - from).abs().total_cmp(&(b - from).abs())).unwrap_or(pole.at);
        (UvSample { t, uv, d: DVec2::NAN }, 0.0)
    }

    /// Whether a pole lies so close to the edge between two samples that they may miss a turn of the image about it.
    fn passes_pole(&self, a: &UvSample, b: &UvSample) -> bool {
        let [p, q] = [a.t, b.t].map(|t| self.edge.curve.point(t));
        let reach = p.distance(q);
        self.projector.poles.iter().any(|pole| pole.point.distance(p).min(pole.point.distance(q)) < reach)
    }

    /// Length of the image's step between two samples, but for whole periods. 0 if the step of the edge and the distance
    /// of its ends from the surface explain it.
    fn leap_between(&self, a: &UvSample, b: &UvSample) -> f64 {
        let projector = self.projector;
        let by = projector.unwrap(b.uv, a.uv) - a.uv;
        let step = projector.length(a.uv, by).min(projector.length(b.uv, by));
        let [p, q] = [a.t, b.t].map(|t| self.edge.curve.point(t));
        let explained = p.distance(q) + projector.point(a.uv).distance(p) + projector.point(b.uv).distance(q);
        if step > 2.0 * explained + projector.tolerance { step } else { 0.0 }
    }

    fn refine(&self, a: &UvSample, b: &UvSample, depth: u32, out: &mut Vec<(UvSample, f64)>) {
        let deep = depth >= MAX_DEPTH && (depth >= MAX_DEPTH_AT_POLE || !self.passes_pole(a, b));
        if deep || out.len() >= MAX_SAMPLES {
            self.leap.set(larger(self.leap.get(), self.leap_between(a, b)));
            return;
        }
        let t = 0.5 * (a.t + b.t);
        let mut pair = [*a, *b];
        fill_slopes(&mut pair);
        let guess = UvSample::interpolate(&pair[0], &pair[1], t);
        let (mid, gap, speeds) = self.sample_with_speeds(t, Some(guess));
        // `d` neglects the surface's curvature below the edge: its error is in proportion to the gap.
        let tolerance = self.projector.tolerance;
        let is_near = gap <= FAR_OFF * tolerance;
        let may_be_off = if is_near { 4.0 * tolerance } else { SHARE_OF_GAP * gap };
        let length = |uv: DVec2| speeds.x * uv.x.abs() + speeds.y * uv.y.abs();
        // A cubic that is wrong by an odd function is right in the middle, with a wrong slope: then its largest error is
        // that of s² (1 - s)² (s - ½), a seventh of its slope. The slope of a pole is NaN.
        let slope = || UvSample::at(&pair[0], &pair[1], t).d;
        let odd = || length((mid.d - slope()) * (b.t - a.t) / 7.0);
        let is_uneven = self.projector.is_uneven || self.edge.curve.degree > 3;
        let may_be_odd = is_near && is_uneven && depth < ODD_DEPTH;
        let is_odd = || may_be_odd && odd() > may_be_off.max(ODD * length(b.uv - a.uv));
        let off = length(mid.uv - guess);
        if off > may_be_off || is_odd() {
            let halves_fit = || halves_fit(self.projector.surface, [a, &mid, b], speeds, off, may_be_off);
            if self.is_circle && gap <= tolerance && halves_fit() {
                out.push((mid, gap));
                return;
            }
            self.refine(a, &mid, depth + 1, out);
            out.push((mid, gap));
            self.refine(&mid, b, depth + 1, out);
        } else if let Some((_, before)) = out.last_mut() {
            // The edge may be farthest from the surface between samples: a chord, between its corners.
            *before = larger(gap, *before);
        }
    }
}

/// Derives slopes that the surface does not give (at poles) from neighbouring samples.
fn fill_slopes(samples: &mut [UvSample]) {
    for i in 0..samples.len() {
        if samples[i].d.is_finite() {
            continue;
        }
        let k = if i + 1 < samples.len() { i + 1 } else { i - 1 };
        let chord = (samples[k].uv - samples[i].uv) / (samples[k].t - samples[i].t);
        samples[i].d = if samples[k].d.is_finite() { 2.0 * chord - samples[k].d } else { chord };
    }
}

mod poles;
mod search;
#[cfg(test)]
mod tests;
