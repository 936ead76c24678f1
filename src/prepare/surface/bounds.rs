//! Bézier patches and segments -> tables of derivative bounds and turning angles over sub-boxes, from which plans
//! derive lattice lines and tessellants.
//!
//! Lengths of derivatives are rigorous, by [`math::bounds`](crate::math::bounds) on each sub-box's own net. Their parts
//! along and across the normal, and the turning of the normal, are sampled, with margins from the differences between
//! samples.

use super::arc_bounds::{self, Strips};
use super::decompose::{BezierPatches, BezierSpline3};
use super::samples::{Sampler, sample_rows, tangent_turning};
use super::tables::{Bend, BoundingBox, BoxBounds, CurveBounds, StripBounds, SurfaceBounds};
use crate::math::bernstein;
use crate::math::bounds::{patch_bounds, segment_bounds};
use crate::math::lanes::widest;
use glam::DVec4;
use smallvec::SmallVec;
use std::cell::LazyCell;

/// A derivative below this share of the size (largest distance from the origin) is rounding and counts as zero.
const ROUNDING: f64 = 1e-12;

impl SurfaceBounds {
    /// Bounds all patches.
    ///
    /// Sub-boxes per patch and direction: 1 where the degree is 1, else 4; 2 or 1 on surfaces with many patches or
    /// large rational nets. Cost: a few µs per sub-box up to degree (3, 3).
    #[must_use]
    pub fn new(patches: &BezierPatches) -> Self {
        let (count_u, count_v) = patches.counts();
        let cost = if patches.rational { (patches.degree_u + 1) * (patches.degree_v + 1) } else { 1 };
        let parts_u = parts(patches.degree_u, count_u, cost);
        let parts_v = parts(patches.degree_v, count_v, cost);
        let breaks_u = subdivided(&patches.breaks_u, parts_u);
        let breaks_v = subdivided(&patches.breaks_v, parts_v);
        let size = patches.control.iter().fold(0.0_f64, |most, c| most.max(c.truncate().length() / c.w));
        let mut sampler = Sampler::new(patches.degree_u, patches.degree_v, patches.rational);
        let mut nets = SubNets::new(patches, [parts_u, parts_v]);
        let columns = breaks_v.len() - 1;
        let mut cells = Vec::with_capacity((breaks_u.len() - 1) * columns);
        let mut places = Vec::with_capacity(cells.capacity());
        for i in 0..breaks_u.len() - 1 {
            for j in 0..columns {
                let net = nets.at(i, j);
                places.push(BoundingBox::of_net(net));
                let local = patch_bounds(patches.degree_u + 1, net, patches.rational);
                let (u, v) = (breaks_u[i + 1] - breaks_u[i], breaks_v[j + 1] - breaks_v[j]);
                let keep = |x: f64| if x <= ROUNDING * size { 0.0 } else { x };
                let norms = [local.duu, local.duv, local.dvv].map(keep);
                if norms == [0.0; 3] {
                    cells.push(BoxBounds { u: local.du / u, v: local.dv / v, ..BoxBounds::default() });
                    continue;
                }
                let samples = sampler.sample(net);
                let most = samples.most();
                let part = |k: usize, part: usize| norms[k].min(keep(most[2 * k + part]));
                let bend = |k: usize| Bend { norm: norms[k], lift: part(k, 0), slide: part(k, 1) };
                let [turn_u, turn_v] = samples.turns();
                cells.push(BoxBounds {
                    uu: bend(0).scaled(1.0 / (u * u)),
                    uv: bend(1).scaled(1.0 / (u * v)),
                    vv: bend(2).scaled(1.0 / (v * v)),
                    u: local.du / u,
                    v: local.dv / v,
                    turn_u,
                    turn_v,
                });
            }
        }
        Self { breaks_u, breaks_v, cells, places }
    }

    /// Whether it is one parallelogram, with even parameters.
    #[must_use]
    pub(crate) fn is_affine(&self) -> bool {
        matches!(self.cells[..], [cell] if [cell.uu, cell.uv, cell.vv].iter().all(|bend| bend.norm == 0.0))
    }

