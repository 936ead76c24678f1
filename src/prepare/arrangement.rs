//! A region and a grid of cut lines to tiles with closed trim loops.
//!
//! Loops are split where they cross the lines; inside each tile the strands are joined again along the tile's border,
//! counter-clockwise from where a strand leaves to where the next one enters. Every stretch of a line that is kept is
//! made once and used by the tiles on both sides, so they share its points.

use super::UvSample;
use super::pcurve::Projector;
use super::region::{Along, Piece, Region, UvLoop, pole_sides};
use glam::DVec2;
use std::collections::BTreeMap;
use std::fmt;

/// Lines that cut a region, in natural parameters. First and last are its box; in a direction that wraps they are the
/// same line one period apart.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) lines: [Vec<f64>; 2],
    pub(super) wraps: [bool; 2],
}

/// A point where borders meet edges or each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Node {
    /// Lines `(u, v)` of the grid.
    Corner(usize, usize),
    /// The crossing of that number in [`Arranged::crossings`].
    Crossing(usize),
    /// The end of a pole stretch of a loop: nothing but the pole.
    Pole(usize),
}

/// Where a loop crosses a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub(super) along: Along,
    pub(super) t: f64,
    axis: usize,
    line: i64,
    other: f64,
    up: bool,
    piece: usize,
}

/// A kept stretch of a line, or of a pole.
#[derive(Clone, Debug)]
pub(super) struct Border {
    /// Which parameter is constant.
    pub(super) axis: usize,
    /// Its value.
    pub(super) at: f64,
    /// Range of the other parameter.
    pub(super) range: (f64, f64),
    /// What stands at the ends of the range.
    pub(super) nodes: [Node; 2],
    /// The pole, where the line is one.
    pub(super) pole: Option<usize>,
}

/// What a stretch of a tile's loop runs along.
#[derive(Clone, Debug)]
pub(super) enum Stretch {
    /// A B-rep edge from parameter `from` to `to`, with the pcurve moved into the tile.
    Edge { edge: u32, from: f64, to: f64, samples: Vec<UvSample> },
    /// A border, seen at `at` by this tile.
    Border { border: usize, reversed: bool, at: f64 },
}

/// A tile in natural parameters.
#[derive(Clone, Debug)]
pub(super) struct ArrangedTile {
    pub(super) min: DVec2,
    pub(super) max: DVec2,
    pub(super) loops: Vec<Vec<Stretch>>,
}

/// A face cut into tiles.
#[derive(Clone, Debug, Default)]
pub(super) struct Arranged {
    pub(super) tiles: Vec<ArrangedTile>,
    pub(super) borders: Vec<Border>,
    pub(super) crossings: Vec<Crossing>,
    /// Position of each grid corner that a border uses is the surface's, except on poles.
    pub(super) pole_corners: BTreeMap<(usize, usize), usize>,
}

/// The strands of a tile do not alternate along its border: the loops cross each other or a line unseen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tangled {
    pub(super) column: usize,
    pub(super) row: usize,
}

impl fmt::Display for Tangled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the boundary cannot be cut at tile ({}, {})", self.column, self.row)
    }
}

impl Grid {
    fn count(&self, axis: usize) -> usize {
        self.lines[axis].len() - 1
    }

    fn period(&self, axis: usize) -> f64 {
        self.lines[axis][self.count(axis)] - self.lines[axis][0]
    }

    /// The strip that holds `x`, counted through all periods.
    fn locate(&self, axis: usize, x: f64) -> i64 {
        let n = self.count(axis);
        let turn = if self.wraps[axis] { ((x - self.lines[axis][0]) / self.period(axis)).floor() } else { 0.0 };
        let local = x - turn * self.period(axis);
        let strip = self.lines[axis][1..n].partition_point(|&l| l <= local);
        turn as i64 * n as i64 + strip as i64
    }

