//! An edge's curve in space -> its pcurve, in the edge's parameter. The curve in space is the master.
//!
//! Each sample is projected from the neighbourhood of its predecessor (march projection), so that the image stays on
//! one sheet of a folded or periodic surface. Samples carry derivatives and are joined by cubic Hermite pieces, which
//! are refined until the fit stays within a tolerance of the projection.

use super::foot::{Foot, jacobian_solve};
use super::lead::{EndBlend, first_parameters, leads, only_neighbour};
use super::projector::{FAR_OFF, Projector};
use super::uv_curve::UvSample;
use crate::math::lanes::larger;
use crate::model::{CurveKind, Edge, Pole, Surface};
use glam::{DVec2, DVec3};
use std::cell::Cell;

/// Depth of bisection below the first samples of a pcurve. Ten levels turn 8 samples into 8 000. An edge that needs
/// more is noise, and its gap is reported.
const MAX_DEPTH: u32 = 10;

/// Depth of bisection next to a pole, where the image turns by half a period within a few times the distance to the
/// pole. That distance is at least 1e-5 of the face: a nearer edge passes through the pole.
const MAX_DEPTH_AT_POLE: u32 = 24;

/// A pcurve with this many samples is not refined further. Real ones have 2 to 500; more would be noise and take
/// seconds.
const MAX_SAMPLES: usize = 20_000;

/// Accuracy of the image beyond [`FAR_OFF`], as a share of the distance.
const SHARE_OF_GAP: f64 = 0.2;

/// Largest error of a piece of an image whose middle is right, as a share of the piece.
const ODD: f64 = 0.01;

/// Depth of bisection from which on the middle of a piece stands for all of it. A kink has two slopes at any depth. A
/// first piece of 64 mirrored spans takes six levels.
const ODD_DEPTH: u32 = 6;

/// How many times nearer the cubics of both halves are, at least: 10.6, and 16 in the limit. The piece is of half a
/// span of an arc or less, from an end or the middle of the span.
const BY_HALVING: f64 = 10.0;

/// Largest change of a parameter that counts as constant, as a share of the tolerance.
const STEADY: f64 = 0.05;

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

impl Projector<'_> {
    /// Marches the image of `edge` in loop direction from `seed`. `ends` are the edge's vertices.
    pub(crate) fn march(&self, edge: &Edge, ends: [DVec3; 2], reversed: bool, seed: Option<DVec2>) -> Marched {
        let (t0, t1) = edge.range;
        self.vain.set(0);
        let end_poles = [self.pole_at(ends[0]), self.pole_at(ends[1])];
        let mut ts = first_parameters(edge, self.is_exact(edge));
        if reversed {
            ts.reverse();
        }
        // At a pole the image follows the curve to the surface's point, round which it does not turn.
        let ends = [0, 1].map(|k| end_poles[k].map_or(ends[k], |pole| self.tips[pole]));
        let leads = leads(edge, ends, self.tolerance);
        let is_whole = edge.curve.degree == 2 && edge.range == edge.curve.domain() && leads.iter().all(Option::is_none);
        let is_circle = edge.kind == CurveKind::Circle && is_whole;
        let walk = Walk { projector: self, edge, ends, leads, is_circle, leap: Cell::new(0.0) };
        let [first_pole, last_pole] = if reversed { [end_poles[1], end_poles[0]] } else { end_poles };
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
        let mut samples: Vec<UvSample> = out.iter().map(|s| s.0).collect();
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

    /// Adds the samples up to `t`, each by `sample` from its parameter and the one before. Takes more than one step if
    /// the image may turn by more than a quarter of a period, by its slope at either end: after half of a period,
    /// nothing tells one turn from the next.
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

    /// Length of the image's step between two samples, but for whole periods. 0 if the step of the edge and the
    /// distance of its ends from the surface explain it.
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
        // A cubic that is wrong by an odd function is right in the middle, with a wrong slope: then its largest error
        // is that of s² (1 - s)² (s - ½), a seventh of its slope. The slope of a pole is NaN.
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

/// Whether the halves of a piece between two samples of a circle's image fit within `tolerance`, where the whole misses
/// the middle sample by `off`. `speeds`: lengths of the surface's derivatives there.
///
/// Known for circles in planes, and where one parameter is constant and the other an angle. Not next to a pole, where
/// slopes are NaN.
fn halves_fit(surface: &Surface, samples: [&UvSample; 3], speeds: DVec2, off: f64, tolerance: f64) -> bool {
    let [a, _, b] = samples;
    let moves = |s: &UvSample, axis: usize| (s.uv - a.uv)[axis].abs() + (s.d[axis] * (b.t - a.t)).abs();
    let is_steady = |axis: usize| samples.iter().all(|s| speeds[axis] * moves(s, axis) <= STEADY * tolerance);
    off <= BY_HALVING * tolerance
        && match surface {
            Surface::Plane { .. } => true,
            Surface::Cylinder { .. } | Surface::Cone { .. } => is_steady(1),
            Surface::Sphere { .. } | Surface::Torus { .. } => is_steady(0) || is_steady(1),
            Surface::Extrusion { .. } | Surface::Revolution { .. } | Surface::Nurbs(_) => false,
        }
}

#[cfg(test)]
mod tests;
