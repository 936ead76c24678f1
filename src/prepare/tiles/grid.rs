//! Regions -> the grid of lines that cut them into tiles: seams where a region goes round, and lines that cap a tile's
//! cost.
//!
//! Cut lines may lie anywhere on a smooth surface, so they are placed where they cross the loops cleanly: far from
//! vertices and from places where a loop runs along them. They keep off creases, too: lattice lines run along these,
//! and a line that is almost one would leave a narrow row of cells between.

use crate::model::Surface;
use crate::prepare::uv::uv_loop::{Along, Region};
use glam::DVec3;
use std::cell::LazyCell;
use std::f64::consts::FRAC_PI_2;

/// Lines that cut a region, in natural parameters. First and last are its box; in a direction that wraps they are the
/// same line one period apart.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    pub(crate) lines: [Vec<f64>; 2],
    pub(crate) wraps: [bool; 2],
}

/// Where a loop crosses a line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LineCrossing {
    pub(crate) along: Along,
    pub(crate) t: f64,
    pub(crate) axis: usize,
    pub(crate) line: i64,
    pub(crate) other: f64,
    pub(crate) up: bool,
    pub(crate) piece: usize,
    /// Strip of the line, between two lines across it, and the coordinate along it, both within the first period.
    pub(crate) strip: usize,
    pub(crate) at: f64,
}

impl Grid {
    pub(crate) fn count(&self, axis: usize) -> usize {
        self.lines[axis].len() - 1
    }

    pub(crate) fn period(&self, axis: usize) -> f64 {
        self.lines[axis][self.count(axis)] - self.lines[axis][0]
    }

    /// Number of the strip that contains `x`, counted through all periods.
    pub(crate) fn locate(&self, axis: usize, x: f64) -> i64 {
        let n = self.count(axis);
        let turn = if self.wraps[axis] { ((x - self.lines[axis][0]) / self.period(axis)).floor() } else { 0.0 };
        let local = x - turn * self.period(axis);
        let strip = self.lines[axis][1..n].partition_point(|&l| l <= local);
        turn as i64 * n as i64 + strip as i64
    }

    /// Strip number within the period, and the shift that brings its points there.
    pub(crate) fn reduce(&self, axis: usize, strip: i64) -> (usize, f64) {
        let n = self.count(axis) as i64;
        if !self.wraps[axis] {
            return (strip.clamp(0, n - 1) as usize, 0.0);
        }
        (strip.rem_euclid(n) as usize, -(strip.div_euclid(n) as f64) * self.period(axis))
    }

    /// Lines after the lower of `a` and `b`, up to the higher, in order from `a` to `b`: number through all periods,
    /// and value.
    pub(crate) fn lines_passed(&self, axis: usize, a: f64, b: f64) -> Vec<(i64, f64)> {
        let (lo, hi) = (a.min(b), a.max(b));
        let n = self.count(axis) as i64;
        let mut out = Vec::new();
        let (mut first, mut last) = (self.locate(axis, lo), self.locate(axis, hi) + 1);
        if !self.wraps[axis] {
            (first, last) = (first.max(1), last.min(n - 1));
        }
        for k in first..=last {
            let (turn, i) = if self.wraps[axis] { (k.div_euclid(n), k.rem_euclid(n)) } else { (0, k) };
            let x = self.lines[axis][i as usize] + turn as f64 * self.period(axis);
            if lo < x && x <= hi {
                out.push((k, x));
            }
        }
        if a > b {
            out.reverse();
        }
        out
    }

    /// The corner where a line meets the line `across` of the other direction. Lines a period apart are the same.
    pub(crate) fn corner(&self, axis: usize, line: usize, across: usize) -> (usize, usize) {
        let (i, j) = if axis == 0 { (line, across) } else { (across, line) };
        (self.line_key(0, i), self.line_key(1, j))
    }

    pub(crate) fn line_key(&self, axis: usize, line: usize) -> usize {
        if self.wraps[axis] { line % self.count(axis) } else { line }
    }
}

