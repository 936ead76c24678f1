//! A region and a grid of cut lines -> tiles with closed trim loops.
//! Loops are split where they cross the lines. Every line is cut at every crossing, and each stretch of it gets the
//! region's winding number there, counted once for both sides. A tile's loops are its strands and the stretches of its
//! border, each as often as the region winds around it. So they wind around every point of the tile as the whole
//! boundary does, even where that crosses or overlaps itself. The tiles on both sides share each stretch and its
//! points.

use super::grid::{Grid, LineCrossing};
use super::windings::Windings;
use crate::math::graph::Links;
use crate::math::solve::bisected;
use crate::prepare::regions::unroll::pole_sides;
use crate::prepare::report::Tangled;
use crate::prepare::uv::projector::Projector;
use crate::prepare::uv::uv_curve::UvSample;
use crate::prepare::uv::uv_loop::{Along, LoopPlace, Piece, Region, UvLoop};
use glam::DVec2;
use smallvec::{SmallVec, smallvec};
use std::collections::BTreeMap;

/// A point where borders meet edges or each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum GridNode {
    /// Lines `(u, v)` of the grid.
    Corner((usize, usize)),
    /// Index into [`Arrangement::crossings`].
    LineCrossing(usize),
    /// The end of a loop's stretch along a pole.
    Pole(usize),
}

/// A kept stretch of a line, or of a pole.
#[derive(Clone, Debug)]
pub(crate) struct Border {
    /// Which parameter is constant.
    pub(crate) axis: usize,
    /// Its value.
    pub(crate) at: f64,
    /// Range of the other parameter.
    pub(crate) range: (f64, f64),
    /// Nodes at the ends of the range.
    pub(crate) nodes: [GridNode; 2],
    /// The pole, where the line is one.
    pub(crate) pole: Option<usize>,
}

/// What a stretch of a tile's loop runs along.
#[derive(Clone, Debug)]
pub(crate) enum LoopStretch {
    /// A B-rep edge from parameter `from` to `to`, with the pcurve moved into the tile.
    Edge { edge: u32, from: f64, to: f64, samples: Vec<UvSample> },
    /// A border, at the coordinate `at` in this tile.
    Border { border: usize, reversed: bool, at: f64 },
}

/// A tile in natural parameters.
#[derive(Clone, Debug)]
pub(crate) struct ArrangedTile {
    pub(crate) min: DVec2,
    pub(crate) max: DVec2,
    pub(crate) loops: Vec<Vec<LoopStretch>>,
    /// Whether the region winds around a part of the tile's border more than once or backwards.
    pub(crate) layered: bool,
}

/// A face cut into tiles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Arrangement {
    pub(crate) tiles: Vec<ArrangedTile>,
    pub(crate) borders: Vec<Border>,
    pub(crate) crossings: Vec<LineCrossing>,
    /// Pole of each corner that lies on one. All other corners that borders use lie on the surface.
    pub(crate) pole_corners: BTreeMap<(usize, usize), usize>,
    /// Crossing of each corner that it lies exactly on. The corner takes its position.
    pub(crate) crossed_corners: BTreeMap<(usize, usize), usize>,
}

impl Arrangement {
    /// The only tile of a region that no line cuts, and that winds around nothing where its loops add nothing.
    fn uncut(region: &Region, grid: &Grid) -> Self {
        let mut out = Self::default();
        let loops: Vec<_> = region.loops.iter().map(|l| out.whole(l, DVec2::ZERO)).collect();
        if !loops.is_empty() {
            let [min, max] = [0, 1].map(|k| DVec2::new(grid.lines[0][k], grid.lines[1][k]));
            out.tiles.push(ArrangedTile { min, max, loops, layered: false });
        }
        out
    }

    /// A whole loop, moved by `by`.
    fn whole(&mut self, l: &UvLoop, by: DVec2) -> Vec<LoopStretch> {
        let stretch = |p: &Piece| {
            let [from, to] = p.ends().map(|s| s.t);
            self.stretch(p, from, to, by, [None; 2])
        };
        l.pieces.iter().map(stretch).collect()
    }

