//! A pcurve in the parameter of one curve -> the same pcurve in the parameter of another curve that coincides with it.
//! A parameter of the other curve corresponds to the foot of its point. Cubics between these are halved until they fit.

use super::overlap::CurveQuery;
use crate::math::boxes::around;
use crate::prepare::uv::uv_curve::{SampledCurve, UvSample};

/// Tolerance of the cubic pieces, as a share of the pcurve's extent.
const FIT: f64 = 1e-8;

/// Share of a curve's length within which control points are the same.
const ROUNDING: f64 = 1e-9;

/// Maximum halvings between two samples.
const MAX_DEPTH: u32 = 7;

/// Reparametrizes a pcurve from the curve `own` to `kept`, which coincides with it within `width`; `against`: in the
/// opposite direction. The ends keep their (u,v) to the bit.
pub(crate) fn carry(
    samples: &[UvSample],
    own: &CurveQuery,
    kept: &CurveQuery,
    against: bool,
    width: f64,
) -> Vec<UvSample> {
    let ([a, b], [from, to]) = (own.range(), kept.range());
    let is_same = |tolerance: f64| own.same_net(kept, tolerance).is_some_and(|(_, turned)| turned == against);
    if is_same(width) || is_same(width + ROUNDING * own.length()) {
        // The parameters differ by a linear map only.
        let rate = (to - from) / (b - a) * if against { -1.0 } else { 1.0 };
        let [at_a, at_b] = if against { [to, from] } else { [from, to] };
        let moved = |s: &UvSample| {
            let t = if s.t == a {
                at_a
            } else if s.t == b {
                at_b
            } else {
                at_a + (s.t - a) * rate
            };
            UvSample { t, uv: s.uv, d: s.d / rate }
        };
        let mut out: Vec<UvSample> = samples.iter().map(moved).collect();
        if against {
            out.reverse();
        }
        return out;
    }
    let [low, high] = around(samples.iter().map(|s| s.uv));
    let bearer = Bearer { samples, own, kept, ends: if against { [b, a] } else { [a, b] } };
    let mut stops = vec![from, to];
    stops.extend(samples[1..samples.len() - 1].iter().map(|s| kept.foot(own.point(s.t)).0));
    stops.retain(|&t| t >= from && t <= to);
    stops.sort_by(f64::total_cmp);
    stops.dedup_by(|t, before| *t - *before <= 1e-9 * (to - from));
    if let Some(last) = stops.last_mut() {
        *last = to;
    }
    let curve = SampledCurve {
        sample: |t| bearer.sample(t),
        place: |t| (t, bearer.sample(t).uv),
        tolerance: FIT * (high - low).length(),
        max_depth: MAX_DEPTH,
    };
    let mut out = vec![bearer.sample(from)];
    for w in stops.windows(2) {
        let before = out[out.len() - 1];
        curve.follow([w[0], w[1]], [&before, &bearer.sample(w[1])], 0, &mut out);
    }
    straighten(samples, &mut out);
    out
}

struct Bearer<'a> {
    samples: &'a [UvSample],
    own: &'a CurveQuery,
    kept: &'a CurveQuery,
    /// Parameters of `own` where `kept` starts and ends.
    ends: [f64; 2],
}

impl Bearer<'_> {
    fn sample(&self, t: f64) -> UvSample {
        let [from, to] = self.kept.range();
        let foot = if t == from {
            self.ends[0]
        } else if t == to {
            self.ends[1]
        } else {
            self.own.foot(self.kept.point(t)).0
        };
        let there = UvSample::on(self.samples, foot);
        let (own, kept) = (self.own.slope(foot), self.kept.slope(t));
        let rate = kept.dot(own) / own.length_squared();
        UvSample { t, uv: there.uv, d: there.d * rate }
    }
}

/// Replaces slopes that are not finite, where one of the curves has no speed, by those of the chords. Along a line of
/// constant parameter, limits slopes that would make cubics turn back.
fn straighten(stated: &[UvSample], samples: &mut [UvSample]) {
    let first = stated[0].uv;
    let on_line = [0, 1].map(|axis| stated.iter().all(|s| s.uv[axis] == first[axis]));
    let chord = |a: &UvSample, b: &UvSample| (b.uv - a.uv) / (b.t - a.t);
    let last = samples.len() - 1;
    for k in 0..=last {
        let beside = [k.saturating_sub(1), k].map(|k| k.min(last - 1));
        let chords = beside.map(|k| chord(&samples[k], &samples[k + 1]));
        let s = &mut samples[k];
        if !s.d.is_finite() {
            s.d = 0.5 * (chords[0] + chords[1]);
        }
        for axis in 0..2 {
            if on_line[axis] {
                (s.uv[axis], s.d[axis]) = (first[axis], 0.0);
            } else if on_line[1 - axis] {
                // Fritsch & Carlson's bound for monotone cubics.
                let [c, d] = chords.map(|c| c[axis]);
                let most = 3.0 * c.abs().min(d.abs());
                s.d[axis] = if c * d <= 0.0 { 0.0 } else { (s.d[axis] * c.signum()).clamp(0.0, most) * c.signum() };
            }
        }
    }
}