/// Maximum spans (Bézier pieces or quarter turns) along one side of a tile. With more, a few heavy tiles decide a
/// frame's time. With fewer, there are more borders, which add triangles that the surface does not need.
const SPANS_PER_TILE: usize = 12;

/// A plane gets one tile per so many boundary samples. A tile's whole boundary is retriangulated when one edge changes.
/// Planes of few loops have larger tiles: a cut through an outline adds a point that the edge across a thin fillet does
/// not have.
const SAMPLES_PER_TILE: usize = 50;
const MOST_SAMPLES_PER_TILE: usize = 400;
/// A plane gets at most one tile per so many loops, unless samples exceed [`MOST_SAMPLES_PER_TILE`].
const LOOPS_PER_TILE: usize = 3;
/// A curved face gets at least one tile per so many loops. Where many holes are finer than the cells, a tile is
/// triangulated again with more and more of its cells until it is right, which takes the square of its holes.
const LOOPS_PER_CURVED_TILE: f64 = 100.0;

/// Maximum tiles along one side of a curved face. The largest real faces have 400 spans; more are noise. A
/// plane has about the square of this at most; a long strip has them in a row.
const TILES_PER_SIDE: usize = 64;

/// The grid of cut lines for a region.
pub(crate) fn grid_for(region: &Region, surface: &Surface) -> Grid {
    let mut lines = [Vec::new(), Vec::new()];
    let flat = matches!(surface, Surface::Plane { .. }).then(|| tiles_of_plane(region));
    let perforated = (region.loops.len() as f64 / LOOPS_PER_CURVED_TILE).sqrt().ceil() as usize;
    for (axis, lines) in lines.iter_mut().enumerate() {
        let (lo, hi) = region.bounds[axis];
        // Most faces are not cut.
        let avoid = LazyCell::new(|| Avoid::new(region, surface, axis));
        let (lo, hi) = if region.wraps[axis] {
            let c = avoid.best(lo, hi);
            (c, c + (hi - lo))
        } else {
            (lo, hi)
        };
        lines.push(lo);
        let curved = || spans(surface, axis, lo, hi).div_ceil(SPANS_PER_TILE).max(perforated).min(TILES_PER_SIDE);
        let tiles = flat.map_or_else(curved, |tiles| tiles[axis]);
        let width = (hi - lo) / tiles as f64;
        for k in 1..tiles {
            let x = lo + width * k as f64;
            lines.push(avoid.best(x - 0.2 * width, x + 0.2 * width));
        }
        lines.push(hi);
        lines.extend(poles_within(region, surface, axis, lo, hi));
        lines.sort_by(f64::total_cmp);
    }
    Grid { lines, wraps: region.wraps }
}

/// Number of tiles in u and in v for a region of a plane: nearly square ones, with about [`SAMPLES_PER_TILE`] samples
/// and [`LOOPS_PER_TILE`] loops each.
fn tiles_of_plane(region: &Region) -> [usize; 2] {
    let samples: usize = region.loops.iter().flat_map(|l| &l.pieces).map(|p| p.samples.len()).sum();
    let wanted = samples.div_ceil(SAMPLES_PER_TILE).min(region.loops.len() / LOOPS_PER_TILE);
    let wanted = wanted.max(samples.div_ceil(MOST_SAMPLES_PER_TILE));
    let tiles = wanted.min(TILES_PER_SIDE * TILES_PER_SIDE) as f64;
    let [width, height] = region.bounds.map(|(lo, hi)| hi - lo);
    // NaN for a region without extent takes one.
    let across = (tiles * width / height).sqrt().round().max(1.0).min(tiles.max(1.0));
    [across as usize, (tiles / across).round().max(1.0) as usize]
}

/// Poles inside a region, such as the apex of a cone that is kept on both sides. Their points coincide only if a line
/// runs along the pole. None if loops already run along poles.
fn poles_within(region: &Region, surface: &Surface, axis: usize, lo: f64, hi: f64) -> Vec<f64> {
    let loops_know = region.loops.iter().flat_map(|l| &l.pieces).any(|p| matches!(p.along, Along::Pole(_)));
    // Other surfaces have poles at the ends of their domains only.
    let inside = matches!(surface, Surface::Cone { .. } | Surface::Torus { .. });
    if !inside || region.wraps[axis] || loops_know {
        return Vec::new();
    }
    let margin = 1e-6 * (hi - lo);
    let poles = surface.poles().into_iter().filter(|p| p.axis == axis);
    poles.map(|p| p.at).filter(|at| at - lo > margin && hi - at > margin).collect()
}

