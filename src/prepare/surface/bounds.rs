//! Bézier patches and segments -> tables of derivative bounds and turning angles over sub-boxes, from which plans
//! derive lattice lines and tessellants.
//!
//! Lengths of derivatives are rigorous, by [`math::bounds`](crate::math::bounds) on each sub-box's own net. Their parts
//! along and across the normal, and the turning of the normal, are sampled, with margins from the differences between
//! samples.

use super::arc_bounds::{self, Strips};
use super::cuts::{self, Cut, SubNets};
use super::decompose::{BezierPatches, BezierSpline3};
use super::samples::{BOXES, Sampler, SurfaceSamples, sample_rows, tangent_turning};
use super::tables::{Bend, BoundingBox, BoxBounds, CurveBounds, StripBounds, SurfaceBounds};
use crate::math::bernstein;
use crate::math::bounds::{patch_bounds, segment_bounds};
use crate::math::lanes::larger;
use glam::DVec4;
use smallvec::{SmallVec, smallvec};
use std::cell::LazyCell;
use std::f64::consts::FRAC_PI_2;

/// A derivative below this share of the size (largest distance from the origin) is rounding and counts as zero.
const ROUNDING: f64 = 1e-12;

impl SurfaceBounds {
    /// Bounds all patches.
    ///
    /// Sub-boxes per patch and direction: 1 where the degree is 1, else 4; 2 with more than 16 patches or on rational
    /// nets of more than 6 points; 1 with more than 64 patches. More where the normal turns by more than a right angle
    /// within one, up to 16, and where weights differ, up to 64. Cost: a few µs per sub-box up to degree (3, 3).
    #[must_use]
    pub fn new(patches: &BezierPatches) -> Self {
        let mut sampler = Sampler::new(patches.degree_u, patches.degree_v, patches.rational);
        let mut cuts = [0, 1].map(|axis| cuts::of_surface(patches, axis));
        loop {
            let (bounds, asks) = Self::of_cuts(patches, &cuts, &mut sampler);
            let finer = [0, 1].map(|axis| cuts::halved(patches, axis, &cuts[axis], &asks[axis]));
            if (0..2).all(|axis| finer[axis].len() == cuts[axis].len()) {
                return bounds;
            }
            cuts = finer;
        }
    }

    /// The bounds of the sub-boxes between cuts in u and v, and which strips in u and in v are too long: those with
    /// boxes along which the normal turns by more than a right angle. Nobody knows where, and plans count `slide` in
    /// full there, and `lift` everywhere as much as at the bend.
    fn of_cuts(
        patches: &BezierPatches,
        [cuts_u, cuts_v]: &[Vec<Cut>; 2],
        sampler: &mut Sampler,
    ) -> (Self, [Vec<bool>; 2]) {
        let breaks_u = cuts::borders(cuts_u, &patches.breaks_u);
        let breaks_v = cuts::borders(cuts_v, &patches.breaks_v);
        let count = cuts_u.len() * cuts_v.len();
        let mut bounds =
            Self { breaks_u, breaks_v, cells: Vec::with_capacity(count), places: Vec::with_capacity(count) };
        let size = patches.control.iter().fold(0.0_f64, |most, c| most.max(c.truncate().length() / c.w));
        let keep = |x: f64| if x <= ROUNDING * size { 0.0 } else { x };
        let mut nets = SubNets::new(patches, [cuts_u, cuts_v]);
        let mut asks = [cuts_u, cuts_v].map(|cuts| vec![false; cuts.len()]);
        let mut bent = Vec::with_capacity(BOXES);
        for i in 0..cuts_u.len() {
            for j in 0..cuts_v.len() {
                let net = nets.at(i, j);
                bounds.places.push(BoundingBox::of_net(net));
                let local = patch_bounds(patches.degree_u + 1, net, patches.rational);
                let [u, v] = bounds.sides([i, j]);
                bounds.cells.push(BoxBounds { u: local.du / u, v: local.dv / v, ..BoxBounds::default() });
                let norms = [local.duu, local.duv, local.dvv].map(keep);
                if norms != [0.0; 3] {
                    sampler.set(bent.len(), net);
                    bent.push(([i, j], norms));
                }
                let is_last = (i + 1, j + 1) == (cuts_u.len(), cuts_v.len());
                if bent.len() == BOXES || is_last && !bent.is_empty() {
                    bounds.set_bends(&bent, sampler.sample(bent.len()), keep, &mut asks);
                    bent.clear();
                }
            }
        }
        (bounds, asks)
    }