    fn stretch(&mut self, p: &Piece, from: f64, to: f64, by: DVec2, nodes: [Option<GridNode>; 2]) -> LoopStretch {
        match p.along {
            Along::Edge(edge) => {
                // Only the samples around the stretch: an edge may run through many tiles.
                let (low, high) = (from.min(to), from.max(to));
                let first = p.samples.partition_point(|s| s.t <= low).saturating_sub(1).min(p.samples.len() - 2);
                let last = p.samples.partition_point(|s| s.t < high) + 1;
                let around = &p.samples[first..last.clamp(first + 2, p.samples.len())];
                let samples = around.iter().map(|s| UvSample { uv: s.uv + by, ..*s }).collect();
                LoopStretch::Edge { edge, from, to, samples }
            }
            Along::Pole(pole) => {
                let d = p.samples[0].d;
                let axis = usize::from(d.x.abs() > d.y.abs());
                let run = 1 - axis;
                let at = p.samples[0].uv[axis] + by[axis];
                let ends = nodes.map(|n| n.unwrap_or(GridNode::Pole(pole)));
                let reversed = from > to;
                let (lo, hi) = (from.min(to) + by[run], from.max(to) + by[run]);
                let nodes = if reversed { [ends[1], ends[0]] } else { ends };
                self.borders.push(Border { axis, at, range: (lo, hi), nodes, pole: Some(pole) });
                LoopStretch::Border { border: self.borders.len() - 1, reversed, at }
            }
        }
    }
}

/// Parameter between `from` and `to` where coordinate `axis` of a Hermite piece is `x`; it is monotone there.
fn crossing_parameter(piece: [&UvSample; 2], axis: usize, (from, to): (f64, f64), x: f64) -> f64 {
    let at = |t: f64| UvSample::interpolate(piece[0], piece[1], t)[axis];
    let rising = at(to) > at(from);
    let [low, high] = bisected([from, to], 60, |t| (at(t) < x) == rising);
    0.5 * (low + high)
}

/// Crossings of a piece with the grid, in loop order.
fn piece_crossings(piece: &Piece, index: usize, grid: &Grid, out: &mut Vec<LineCrossing>) {
    let first = out.len();
    for w in piece.samples.windows(2) {
        for axis in 0..2 {
            if !grid.wraps[axis] && grid.count(axis) == 1 {
                continue;
            }
            // Monotone stretches between the samples and the turning points of the cubic.
            let mut stops: SmallVec<[f64; 4]> = smallvec![w[0].t];
            UvSample::extremes(&w[0], &w[1], axis, |t| stops.push(t));
            stops.push(w[1].t);
            stops.sort_by(f64::total_cmp);
            let at = |t: f64| UvSample::interpolate(&w[0], &w[1], t);
            for s in stops.windows(2) {
                let (a, b) = (at(s[0])[axis], at(s[1])[axis]);
                for (line, x) in grid.lines_passed(axis, a, b) {
                    let t = crossing_parameter([&w[0], &w[1]], axis, (s[0], s[1]), x);
                    let other = at(t)[1 - axis];
                    let (strip, by) = grid.reduce(1 - axis, grid.locate(1 - axis, other));
                    let ends = [strip, strip + 1].map(|k| grid.lines[1 - axis][k]);
                    out.push(LineCrossing {
                        along: piece.along,
                        t,
                        axis,
                        line,
                        other,
                        up: (b > a) != piece.reversed,
                        piece: index,
                        strip,
                        at: (other + by).clamp(ends[0], ends[1]),
                    });
                }
            }
        }
    }
    out[first..].sort_by(|a, b| a.t.total_cmp(&b.t));
    if piece.reversed {
        out[first..].reverse();
    }
}

/// A stretch of a loop inside one tile.
struct Strand {
    stretches: Vec<LoopStretch>,
    /// Side of the tile and crossing where it enters and leaves; `None` for a loop that stays inside.
    ports: Option<[(usize, usize); 2]>,
}

/// Maximum times that a region winds around the stretches of a tile's border: so often per stretch, and a constant.
/// Noise has winding numbers of a few. An edge that a loop lists thousands of times has as many, on as many stretches.
const LAPS_PER_STOP: usize = 16;
const FREE_LAPS: usize = 4096;

struct TileBuilder<'a> {
    grid: &'a Grid,
    /// By axis and line: the pole that it runs along.
    poles: [Vec<Option<usize>>; 2],
    out: Arrangement,
    keys: BTreeMap<(usize, usize, GridNode, GridNode), usize>,
    strands: Vec<Vec<Strand>>,
}

