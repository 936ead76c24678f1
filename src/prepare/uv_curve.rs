//! A coedge's pcurve in its edge's parameter: cubic Hermite pieces, or an isoparametric segment.

use glam::DVec2;

/// A curve in (u,v), in the parameter of the edge it belongs to.
#[derive(Clone, Debug)]
pub enum UvCurve {
    /// Piecewise cubic Hermite through marched samples.
    Hermite(Box<[UvSample]>),
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
    /// Where the surface comes nearest to the edge there.
    pub uv: DVec2,
    /// Derivative of `uv` by `t`.
    pub d: DVec2,
}

impl UvSample {
    /// The Hermite cubic between two samples at parameter `t`.
    #[must_use]
    pub fn between(a: &Self, b: &Self, t: f64) -> DVec2 {
        let h = b.t - a.t;
        let s = (t - a.t) / h;
        let r = 1.0 - s;
        a.uv * (r * r * (1.0 + 2.0 * s))
            + b.uv * (s * s * (3.0 - 2.0 * s))
            + (a.d * (r * r * s) - b.d * (s * s * r)) * h
    }
}

impl UvCurve {
    /// The point at `t`. At a sample's own parameter this is the sample, to the bit.
    ///
    /// `hint` is the piece used last; neighbours in order of `t` make the search constant time.
    #[must_use]
    pub fn point(&self, t: f64, hint: &mut usize) -> DVec2 {
        match self {
            Self::Iso { axis: 0, at } => DVec2::new(*at, t),
            Self::Iso { at, .. } => DVec2::new(t, *at),
            Self::Hermite(samples) => {
                let last = samples.len() - 1;
                let mut i = (*hint).min(last - 1);
                while i > 0 && t < samples[i].t {
                    i -= 1;
                }
                while i + 1 < last && t >= samples[i + 1].t {
                    i += 1;
                }
                *hint = i;
                let (a, b) = (&samples[i], &samples[i + 1]);
                if t <= a.t {
                    a.uv
                } else if t >= b.t {
                    b.uv
                } else {
                    UvSample::between(a, b, t)
                }
            }
        }
    }
}