    /// The bounds of sub-box (i, j).
    #[must_use]
    pub fn cell(&self, i: usize, j: usize) -> BoxBounds {
        self.cells[i * (self.breaks_v.len() - 1) + j]
    }
}

impl CurveBounds {
    /// The bounds of a curve over `range` that is a single point. Its bounding box is empty.
    #[must_use]
    pub fn none(range: (f64, f64)) -> Self {
        Self { breaks: [range.0, range.1].into(), strips: [StripBounds::default()].into() }
    }

    /// The bounding box of each strip in space.
    pub(crate) fn places(&self) -> impl Iterator<Item = &BoundingBox> + Clone {
        self.strips.iter().map(|strip| &strip.place)
    }

    /// Whether every strip is straight and of constant speed. The curve may still have kinks between segments.
    #[must_use]
    pub fn is_straight(&self) -> bool {
        self.strips.iter().all(|s| s.second == 0.0)
    }

    /// Bounds all segments: lines in one strip and circular arcs in two, in closed form; others in up to four strips.
    #[must_use]
    pub fn new(spline: &BezierSpline3) -> Self {
        let parts = parts(spline.degree, spline.segments(), 1);
        let size =
            LazyCell::new(|| spline.control.iter().fold(0.0_f64, |most, c| most.max(c.truncate().length() / c.w)));
        let mut out = Self { breaks: [spline.breaks[0]].as_slice().into(), strips: SmallVec::new() };
        let mut net = Vec::new();
        let rows = LazyCell::new(|| sample_rows(spline.degree));
        for (k, ends) in spline.breaks.windows(2).enumerate() {
            let known = arc_bounds::segment(spline.segment(k), ends[1] - ends[0]);
            let strips = known.unwrap_or_else(|| {
                let width = (ends[1] - ends[0]) / parts as f64;
                let strip = |i| {
                    net.clear();
                    net.extend_from_slice(spline.segment(k));
                    let (x0, x1) = share(i, parts);
                    bernstein::restrict(&mut net, x0, x1);
                    let (first, second) = segment_bounds(&net);
                    let straight = second <= ROUNDING * *size;
                    StripBounds {
                        first: first / width,
                        second: if straight { 0.0 } else { second / (width * width) },
                        turn: if straight { 0.0 } else { tangent_turning(&net, &rows) },
                        place: BoundingBox::of_net(&net),
                    }
                };
                (0..parts).map(strip).collect::<Strips>()
            });
            let n = strips.len();
            if k == 0 {
                // Most curves have segments of one kind.
                out.breaks.reserve_exact(n * spline.segments());
                out.strips.reserve_exact(n * spline.segments());
            }
            out.breaks.extend((1..n).map(|i| ends[0] + (ends[1] - ends[0]) * i as f64 / n as f64));
            out.breaks.push(ends[1]);
            out.strips.extend(strips);
        }
        out
    }
}