/// Cuts a region along a grid.
pub(crate) fn arrange(region: &Region, grid: &Grid, projector: &Projector<'_>) -> Result<Arrangement, Tangled> {
    if grid.wraps == [false; 2] && grid.count(0) == 1 && grid.count(1) == 1 && region.base == 0 {
        return Ok(Arrangement::uncut(region, grid));
    }
    let sides = pole_sides(region, projector);
    let poles = [0, 1].map(|axis| {
        let lines = &grid.lines[axis];
        let mut on_lines: Vec<Option<usize>> = vec![None; lines.len()];
        for (pole, p) in projector.poles.iter().enumerate().filter(|(_, p)| p.axis == axis) {
            // Lines through poles inside the region have their coordinate to the bit.
            lines.iter().zip(&mut on_lines).filter(|(x, _)| **x == p.at).for_each(|(_, on_line)| *on_line = Some(pole));
        }
        (on_lines[0], on_lines[lines.len() - 1]) = (sides[axis][0], sides[axis][1]);
        on_lines
    });
    let tiles = grid.count(0) * grid.count(1);
    let mut builder = TileBuilder {
        grid,
        poles,
        out: Arrangement::default(),
        keys: BTreeMap::new(),
        strands: (0..tiles).map(|_| Vec::new()).collect(),
    };
    for l in &region.loops {
        builder.split(l);
    }
    let windings = Windings::of(region, grid, &builder.out.crossings)?;
    builder.join(&windings)?;
    Ok(builder.out)
}

