//! placeholder until the bounds branch lands
use super::{BezierPatches, BezierSpline3};
#[derive(Clone, Copy, Debug, Default)]
pub struct BoxBounds {
    pub uu: f64,
    pub uv: f64,
    pub vv: f64,
    pub u: f64,
    pub v: f64,
    pub turn_u: f64,
    pub turn_v: f64,
}
#[derive(Clone, Debug, Default)]
pub struct SurfaceBounds {
    pub breaks_u: Vec<f64>,
    pub breaks_v: Vec<f64>,
    pub cells: Vec<BoxBounds>,
}
#[derive(Clone, Copy, Debug, Default)]
pub struct StripBounds {
    pub first: f64,
    pub second: f64,
    pub turn: f64,
}
#[derive(Clone, Debug, Default)]
pub struct CurveBounds {
    pub breaks: Vec<f64>,
    pub strips: Vec<StripBounds>,
}
impl CurveBounds {
    pub fn none(r: (f64, f64)) -> Self {
        Self { breaks: vec![r.0, r.1], strips: vec![StripBounds::default()] }
    }
    pub fn is_straight(&self) -> bool {
        self.strips.iter().all(|s| s.second == 0.0)
    }
    pub fn new(c: &BezierSpline3) -> Self {
        let mut out = Self::default();
        let n = 4;
        for w in c.breaks.windows(2) {
            for k in 0..n {
                let a = w[0] + (w[1] - w[0]) * k as f64 / n as f64;
                let b = w[0] + (w[1] - w[0]) * (k + 1) as f64 / n as f64;
                out.breaks.push(a);
                let mut s = StripBounds::default();
                let mut last: Option<glam::DVec3> = None;
                for i in 0..=4 {
                    let t = a + (b - a) * (i as f64 * 0.2498 + 0.0004);
                    let d = c.derivatives(t);
                    s.first = s.first.max(d.d1.length());
                    s.second = s.second.max(d.d2.length());
                    let t = d.d1.normalize_or_zero();
                    if let Some(l) = last {
                        s.turn += l.angle_between(t).max(0.0);
                    }
                    last = Some(t);
                }
                if s.second < 1e-10 * s.first / (b - a) {
                    s.second = 0.0;
                    s.turn = 0.0;
                }
                out.strips.push(s);
            }
        }
        out.breaks.push(c.breaks[c.breaks.len() - 1]);
        out
    }
}
impl SurfaceBounds {
    pub fn new(p: &BezierPatches) -> Self {
        let split = |b: &[f64]| {
            let mut o = vec![];
            for w in b.windows(2) {
                o.push(w[0]);
                o.push(0.5 * (w[0] + w[1]));
            }
            o.push(b[b.len() - 1]);
            o
        };
        let (bu, bv) = (split(&p.breaks_u), split(&p.breaks_v));
        let mut cells = vec![];
        for i in 0..bu.len() - 1 {
            for j in 0..bv.len() - 1 {
                let mut b = BoxBounds::default();
                let mut n = [[glam::DVec3::ZERO; 4]; 4];
                for x in 0..4 {
                    for y in 0..4 {
                        let u = bu[i] + (bu[i + 1] - bu[i]) * (0.001 + 0.998 * x as f64 / 3.0);
                        let v = bv[j] + (bv[j + 1] - bv[j]) * (0.001 + 0.998 * y as f64 / 3.0);
                        let d = p.derivatives(u, v);
                        b.uu = b.uu.max(d.duu.length());
                        b.uv = b.uv.max(d.duv.length());
                        b.vv = b.vv.max(d.dvv.length());
                        b.u = b.u.max(d.du.length());
                        b.v = b.v.max(d.dv.length());
                        n[x][y] = d.du.cross(d.dv).normalize_or_zero();
                    }
                }
                for x in 0..4 {
                    for y in 0..4 {
                        for z in 0..4 {
                            b.turn_u = b.turn_u.max(n[x][y].angle_between(n[z][y]));
                            b.turn_v = b.turn_v.max(n[y][x].angle_between(n[y][z]));
                        }
                    }
                }
                let wu = bu[i + 1] - bu[i];
                let wv = bv[j + 1] - bv[j];
                let size = b.u * wu + b.v * wv;
                if b.uu * wu * wu < 1e-10 * size {
                    b.uu = 0.0
                }
                if b.uv * wu * wv < 1e-10 * size {
                    b.uv = 0.0
                }
                if b.vv * wv * wv < 1e-10 * size {
                    b.vv = 0.0
                }
                if !b.turn_u.is_finite() || b.turn_u < 1e-6 {
                    b.turn_u = 0.0
                }
                if !b.turn_v.is_finite() || b.turn_v < 1e-6 {
                    b.turn_v = 0.0
                }
                cells.push(b);
            }
        }
        Self { breaks_u: bu, breaks_v: bv, cells }
    }
}