    /// Strip number within the period, and the shift that brings its points there.
    fn reduce(&self, axis: usize, strip: i64) -> (usize, f64) {
        let n = self.count(axis) as i64;
        if !self.wraps[axis] {
            return (strip.clamp(0, n - 1) as usize, 0.0);
        }
        (strip.rem_euclid(n) as usize, -(strip.div_euclid(n) as f64) * self.period(axis))
    }

    /// Lines strictly between `a` and `b`, in order from `a` to `b`: number through all periods, and value.
    fn between(&self, axis: usize, a: f64, b: f64) -> Vec<(i64, f64)> {
        let (lo, hi) = (a.min(b), a.max(b));
        let n = self.count(axis) as i64;
        let mut out = Vec::new();
        let (first, last) =
            if self.wraps[axis] { (self.locate(axis, lo), self.locate(axis, hi) + 1) } else { (1, n - 1) };
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

    fn line_key(&self, axis: usize, line: usize) -> usize {
        if self.wraps[axis] { line % self.count(axis) } else { line }
    }
}

/// Parameter between `from` and `to` where coordinate `axis` of a Hermite piece is `x`; it is monotone there.
fn crossing_parameter(piece: [&UvSample; 2], axis: usize, (from, to): (f64, f64), x: f64) -> f64 {
    let at = |t: f64| UvSample::between(piece[0], piece[1], t)[axis];
    let (mut lo, mut hi) = (from, to);
    let rising = at(hi) > at(lo);
    for _ in 0..60 {
        let mid = 0.5 * (lo + hi);
        if mid <= lo || mid >= hi {
            break;
        }
        if (at(mid) < x) == rising {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    0.5 * (lo + hi)
}

/// Crossings of a piece with the grid, in loop order.
fn piece_crossings(piece: &Piece, index: usize, grid: &Grid, out: &mut Vec<Crossing>) {
    let first = out.len();
    for w in piece.samples.windows(2) {
        for axis in 0..2 {
            if !grid.wraps[axis] && grid.count(axis) == 1 {
                continue;
            }
            // Monotone stretches between the samples and the turning points of the cubic.
            let mut stops = vec![w[0].t];
            stops.extend(UvSample::extremes(&w[0], &w[1], axis));
            stops.push(w[1].t);
            stops.sort_by(f64::total_cmp);
            let at = |t: f64| UvSample::between(&w[0], &w[1], t);
            for s in stops.windows(2) {
                let (a, b) = (at(s[0])[axis], at(s[1])[axis]);
                for (line, x) in grid.between(axis, a, b) {
                    let t = crossing_parameter([&w[0], &w[1]], axis, (s[0], s[1]), x);
                    let other = at(t)[1 - axis];
                    out.push(Crossing {
                        along: piece.along,
                        t,
                        axis,
                        line,
                        other,
                        up: (b > a) != piece.reversed,
                        piece: index,
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
    stretches: Vec<Stretch>,
    /// Perimeter position and crossing where it enters and leaves; none for a loop that stays inside.
    ports: Option<[(f64, usize); 2]>,
}

struct Builder<'a> {
    grid: &'a Grid,
    pole_sides: [[Option<usize>; 2]; 2],
    out: Arranged,
    keys: BTreeMap<(usize, usize, Node, Node), usize>,
    strands: Vec<Vec<Strand>>,
}

/// Cuts a region along a grid.
pub(super) fn arrange(region: &Region, grid: &Grid, projector: &Projector<'_>) -> Result<Arranged, Tangled> {
    let sides = pole_sides(region, projector).map(|s| s.map(|p| p.map(|(k, _)| k)));
    let tiles = grid.count(0) * grid.count(1);
    let mut builder = Builder {
        grid,
        pole_sides: sides,
        out: Arranged::default(),
        keys: BTreeMap::new(),
        strands: (0..tiles).map(|_| Vec::new()).collect(),
    };
    for l in &region.loops {
        builder.split(l);
    }
    builder.join(region.corners_kept)?;
    Ok(builder.out)
}

impl Builder<'_> {
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
            let stretches = pieces
                .iter()
                .map(|p| {
                    let (a, b) = (p.samples[0].t, p.samples[p.samples.len() - 1].t);
                    let (from, to) = if p.reversed { (b, a) } else { (a, b) };
                    self.stretch(p, from, to, by, [None; 2])
                })
                .collect();
            self.strands[row * self.grid.count(0) + column].push(Strand { stretches, ports: None });
            return;
        }
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
            let mut index = a.piece;
            let mut from = a.t;
            // The last strand passes the loop's start, where a loop that goes round continues a period further on.
            let mut by_now = by;
            let mut to_wrap = k + 1 == count;
            loop {
                let p = &pieces[index];
                let last = index == b.piece && !to_wrap;
                let end = p.samples[if p.reversed { 0 } else { p.samples.len() - 1 }].t;
                let to = if last { b.t } else { end };
                let nodes = [
                    (from == a.t && index == a.piece && stretches.is_empty()).then_some(Node::Crossing(i)),
                    last.then_some(Node::Crossing(j)),
                ];
                if from != to {
                    let s = self.stretch(p, from, to, by_now, nodes);
                    stretches.push(s);
                }
                if last {
                    break;
                }
                index += 1;
                if index == pieces.len() {
                    index = 0;
                    to_wrap = false;
                    for axis in 0..2 {
                        if self.grid.wraps[axis] {
                            by_now[axis] += f64::from(l.winding[axis]) * self.grid.period(axis);
                        }
                    }
                }
                let p = &pieces[index];
                from = p.samples[if p.reversed { p.samples.len() - 1 } else { 0 }].t;
            }
            let enter = self.port(&a, column, row, by, true);
            let leave = self.port(&b, column, row, by, false);
            let strand = Strand { stretches, ports: Some([(enter, i), (leave, j)]) };
            self.strands[row * self.grid.count(0) + column].push(strand);
        }
    }

    /// Perimeter position of a crossing seen from the tile it enters or leaves.
    fn port(&self, c: &Crossing, column: usize, row: usize, by: DVec2, enters: bool) -> f64 {
        let low_side = c.up == enters;
        let strip = if c.axis == 0 { row } else { column };
        let other = 1 - c.axis;
        let (lo, hi) = (self.grid.lines[other][strip], self.grid.lines[other][strip + 1]);
        // The crossing's other coordinate may be given in another period than the tile's.
        let mut x = c.other + by[other];
        if self.grid.wraps[other] {
            let p = self.grid.period(other);
            x += p * ((0.5 * (lo + hi) - x) / p).round();
        }
        let f = ((x - lo) / (hi - lo)).clamp(0.0, 1.0);
        match (c.axis, low_side) {
            (1, true) => f,
            (0, false) => 1.0 + f,
            (1, false) => 3.0 - f,
            _ => 4.0 - f,
        }
    }

    fn stretch(&mut self, p: &Piece, from: f64, to: f64, by: DVec2, nodes: [Option<Node>; 2]) -> Stretch {
        match p.along {
            Along::Edge(edge) => {
                let samples = p.samples.iter().map(|s| UvSample { uv: s.uv + by, ..*s }).collect();
                Stretch::Edge { edge, from, to, samples }
            }
            Along::Pole(pole) => {
                let d = p.samples[0].d;
                let axis = usize::from(d.x.abs() > d.y.abs());
                let run = 1 - axis;
                let at = p.samples[0].uv[axis] + by[axis];
                let ends = nodes.map(|n| n.unwrap_or(Node::Pole(pole)));
                let reversed = from > to;
                let (lo, hi) = (from.min(to) + by[run], from.max(to) + by[run]);
                let nodes = if reversed { [ends[1], ends[0]] } else { ends };
                self.out.borders.push(Border { axis, at, range: (lo, hi), nodes, pole: Some(pole) });
                Stretch::Border { border: self.out.borders.len() - 1, reversed, at }
            }
        }
    }

    fn join(&mut self, corners_kept: bool) -> Result<(), Tangled> {
        let (columns, rows) = (self.grid.count(0), self.grid.count(1));
        let kept = self.whole_tiles(corners_kept);
        for row in 0..rows {
            for column in 0..columns {
                let tangled = Tangled { column, row };
                let mut loops = Vec::new();
                let mut through = Vec::new();
                for s in std::mem::take(&mut self.strands[row * columns + column]) {
                    match s.ports {
                        None => loops.push(s.stretches),
                        Some(ports) => through.push((Some(s.stretches), ports)),
                    }
                }
                if through.is_empty() && kept[row * columns + column] {
                    let mut border = Vec::new();
                    self.walk(column, row, (0.0, None), (4.0, None), &mut border);
                    loops.push(border);
                }
                let ports = alternating(through.iter().map(|t| t.1)).ok_or(tangled)?;
                for start in 0..through.len() {
                    let mut chain = Vec::new();
                    let mut at = start;
                    while let Some(stretches) = through[at].0.take() {
                        chain.extend(stretches);
                        let leave = through[at].1[1];
                        let k = ports.iter().position(|q| !q.enters && q.strand == at).ok_or(tangled)?;
                        let next = ports[(k + 1) % ports.len()].strand;
                        let enter = through[next].1[0];
                        let to = if enter.0 < leave.0 { enter.0 + 4.0 } else { enter.0 };
                        self.walk(column, row, (leave.0, Some(leave.1)), (to, Some(enter.1)), &mut chain);
                        at = next;
                    }
                    if at != start {
                        return Err(tangled);
                    }
                    if !chain.is_empty() {
                        loops.push(chain);
                    }
                }
                if !loops.is_empty() {
                    let corner = |i: usize, j: usize| DVec2::new(self.grid.lines[0][i], self.grid.lines[1][j]);
                    let (min, max) = (corner(column, row), corner(column + 1, row + 1));
                    self.out.tiles.push(ArrangedTile { min, max, loops });
                }
            }
        }
        Ok(())
    }

    /// For each tile whether its corners are kept, as far as tiles without strands need to know.
    fn whole_tiles(&self, default: bool) -> Vec<bool> {
        let (columns, rows) = (self.grid.count(0), self.grid.count(1));
        let mut corners: BTreeMap<(usize, usize), bool> = BTreeMap::new();
        let cells = |k: usize| {
            let (column, row) = (k % columns, k / columns);
            [(column, row), (column + 1, row), (column + 1, row + 1), (column, row + 1)]
                .map(|(i, j)| (self.grid.line_key(0, i), self.grid.line_key(1, j)))
        };
        let crossed = |k: usize| self.strands[k].iter().any(|s| s.ports.is_some());
        for k in (0..columns * rows).filter(|&k| crossed(k)) {
            let mut ports: Vec<(f64, bool)> = self.strands[k]
                .iter()
                .filter_map(|s| s.ports)
                .flat_map(|[enter, leave]| [(enter.0, true), (leave.0, false)])
                .collect();
            ports.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (side, corner) in cells(k).into_iter().enumerate() {
                let before = ports.iter().rev().find(|p| p.0 <= side as f64).or(ports.last());
                if let Some(&(_, enters)) = before {
                    corners.insert(corner, !enters);
                }
            }
        }
        let mut kept: Vec<Option<bool>> = vec![None; columns * rows];
        loop {
            let mut changed = false;
            for k in (0..columns * rows).filter(|&k| !crossed(k)) {
                if kept[k].is_none() {
                    kept[k] = cells(k).iter().find_map(|c| corners.get(c).copied());
                    if let Some(status) = kept[k] {
                        for c in cells(k) {
                            corners.insert(c, status);
                        }
                        changed = true;
                    }
                }
            }
            if !changed {
                break;
            }
        }
        kept.into_iter().map(|k| k.unwrap_or(default)).collect()
    }

    /// Borders of a tile from one perimeter position to another, counter-clockwise, appended to `chain`.
    fn walk(
        &mut self,
        column: usize,
        row: usize,
        from: (f64, Option<usize>),
        to: (f64, Option<usize>),
        chain: &mut Vec<Stretch>,
    ) {
        let mut at = from.0;
        let mut node = from.1.map(Node::Crossing);
        while at < to.0 {
            let side = at.floor();
            let end = (side + 1.0).min(to.0);
            let corner = |position: f64| {
                let (i, j) = [(0, 0), (1, 0), (1, 1), (0, 1)][position as usize % 4];
                Node::Corner(self.grid.line_key(0, column + i), self.grid.line_key(1, row + j))
            };
            let start_node = node.unwrap_or_else(|| corner(at));
            let last = end >= to.0;
            let end_node = match (last, to.1) {
                (true, Some(c)) => Node::Crossing(c),
                _ => corner(end),
            };
            // A crossing on a line's very end stands for the corner: nothing lies between.
            if end > at {
                let border =
                    self.border(column, row, side as usize % 4, [at - side, end - side], [start_node, end_node]);
                chain.push(border);
            }
            at = end;
            node = if last { to.1.map(Node::Crossing) } else { None };
        }
    }

    fn border(&mut self, column: usize, row: usize, side: usize, f: [f64; 2], nodes: [Node; 2]) -> Stretch {
        // Sides: bottom, right, top, left; the line's axis, its number, and whether the walk runs against it.
        let (axis, line, reversed) =
            [(1, row, false), (0, column + 1, false), (1, row + 1, true), (0, column, true)][side];
        let run = 1 - axis;
        let strip = if run == 0 { column } else { row };
        let (lo, hi) = (self.grid.lines[run][strip], self.grid.lines[run][strip + 1]);
        let position = |f: f64| if reversed { hi - f * (hi - lo) } else { lo + f * (hi - lo) };
        let (mut range, mut nodes) = ((position(f[0]), position(f[1])), nodes);
        if reversed {
            range = (range.1, range.0);
            nodes.reverse();
        }
        let key = self.grid.line_key(axis, line);
        let at = self.grid.lines[axis][line];
        let outer = if line == 0 { Some(0) } else { (line == self.grid.count(axis)).then_some(1) };
        let pole = outer.and_then(|side| self.pole_sides[axis][side]);
        if let Some(pole) = pole {
            for node in nodes {
                if let Node::Corner(i, j) = node {
                    self.out.pole_corners.insert((i, j), pole);
                }
            }
        }
        let borders = &mut self.out.borders;
        let border = *self.keys.entry((axis, key, nodes[0], nodes[1])).or_insert_with(|| {
            borders.push(Border { axis, at: self.grid.lines[axis][key], range, nodes, pole });
            borders.len() - 1
        });
        Stretch::Border { border, reversed, at }
    }
}

/// A place on a tile's perimeter where a strand enters or leaves.
struct Port {
    position: f64,
    enters: bool,
    strand: usize,
}

/// Ports in order along the perimeter; none when two neighbours both enter or both leave.
fn alternating(strands: impl Iterator<Item = [(f64, usize); 2]>) -> Option<Vec<Port>> {
    let mut ports: Vec<Port> = strands
        .enumerate()
        .flat_map(|(strand, [enter, leave])| {
            [Port { position: enter.0, enters: true, strand }, Port { position: leave.0, enters: false, strand }]
        })
        .collect();
    ports.sort_by(|a, b| a.position.total_cmp(&b.position));
    let n = ports.len();
    (0..n).all(|k| ports[k].enters != ports[(k + 1) % n].enters).then_some(ports)
}