impl TileBuilder<'_> {
    fn split(&mut self, l: &UvLoop) {
        let pieces = &l.pieces;
        let first = self.out.crossings.len();
        for (k, piece) in pieces.iter().enumerate() {
            piece_crossings(piece, k, self.grid, &mut self.out.crossings);
        }
        let count = self.out.crossings.len() - first;
        if count == 0 {
            let uv = pieces[0].samples[0].uv + 1e-9 * (pieces[0].samples[1].uv - pieces[0].samples[0].uv);
            let (column, du) = self.grid.reduce(0, self.grid.locate(0, uv.x));
            let (row, dv) = self.grid.reduce(1, self.grid.locate(1, uv.y));
            let by = DVec2::new(du, dv);
            let stretches = self.out.whole(l, by);
            self.strands[row * self.grid.count(0) + column].push(Strand { stretches, ports: None });
            return;
        }
        let of_axis =
            |axis: usize| if self.grid.wraps[axis] { f64::from(l.winding[axis]) * self.grid.period(axis) } else { 0.0 };
        let period = DVec2::new(of_axis(0), of_axis(1));
        for k in 0..count {
            let (i, j) = (first + k, first + (k + 1) % count);
            let (a, b) = (self.out.crossings[i], self.out.crossings[j]);
            let mut strips = [0_i64; 2];
            strips[a.axis] = if a.up { a.line } else { a.line - 1 };
            strips[1 - a.axis] = self.grid.locate(1 - a.axis, a.other);
            let (column, du) = self.grid.reduce(0, strips[0]);
            let (row, dv) = self.grid.reduce(1, strips[1]);
            let by = DVec2::new(du, dv);
            let mut stretches = Vec::new();
            let places = [a, b].map(|crossing| LoopPlace { piece: crossing.piece, t: crossing.t });
            // The last strand passes the loop's start. A loop that goes round continues there one period further on.
            for passed in l.between(places, k + 1 == count) {
                let [from, to] = passed.range;
                let nodes = [
                    passed.is_first.then_some(GridNode::LineCrossing(i)),
                    passed.is_last.then_some(GridNode::LineCrossing(j)),
                ];
                let by = if passed.wrapped { by + period } else { by };
                if from != to {
                    stretches.push(self.out.stretch(passed.piece, from, to, by, nodes));
                }
            }
            let ports = [(a.side(true), i), (b.side(false), j)];
            self.strands[row * self.grid.count(0) + column].push(Strand { stretches, ports: Some(ports) });
        }
    }

    fn join(&mut self, windings: &Windings) -> Result<(), Tangled> {
        let (columns, rows) = (self.grid.count(0), self.grid.count(1));
        for row in 0..rows {
            for column in 0..columns {
                let corner = |i: usize, j: usize| DVec2::new(self.grid.lines[0][i], self.grid.lines[1][j]);
                let (min, max) = (corner(column, row), corner(column + 1, row + 1));
                let perimeter = self.perimeter(column, row, windings);
                let tangled = Tangled { at: 0.5 * (min + max) };
                let laps = perimeter.iter().map(|stop| stop.winding.unsigned_abs() as usize).sum::<usize>();
                if laps > LAPS_PER_STOP * perimeter.len() + FREE_LAPS {
                    return Err(tangled);
                }
                let stops: BTreeMap<(usize, usize), usize> =
                    perimeter.iter().enumerate().rev().filter_map(|(k, p)| Some((p.crossing?, k))).collect();
                let mut loops = Vec::new();
                // Arcs from stop to stop of the perimeter: first strands, then stretches of the perimeter.
                let mut arcs: Vec<[usize; 2]> = Vec::new();
                let mut inner: Vec<Vec<LoopStretch>> = Vec::new();
                for s in std::mem::take(&mut self.strands[row * columns + column]) {
                    let Some(ports) = s.ports else {
                        loops.push(s.stretches);
                        continue;
                    };
                    let [Some(&from), Some(&to)] = ports.map(|port| stops.get(&port)) else { return Err(tangled) };
                    arcs.push([from, to]);
                    inner.push(s.stretches);
                }
                for (k, stop) in perimeter.iter().enumerate() {
                    let next = (k + 1) % perimeter.len();
                    let ends = if stop.winding > 0 { [k, next] } else { [next, k] };
                    arcs.extend((0..stop.winding.unsigned_abs()).map(|_| ends));
                }
                let chains = Links::of(&arcs).closed().ok_or(tangled)?;
                for chain in chains {
                    let mut l = Vec::new();
                    for k in chain {
                        match inner.get_mut(k) {
                            Some(stretches) => l.append(stretches),
                            None => l.extend(self.border(column, row, &perimeter, arcs[k])),
                        }
                    }
                    if !l.is_empty() {
                        loops.push(l);
                    }
                }
                if !loops.is_empty() {
                    let layered = perimeter.iter().any(|p| !(0..=1).contains(&p.winding));
                    self.out.tiles.push(ArrangedTile { min, max, loops, layered });
                }
            }
        }
        Ok(())
    }

    /// A tile's corners and the crossings on its sides, counter-clockwise.
    fn perimeter(&mut self, column: usize, row: usize, windings: &Windings) -> Vec<Stop> {
        let mut out = Vec::new();
        for side in 0..4 {
            let LineSide { axis, line, strip, reversed } = LineSide::of(side, column, row);
            let key = self.grid.line_key(axis, line);
            let on_line = &windings.crossings[axis][key * self.grid.count(1 - axis) + strip];
            let ends = [strip, strip + 1].map(|k| self.grid.lines[1 - axis][k]);
            let corners = [0, 1].map(|end| self.grid.corner(axis, line, strip + end));
            let mut winding = windings.corners[&corners[0]];
            let mut stops =
                vec![Stop { side, at: ends[0], node: GridNode::Corner(corners[0]), winding, crossing: None }];
            for &k in on_line {
                let c = &self.out.crossings[k];
                winding += c.step();
                let node = GridNode::LineCrossing(k);
                stops.push(Stop { side, at: c.at, node, winding, crossing: Some((side, k)) });
                if let Some(end) = (0..2).find(|&end| c.at == ends[end]) {
                    self.out.crossed_corners.entry(corners[end]).or_insert(k);
                }
            }
            if reversed {
                // A stop has the winding number of the stretch after it. Reversed, that is the stretch before it.
                stops.push(Stop { side, at: ends[1], node: GridNode::Corner(corners[1]), winding, crossing: None });
                for k in (1..stops.len()).rev() {
                    stops[k].winding = stops[k - 1].winding;
                }
                stops.reverse();
                stops.pop();
            }
            out.extend(stops);
        }
        out
    }

    /// The border along one stretch of a perimeter. `None` at length 0, as between a corner and a crossing on it.
    fn border(&mut self, column: usize, row: usize, perimeter: &[Stop], ends: [usize; 2]) -> Option<LoopStretch> {
        // Along the perimeter or, where the region winds backwards, against it.
        let ahead = (ends[0] + 1) % perimeter.len() == ends[1];
        let [first, last] = if ahead { ends } else { [ends[1], ends[0]] }.map(|k| &perimeter[k]);
        let LineSide { axis, line, strip, reversed } = LineSide::of(first.side, column, row);
        let corner = self.grid.lines[1 - axis][strip + usize::from(!reversed)];
        let end = if last.side == first.side { last.at } else { corner };
        let (mut range, mut nodes) = ((first.at, end), [first.node, last.node]);
        if range.0 == range.1 {
            return None;
        }
        if reversed {
            range = (range.1, range.0);
            nodes.reverse();
        }
        let key = self.grid.line_key(axis, line);
        let at = self.grid.lines[axis][line];
        let pole = self.poles[axis][line];
        if let Some(pole) = pole {
            for node in nodes {
                if let GridNode::Corner(corner) = node {
                    self.out.pole_corners.insert(corner, pole);
                }
            }
        }
        let borders = &mut self.out.borders;
        let border = *self.keys.entry((axis, key, nodes[0], nodes[1])).or_insert_with(|| {
            borders.push(Border { axis, at: self.grid.lines[axis][key], range, nodes, pole });
            borders.len() - 1
        });
        Some(LoopStretch::Border { border, reversed: reversed == ahead, at })
    }
}