impl CurveBounds {
    /// Merges neighbouring strips that need nearly the same density. Every plan visits every strip, and some curves are
    /// cut much finer than they bend.
    #[must_use]
    pub(crate) fn merged(&self) -> Self {
        /// Largest ratio of bounds within a merged strip. Densities go with the square root of bounds.
        const ALIKE: f64 = 1.2;
        /// Differences below this share of the curve's largest bound are ignored.
        const NOTHING: f64 = 0.01;
        /// At most this many strips become one, or 1/`PART` of the curve's strips if that is more.
        const FEW: usize = 16;
        const PART: usize = 4;
        // First and second derivative and turning, by the parameter.
        let rates = |k: usize| {
            let StripBounds { first, second, turn, .. } = self.strips[k];
            [first, second, turn / (self.breaks[k + 1] - self.breaks[k])]
        };
        let count = self.strips.len();
        let most = (0..count).map(rates).fold([0.0; 3], |m, r| [0, 1, 2].map(|i| f64::max(m[i], r[i])));
        let limit = FEW.max(count / PART);
        let mut out = Self { breaks: [self.breaks[0]].as_slice().into(), strips: SmallVec::new() };
        let mut from = 0;
        while from < count {
            let (mut low, mut high, mut place) = (rates(from), rates(from), self.strips[from].place);
            let mut to = from + 1;
            while to < count && to - from < limit {
                let next = rates(to);
                let (l, h) = ([0, 1, 2].map(|i| low[i].min(next[i])), [0, 1, 2].map(|i| high[i].max(next[i])));
                if (0..3).any(|i| h[i] > ALIKE * l[i] + NOTHING * most[i]) {
                    break;
                }
                (low, high, place) = (l, h, place.with(&self.strips[to].place));
                to += 1;
            }
            let [first, second, turn] = high;
            out.strips.push(StripBounds { first, second, turn: turn * (self.breaks[to] - self.breaks[from]), place });
            out.breaks.push(self.breaks[to]);
            from = to;
        }
        out
    }
}

/// Sub-boxes per piece and direction. More if there are few pieces, because one may then fill the screen. Fewer for
/// rational nets of many control points: `cost` is their number, and the work per sub-box goes with its square.
fn parts(degree: usize, pieces: usize, cost: usize) -> usize {
    match (degree, pieces, cost) {
        (1, ..) => 1,
        (_, 0..=16, 0..=6) => 4,
        (_, 0..=64, 0..=20) => 2,
        _ => 1,
    }
}

/// Part `i` of `n` of [0, 1].
fn share(i: usize, n: usize) -> (f64, f64) {
    (i as f64 / n as f64, (i + 1) as f64 / n as f64)
}

/// Cuts every interval into `parts` equal ones.
fn subdivided(breaks: &[f64], parts: usize) -> Vec<f64> {
    let inner = |ends: &[f64]| {
        let (a, b) = (ends[0], ends[1]);
        (0..parts).map(move |k| if k == 0 { a } else { a + (b - a) * k as f64 / parts as f64 })
    };
    let mut all: Vec<f64> = breaks.windows(2).flat_map(inner).collect();
    all.extend(breaks.last());
    all
}

/// The nets of all sub-boxes of a surface.
struct SubNets<'a> {
    patches: &'a BezierPatches,
    /// Sub-boxes per patch in u and v.
    parts: [usize; 2],
    /// A row of patches, and its nets cut along v.
    row: Option<usize>,
    cut: Vec<DVec4>,
    net: Vec<DVec4>,
}

impl<'a> SubNets<'a> {
    fn new(patches: &'a BezierPatches, parts: [usize; 2]) -> Self {
        Self { patches, parts, row: None, cut: Vec::new(), net: Vec::new() }
    }

    /// The net of sub-box (i, j), u-major. Rows in turn are cheap: sub-boxes of a row of patches share the cuts along v.
    fn at(&mut self, i: usize, j: usize) -> &[DVec4] {
        let Self { patches, parts: [parts_u, parts_v], row, cut, net } = self;
        let (nu, nv) = (patches.degree_u + 1, patches.degree_v + 1);
        widest(
            #[inline(always)]
            || {
                if row.replace(i / *parts_u) != Some(i / *parts_u) {
                    cut.clear();
                    for j in 0..patches.counts().1 * *parts_v {
                        let first = cut.len();
                        cut.extend_from_slice(patches.patch(i / *parts_u, j / *parts_v));
                        let (y0, y1) = share(j % *parts_v, *parts_v);
                        cut[first..].chunks_exact_mut(nv).for_each(|line| bernstein::restrict_rows(line, 1, y0, y1));
                    }
                }
                net.clear();
                net.extend_from_slice(&cut[j * nu * nv..(j + 1) * nu * nv]);
                let (x0, x1) = share(i % *parts_u, *parts_u);
                bernstein::restrict_rows(net, nv, x0, x1);
            },
        );
        net
    }
}
