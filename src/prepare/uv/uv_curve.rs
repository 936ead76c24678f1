//! Pcurves in the parameter of their edge: cubic Hermite pieces, or isoparametric segments.

use glam::{DMat2, DVec2};
use std::sync::Arc;

/// Points closer than this share of a tile are one, and so are parameters closer than this share of their range.
/// Pcurves and their intersections are solved to 1e-12 of a face.
pub(crate) const SAME_SHARE: f64 = 1e-9;

/// A step in u (`axis` 0) or in v.
pub(crate) fn step_along(axis: usize, by: f64) -> DVec2 {
    if axis == 0 { DVec2::new(by, 0.0) } else { DVec2::new(0.0, by) }
}

/// A curve in (u,v), in the parameter of the edge it belongs to.
#[derive(Clone, Debug)]
pub enum UvCurve {
    /// Piecewise cubic Hermite through marched samples.
    Hermite(Arc<[UvSample]>),
    /// An isoparametric line: the coordinate `axis` is `at`, the other is the edge's own parameter.
    Iso {
        /// 0: u is constant; 1: v is constant.
        axis: u8,
        /// The constant.
        at: f64,
    },
}

/// A sample of a pcurve.
#[derive(Clone, Copy, Debug)]
pub struct UvSample {
    /// The edge's parameter.
    pub t: f64,
    /// Parameters of the surface point nearest to the edge's point.
    pub uv: DVec2,
    /// Derivative of `uv` by `t`.
    pub d: DVec2,
}

impl UvSample {
    /// The point `uv` of an iso-curve along `axis`, whose parameter is that coordinate.
    pub(crate) fn along(axis: usize, uv: DVec2) -> Self {
        Self { t: uv[axis], uv, d: step_along(axis, 1.0) }
    }

    /// The Hermite cubic between two samples at parameter `t`.
    #[must_use]
    #[inline]
    pub fn interpolate(a: &Self, b: &Self, t: f64) -> DVec2 {
        let h = b.t - a.t;
        let s = (t - a.t) / h;
        let r = 1.0 - s;
        a.uv * (r * r * (1.0 + 2.0 * s))
            + b.uv * (s * s * (3.0 - 2.0 * s))
            + (a.d * (r * r * s) - b.d * (s * s * r)) * h
    }

    /// Point and slope at `t` of the cubics through two or more samples. Beyond the ends, the point is that of the end.
    pub(crate) fn on(samples: &[Self], t: f64) -> Self {
        let k = samples.partition_point(|s| s.t <= t).clamp(1, samples.len() - 1);
        Self::at(&samples[k - 1], &samples[k], t)
    }

    /// The samples between two parameters, and those at these.
    pub(crate) fn within(samples: &[Self], [from, to]: [f64; 2]) -> Vec<Self> {
        let margin = 1e-12 * (to - from);
        let mut out = vec![Self::on(samples, from)];
        out.extend(samples.iter().filter(|s| s.t > from + margin && s.t < to - margin));
        out.push(Self::on(samples, to));
        out
    }

    /// The coordinates that all samples have in common, to the bit: those of parameter lines.
    pub(crate) fn constants(samples: &[Self]) -> [Option<f64>; 2] {
        let first = samples[0].uv;
        [0, 1].map(|axis| samples.iter().all(|s| s.uv[axis] == first[axis]).then_some(first[axis]))
    }

    /// Point and slope at `t` of the cubic between two samples.
    pub(crate) fn at(a: &Self, b: &Self, t: f64) -> Self {
        let h = b.t - a.t;
        let s = (t - a.t) / h;
        let d =
            (b.uv - a.uv) * (6.0 * s * (1.0 - s) / h) + a.d * ((3.0 * s - 4.0) * s + 1.0) + b.d * ((3.0 * s - 2.0) * s);
        Self { t, uv: Self::between(a, b, t), d }
    }

    /// The point at `t` of the cubic between two samples, and beyond them that of the nearer one.
    #[inline(always)]
    fn between(a: &Self, b: &Self, t: f64) -> DVec2 {
        if t <= a.t {
            a.uv
        } else if t >= b.t {
            b.uv
        } else {
            Self::interpolate(a, b, t)
        }
    }