/// Grids with the fewest cuts that open all wraps. Each grid has them at other places.
pub(crate) fn coarse_grids<'a>(region: &'a Region, surface: &'a Surface) -> impl Iterator<Item = Grid> + 'a {
    /// Places tried. A boundary that cannot be cut at any of them cannot be cut.
    const TRIES: usize = 6;
    let avoid = [0, 1].map(|axis| LazyCell::new(move || Avoid::new(region, surface, axis)));
    (0..TRIES).map(move |k| {
        let lines = [0, 1].map(|axis| {
            let (lo, hi) = region.bounds[axis];
            if !region.wraps[axis] {
                return vec![lo, hi];
            }
            // The cleanest line of all, then the cleanest line of each part.
            let share = |k: usize| lo + (hi - lo) * k as f64 / (TRIES - 1) as f64;
            let (from, to) = if k == 0 { (lo, hi) } else { (share(k - 1), share(k)) };
            let c = avoid[axis].best(from, to);
            vec![c, c + (hi - lo)]
        });
        Grid { lines, wraps: region.wraps }
    })
}

/// How many Bézier pieces (or quarter turns) lie between two parameters.
pub(super) fn spans(surface: &Surface, axis: usize, lo: f64, hi: f64) -> usize {
    if let Some((_, knots)) = surface.knots(axis) {
        return 1 + knots.windows(2).filter(|w| w[0] < w[1] && w[1] > lo && w[1] < hi).count();
    }
    match (surface, axis) {
        (Surface::Sphere { .. } | Surface::Torus { .. }, _)
        | (Surface::Cylinder { .. } | Surface::Cone { .. } | Surface::Revolution { .. }, 0) => {
            ((hi - lo) / FRAC_PI_2).ceil().max(1.0) as usize
        }
        _ => 1,
    }
}

/// Parameters where a surface has a crease: knots of full multiplicity at which control points are not in line.
fn creases(surface: &Surface, axis: usize) -> Vec<f64> {
    let Some((degree, knots)) = surface.knots(axis) else { return Vec::new() };
    kinks(knots, degree, |k| match surface {
        Surface::Nurbs(s) => {
            let (count_u, count_v) = (s.count_u(), s.count_v());
            let index = |k: usize, row: usize| if axis == 0 { k * count_v + row } else { row * count_v + k };
            let rows = if axis == 0 { count_v } else { count_u };
            (0..rows).any(|row| turns([k - 1, k, k + 1].map(|k| s.points[index(k, row)])))
        }
        Surface::Extrusion { curve, .. } | Surface::Revolution { curve, .. } => {
            turns([k - 1, k, k + 1].map(|k| curve.points[k]))
        }
        _ => false,
    })
}

/// Inner knots of full multiplicity at whose control point `turns` holds.
fn kinks(knots: &[f64], degree: usize, turns: impl Fn(usize) -> bool) -> Vec<f64> {
    let inner = &knots[degree + 1..knots.len() - degree - 1];
    let mut last = degree;
    let mut found = Vec::new();
    for equal in inner.chunk_by(|a, b| a == b) {
        last += equal.len();
        if equal.len() > degree || equal.len() == degree && turns(last - degree) {
            found.push(equal[0]);
        }
    }
    found
}

/// Whether three points are not in line, one after the other. Files write them with 5 to 15 digits.
fn turns([a, b, c]: [DVec3; 3]) -> bool {
    const BREAK: f64 = 1e-3;
    let (before, after) = (b - a, c - b);
    before.cross(after).length() > BREAK * before.dot(after)
}

/// A parameter, moved into the first turn if it has a period.
fn within(x: f64, period: Option<f64>) -> f64 {
    period.map_or(x, |period| x - period * (x / period).floor())
}