impl LineCrossing {
    /// The side of the tile through which its loop enters or leaves here: 0 bottom, 1 right, 2 top, 3 left.
    fn side(&self, enters: bool) -> usize {
        match (self.axis, self.up == enters) {
            (1, true) => 0,
            (0, false) => 1,
            (1, false) => 2,
            _ => 3,
        }
    }

    /// How the winding number changes along the line, in order of its parameter.
    pub(crate) fn step(&self) -> i32 {
        if (self.axis == 1) == self.up { -1 } else { 1 }
    }
}

/// One side of a tile: a stretch of a line, and whether counter-clockwise runs against it.
struct LineSide {
    axis: usize,
    line: usize,
    strip: usize,
    reversed: bool,
}

impl LineSide {
    fn of(side: usize, column: usize, row: usize) -> Self {
        let (axis, line, strip, reversed) =
            [(1, row, column, false), (0, column + 1, row, false), (1, row + 1, column, true), (0, column, row, true)]
                [side];
        Self { axis, line, strip, reversed }
    }
}

/// A corner of a tile or a crossing on its border, and the winding number of the region on the stretch that follows.
struct Stop {
    side: usize,
    /// The running coordinate.
    at: f64,
    node: GridNode,
    winding: i32,
    /// Side and index of the crossing, if it is one.
    crossing: Option<(usize, usize)>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Frame3, Surface};

    #[test]
    fn a_region_that_no_line_cuts_is_arranged_like_any_other() {
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (-0.0, 1.0)].map(|(u, v)| DVec2::new(u, v));
        let piece = |k: usize| {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            let reversed = k % 2 == 1;
            let [from, to] = if reversed { [b, a] } else { [a, b] };
            let samples = [(0.0, from), (0.5, 0.5 * (from + to)), (1.0, to)];
            let samples = samples.map(|(t, uv)| UvSample { t, uv, d: to - from }).to_vec();
            Piece { along: Along::Edge(k as u32), reversed, samples }
        };
        let l = UvLoop { pieces: (0..4).map(piece).collect(), winding: [0, 0] };
        let bounds = [(0.0, 2.0), (0.0, 1.0)];
        let region = Region { loops: vec![l], wraps: [false; 2], bounds, base: 0, unbounded: None };
        let grid = Grid { lines: [vec![0.0, 2.0], vec![0.0, 1.0]], wraps: [false; 2] };
        let surface = Surface::Plane { frame: Frame3::WORLD };
        let fast = arrange(&region, &grid, &Projector::new(&surface, 1e-6)).expect("no crossings");
        let mut builder = TileBuilder {
            grid: &grid,
            poles: [vec![None; 2], vec![None; 2]],
            out: Arrangement::default(),
            keys: BTreeMap::new(),
            strands: vec![Vec::new()],
        };
        region.loops.iter().for_each(|l| builder.split(l));
        let windings = Windings::of(&region, &grid, &builder.out.crossings).expect("no crossings");
        builder.join(&windings).expect("no crossings");
        assert_eq!(format!("{fast:?}"), format!("{:?}", builder.out));
        assert_eq!(fast.tiles.len(), 1);
    }
}