    /// The integral of p × dp along the cubic between two samples, with p from `origin`: twice the area that it sweeps
    /// as seen from there.
    pub(crate) fn double_area(a: &Self, b: &Self, origin: DVec2) -> f64 {
        let h = b.t - a.t;
        let (chord, d0, d1) = (b.uv - a.uv, a.d * h, b.d * h);
        let bulge = (d0 - d1).perp_dot(chord) / 5.0 - d0.perp_dot(d1) / 30.0;
        (a.uv - origin).perp_dot(chord) + bulge
    }

    /// Calls `see` with the parameters strictly between two samples at which coordinate `axis` of the cubic has an
    /// extreme; at most two.
    pub(crate) fn extremes(a: &Self, b: &Self, axis: usize, mut see: impl FnMut(f64)) {
        let h = b.t - a.t;
        let (d0, d1, rise) = (a.d[axis] * h, b.d[axis] * h, b.uv[axis] - a.uv[axis]);
        // Bernstein coefficients of the derivative: if all have one sign, so has the derivative.
        let middle = 3.0 * rise - d0 - d1;
        let falls = d0 < 0.0 || d1 < 0.0 || middle < 0.0;
        let rises = d0 > 0.0 || d1 > 0.0 || middle > 0.0;
        if !(falls && rises) {
            return;
        }
        // The derivative by s in [0, 1]: d0 + 2 s q + s² p.
        let (p, q) = (3.0 * (d0 + d1 - 2.0 * rise), 3.0 * rise - 2.0 * d0 - d1);
        let root = (q * q - p * d0).sqrt();
        let far = -(q + root.copysign(q));
        for s in [far / p, d0 / far] {
            if s > 0.0 && s < 1.0 {
                see(a.t + s * h);
            }
        }
    }
}

/// A curve in (u,v) to be sampled, by a parameter that need not be the edge's.
pub(crate) struct SampledCurve<S, P> {
    pub(crate) sample: S,
    /// The edge's parameter and the point of a sample, which may cost less than its slope.
    pub(crate) place: P,
    /// Largest distance of cubics between samples.
    pub(crate) tolerance: f64,
    /// Maximum halvings between two samples.
    pub(crate) max_depth: u32,
}

impl<S: Fn(f64) -> UvSample, P: Fn(f64) -> (f64, DVec2)> SampledCurve<S, P> {
    /// Appends samples after `a`, that at `from`, up to `b`, that at `to`, such that the cubics between them fit.
    pub(crate) fn follow(&self, [from, to]: [f64; 2], [a, b]: [&UvSample; 2], depth: u32, out: &mut Vec<UvSample>) {
        let follows = a.d.is_finite()
            && b.d.is_finite()
            && [0.25, 0.5, 0.75].into_iter().all(|share| {
                let (t, uv) = (self.place)(from + (to - from) * share);
                UvSample::interpolate(a, b, t).distance(uv) <= self.tolerance
            });
        if follows || depth == self.max_depth {
            out.push(*b);
            return;
        }
        let middle = 0.5 * (from + to);
        let m = (self.sample)(middle);
        self.follow([from, middle], [a, &m], depth + 1, out);
        self.follow([middle, to], [&m, b], depth + 1, out);
    }
}

/// Newton's method for the parameters at which two pcurves meet, from `t` and within `limits`. Stops where their points
/// are closer than a thousandth of `near`, with (u,v) multiplied by `scale`.
pub(crate) fn newton_meeting(
    sample: impl Fn(usize, f64) -> UvSample,
    scale: DVec2,
    limits: [[f64; 2]; 2],
    mut t: [f64; 2],
    near: f64,
) -> [f64; 2] {
    /// Maximum steps: from chords of a 256th of an arc, three are enough.
    const STEPS: usize = 12;
    for _ in 0..STEPS {
        let [x, y] = [0, 1].map(|k| sample(k, t[k]));
        let miss = (y.uv - x.uv) * scale;
        let step = DMat2::from_cols(x.d * scale, -y.d * scale).inverse() * miss;
        if !step.is_finite() || miss.length() <= 1e-3 * near {
            break;
        }
        t = [0, 1].map(|k| (t[k] + step[k]).clamp(limits[k][0], limits[k][1]));
    }
    t
}