/// Coordinates at which a cut would meet a loop badly, and those where it would cross a hole.
struct Avoid {
    /// Ascending; where the region goes round, by their distance from the start of their turn, which comes first.
    points: Vec<(f64, f64)>,
    holes: Vec<(f64, f64)>,
    period: Option<f64>,
}

impl Avoid {
    fn new(region: &Region, surface: &Surface, axis: usize) -> Self {
        let mut points = creases(surface, axis);
        let mut holes = Vec::new();
        for l in &region.loops {
            let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
            for p in &l.pieces {
                points.push(p.start()[axis]);
                for w in p.samples.windows(2) {
                    lo = lo.min(w[0].uv[axis]).min(w[1].uv[axis]);
                    hi = hi.max(w[0].uv[axis]).max(w[1].uv[axis]);
                    // A turning point, or a stretch along a would-be line.
                    let steep = |d: glam::DVec2| d[axis].abs() > 0.02 * d[1 - axis].abs();
                    if !steep(w[0].d) || !steep(w[1].d) || w[0].d[axis] * w[1].d[axis] <= 0.0 {
                        points.extend([w[0].uv[axis], w[1].uv[axis]]);
                    }
                }
            }
            if l.winding == [0, 0] && region.wraps[axis] {
                holes.push((lo, hi));
            }
        }
        let period = region.wraps[axis].then(|| region.bounds[axis].1 - region.bounds[axis].0);
        let mut points: Vec<(f64, f64)> = points.into_iter().map(|p| (within(p, period), p)).collect();
        points.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        Self { points, holes, period }
    }

    /// The cleanest of 48 lines between `lo` and `hi`.
    fn best(&self, lo: f64, hi: f64) -> f64 {
        let n = 48;
        let candidates = (0..n).map(|k| lo + (hi - lo) * (k as f64 + 0.5) / f64::from(n));
        let score = |x: f64| {
            let reduce = |d: f64| self.period.map_or(d, |p| d - p * (d / p).round());
            // The nearest is one of the neighbours, of which those of the ends are at the other end.
            let (at, count) = (within(x, self.period), self.points.len().max(1));
            let next = self.points.partition_point(|(other, _)| *other < at);
            let near = [next, next + count - 1].into_iter().filter_map(|k| self.points.get(k % count));
            let distances = near.map(|(_, p)| reduce(x - p).abs());
            let clear = distances.fold(hi - lo, |clear, off| if off < clear { off } else { clear });
            let cuts = self.holes.iter().filter(|(a, b)| reduce(x - 0.5 * (a + b)).abs() <= 0.5 * (b - a)).count();
            // A clean crossing of a hole is better than a line that grazes a vertex.
            clear / (hi - lo) / (1.0 + cuts as f64)
        };
        let scored = candidates.map(|x| (x, score(x)));
        scored.max_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(lo, |(x, _)| x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Frame3;
    use crate::prepare::uv::uv_curve::UvSample;
    use crate::prepare::uv::uv_loop::{Piece, UvLoop};
    use glam::DVec2;

    #[test]
    fn a_long_strip_has_as_many_tiles_as_its_samples_need() {
        let (length, count) = (1e4, 50_000);
        let side = |v: f64| {
            let place = |k: u32| DVec2::new(length * f64::from(k) / f64::from(count), v);
            let samples = (0..count).map(|k| UvSample::along(0, place(k))).collect();
            Piece { along: Along::Edge(v as u32), reversed: v > 0.0, samples }
        };
        let outline = UvLoop { pieces: vec![side(0.0), side(1.0)], winding: [0, 0] };
        let bounds = [(0.0, length), (0.0, 1.0)];
        let region = Region { loops: vec![outline], wraps: [false; 2], bounds, base: 0, unbounded: None };
        let grid = grid_for(&region, &Surface::Plane { frame: Frame3::WORLD });
        assert_eq!([0, 1].map(|axis| grid.count(axis)), [2 * count as usize / MOST_SAMPLES_PER_TILE, 1]);
    }
}