    /// Fills in the second derivatives and the turning of sampled sub-boxes. `boxes`, by lane: place, and norms of the
    /// second derivatives by local parameters.
    fn set_bends(
        &mut self,
        boxes: &[([usize; 2], [f64; 3])],
        samples: &SurfaceSamples,
        keep: impl Fn(f64) -> f64,
        asks: &mut [Vec<bool>; 2],
    ) {
        let (most, turns) = (samples.most(), samples.turns());
        for (lane, &([i, j], norms)) in boxes.iter().enumerate() {
            let most = |k: usize| norms[k / 2].min(keep(most[k][lane]));
            let bend = |k: usize| Bend { norm: norms[k], lift: most(2 * k), slide: most(2 * k + 1) };
            let [turn_u, turn_v] = turns.map(|turn| turn[lane]);
            let far = [turn_u, turn_v].map(|turn| turn > FRAC_PI_2);
            if far.contains(&true) && (0..3).any(|k| bend(k).lift > 0.0) && !samples.fold_over(lane) {
                asks[0][i] |= far[0];
                asks[1][j] |= far[1];
            }
            let [u, v] = self.sides([i, j]);
            let columns = self.breaks_v.len() - 1;
            let cell = &mut self.cells[i * columns + j];
            *cell = BoxBounds {
                uu: bend(0).scaled(1.0 / (u * u)),
                uv: bend(1).scaled(1.0 / (u * v)),
                vv: bend(2).scaled(1.0 / (v * v)),
                turn_u,
                turn_v,
                ..*cell
            };
        }
    }

    /// Lengths of the sides of a sub-box.
    fn sides(&self, [i, j]: [usize; 2]) -> [f64; 2] {
        [self.breaks_u[i + 1] - self.breaks_u[i], self.breaks_v[j + 1] - self.breaks_v[j]]
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

    /// Whether every strip is straight. The curve may still have kinks between segments.
    #[must_use]
    pub fn is_straight(&self) -> bool {
        self.strips.iter().all(|s| s.second == 0.0)
    }

    /// Bounds all segments: lines in one strip and circular arcs in two, in closed form; others in up to four strips.
    ///
    /// A straight curve lies on its chords, however uneven its speed: its second derivative counts as 0.
    #[must_use]
    pub fn new(spline: &BezierSpline3) -> Self {
        let size =
            LazyCell::new(|| spline.control.iter().fold(0.0_f64, |most, c| most.max(c.truncate().length() / c.w)));
        let is_line = LazyCell::new(|| is_line(&spline.control, ROUNDING * *size));
        let mut out = Self { breaks: [spline.breaks[0]].as_slice().into(), strips: SmallVec::new() };
        let mut net = Vec::new();
        let rows = LazyCell::new(|| sample_rows(spline.degree));
        for (k, ends) in spline.breaks.windows(2).enumerate() {
            let known = arc_bounds::segment(spline.segment(k), ends[1] - ends[0]);
            let cuts = match &known {
                Some(_) => SmallVec::new(),
                None if *is_line => smallvec![Cut { piece: k, ends: (0.0, 1.0) }],
                None => cuts::of_segment(spline, k),
            };
            let strips = known.unwrap_or_else(|| {
                let strip = |cut: &Cut| {
                    net.clear();
                    net.extend_from_slice(spline.segment(k));
                    let (x0, x1) = cut.ends;
                    bernstein::restrict(&mut net, x0, x1);
                    let width = (ends[1] - ends[0]) * (x1 - x0);
                    let (first, second) = segment_bounds(&net);
                    let straight = *is_line || second <= ROUNDING * *size;
                    StripBounds {
                        first: first / width,
                        second: if straight { 0.0 } else { second / (width * width) },
                        turn: if straight { 0.0 } else { tangent_turning(&net, &rows) },
                        place: BoundingBox::of_net(&net),
                    }
                };
                cuts.iter().map(strip).collect::<Strips>()
            });
            let n = strips.len();
            if k == 0 {
                // Most curves have segments of one kind.
                out.breaks.reserve_exact(n * spline.segments());
                out.strips.reserve_exact(n * spline.segments());
            }
            let border = |i: usize| cuts.get(i).map_or(i as f64 / n as f64, |cut| cut.ends.0);
            out.breaks.extend((1..n).map(|i| ends[0] + (ends[1] - ends[0]) * border(i)));
            out.breaks.push(ends[1]);
            out.strips.extend(strips);
        }
        out
    }

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

/// Whether a curve's control points advance along the line from the first to the last of them, nearer to it than any
/// tolerance asks. Then the curve does, too. `rounding` is that of the points.
fn is_line(control: &[DVec4], rounding: f64) -> bool {
    /// Distance from the line, as a share of its length.
    const NEAR: f64 = 1e-9;
    let place = |c: &DVec4| c.truncate() / c.w;
    let [first, .., last] = control else { return false };
    let chord = place(last) - place(first);
    let Some(along) = chord.try_normalize() else { return false };
    let near = larger(NEAR * chord.length(), rounding);
    let mut farthest = 0.0;
    control.iter().all(|c| {
        let step = place(c) - place(first);
        let (before, here) = (farthest, step.dot(along));
        farthest = larger(here, before);
        c.w > 0.0 && here >= before - near && step.distance(along * here) <= near
    })
}