impl UvCurve {
    /// The point at `t`. At a sample's parameter it is the sample, bit for bit.
    ///
    /// `hint` is the piece used last, updated on return: queries in order of `t` take amortised constant time.
    #[must_use]
    pub fn point(&self, t: f64, hint: &mut usize) -> DVec2 {
        match self {
            Self::Iso { axis: 0, at } => DVec2::new(*at, t),
            Self::Iso { at, .. } => DVec2::new(t, *at),
            Self::Hermite(samples) => {
                let i = piece_near(samples, t, *hint);
                *hint = i;
                UvSample::between(&samples[i], &samples[i + 1], t)
            }
        }
    }

    /// The piece that contains `t`: the first one before the pcurve, the last one beyond it. 0 of a line.
    pub(crate) fn piece(&self, t: f64) -> u32 {
        match self {
            Self::Iso { .. } => 0,
            Self::Hermite(samples) => (samples.partition_point(|s| s.t <= t).clamp(1, samples.len() - 1) - 1) as u32,
        }
    }

    /// Appends [`point`](Self::point) of each parameter. Fastest if the first is on or near `piece`, and each near the
    /// one before.
    // By `push`: the standard library does not inline `extend`, and most uses of edges have few tessellants.
    #[inline(always)]
    pub(crate) fn points(&self, ts: &[f64], piece: u32, out: &mut Vec<DVec2>) {
        match self {
            Self::Iso { axis: 0, at } => ts.iter().for_each(|&t| out.push(DVec2::new(*at, t))),
            Self::Iso { at, .. } => ts.iter().for_each(|&t| out.push(DVec2::new(t, *at))),
            Self::Hermite(samples) => {
                // A search would read samples all over the pcurve.
                let mut i = (piece as usize).min(samples.len() - 2);
                let (mut a, mut b) = (&samples[i], &samples[i + 1]);
                for &t in ts {
                    if t < a.t || t >= b.t {
                        i = piece_near(samples, t, i);
                        (a, b) = (&samples[i], &samples[i + 1]);
                    }
                    out.push(UvSample::between(a, b, t));
                }
            }
        }
    }
}

/// The piece between two samples that contains `t`, by a walk from piece `i`.
#[inline(always)]
fn piece_near(samples: &[UvSample], t: f64, i: usize) -> usize {
    let last = samples.len() - 1;
    let mut i = i.min(last - 1);
    while i > 0 && t < samples[i].t {
        i -= 1;
    }
    while i + 1 < last && t >= samples[i + 1].t {
        i += 1;
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_the_same_from_any_piece() {
        let sample = |k: i32| {
            let t = f64::from(k * k) / 25.0;
            UvSample { t, uv: DVec2::new(t, t * t), d: DVec2::new(1.0, 2.0 * t + f64::from(k)) }
        };
        let uv = UvCurve::Hermite((0..=5).map(sample).collect());
        let rising: Vec<f64> = (-1..=21).map(|k| 0.05 * f64::from(k)).collect();
        let falling: Vec<f64> = rising.iter().rev().copied().collect();
        for ts in [rising, falling, Vec::new()] {
            let expected: Vec<DVec2> = ts.iter().map(|&t| uv.point(t, &mut 0)).collect();
            for piece in 0..9 {
                let mut points = Vec::new();
                uv.points(&ts, piece, &mut points);
                assert_eq!(points, expected, "from piece {piece}");
            }
        }
        assert_eq!([-1.0, 0.0, 0.039, 0.04, 0.99, 1.0, 2.0].map(|t| uv.piece(t)), [0, 0, 0, 1, 4, 4, 4]);
        let line = UvCurve::Iso { axis: 1, at: 3.0 };
        assert_eq!((line.piece(0.5), line.point(0.5, &mut 7)), (0, DVec2::new(0.5, 3.0)));
    }
}
