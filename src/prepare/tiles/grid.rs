//! The grid of lines that cut a region, and where loops cross them.

use crate::prepare::uv::uv_loop::Along;

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

    /// Lines after the lower of `a` and `b`, up to the higher, in order from `a` to `b`: number through all periods, and value.
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
