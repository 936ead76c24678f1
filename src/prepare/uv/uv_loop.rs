//! The pcurves of a loop, end to end -> a closed curve in the unrolled plane, with its area; loops -> the region that
//! they bound.

use super::uv_curve::UvSample;
use glam::DVec2;

/// The edge or pole along which a piece of a loop runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Along {
    /// A B-rep edge of the part.
    Edge(u32),
    /// A pole of the surface (index into the projector's poles). The parameter is the coordinate that varies.
    Pole(usize),
}

impl Along {
    /// The edge, if it is one.
    pub(crate) const fn edge(self) -> Option<u32> {
        match self {
            Self::Edge(edge) => Some(edge),
            Self::Pole(_) => None,
        }
    }
}

/// A part of a loop with one pcurve.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub(crate) along: Along,
    /// Whether the loop runs against the parameter.
    pub(crate) reversed: bool,
    /// In order of the parameter.
    pub(crate) samples: Vec<UvSample>,
}

impl Piece {
    /// Its first and last sample in loop order.
    pub(crate) fn ends(&self) -> [&UvSample; 2] {
        let (first, last) = (&self.samples[0], &self.samples[self.samples.len() - 1]);
        if self.reversed { [last, first] } else { [first, last] }
    }

    pub(crate) fn start(&self) -> DVec2 {
        self.ends()[0].uv
    }

    pub(crate) fn end(&self) -> DVec2 {
        self.ends()[1].uv
    }

    pub(crate) fn shift(&mut self, by: DVec2) {
        let is_edge = matches!(self.along, Along::Edge(_));
        for s in &mut self.samples {
            s.uv += by;
            // The parameter of a pole is that of the parameter plane.
            s.t += if is_edge { 0.0 } else { by.dot(s.d) };
        }
    }

    /// Appends points in loop order, without the last.
    fn polyline(&self, out: &mut Vec<DVec2>) {
        let middle = |w: &[UvSample]| UvSample::interpolate(&w[0], &w[1], 0.5 * (w[0].t + w[1].t));
        let cubics = self.samples.windows(2);
        if self.reversed {
            cubics.rev().for_each(|w| out.extend_from_slice(&[w[1].uv, middle(w)]));
        } else {
            cubics.for_each(|w| out.extend_from_slice(&[w[0].uv, middle(w)]));
        }
    }
}

/// A point of a loop.
#[derive(Clone, Copy)]
pub(crate) struct LoopPlace {
    pub(crate) piece: usize,
    pub(crate) t: f64,
}

/// A piece on the way from one point of a loop to another.
pub(crate) struct Passed<'a> {
    pub(crate) piece: &'a Piece,
    /// The parameters at which the way enters and leaves it.
    pub(crate) range: [f64; 2],
    pub(crate) is_first: bool,
    pub(crate) is_last: bool,
    /// Whether the way has passed the loop's start.
    pub(crate) wrapped: bool,
}

/// A loop in the unrolled plane.
#[derive(Clone, Debug)]
pub(crate) struct UvLoop {
    pub(crate) pieces: Vec<Piece>,
    /// By how many periods the end is off the start, in u and v.
    pub(crate) winding: [i32; 2],
}

impl UvLoop {
    /// The pieces from one point to another, past the loop's start if `wraps`.
    pub(crate) fn between(&self, [from, to]: [LoopPlace; 2], wraps: bool) -> impl Iterator<Item = Passed<'_>> {
        let count = self.pieces.len();
        let whole_turn = if wraps && from.piece <= to.piece { count } else { 0 };
        let last = (to.piece + count - from.piece) % count + whole_turn;
        (0..=last).map(move |k| {
            let piece = &self.pieces[(from.piece + k) % count];
            let [start, end] = piece.ends().map(|sample| sample.t);
            let (is_first, is_last) = (k == 0, k == last);
            let range = [if is_first { from.t } else { start }, if is_last { to.t } else { end }];
            Passed { piece, range, is_first, is_last, wrapped: from.piece + k >= count }
        })
    }

    pub(crate) fn polyline(&self) -> Vec<DVec2> {
        let mut points = Vec::with_capacity(self.pieces.iter().map(|p| 2 * p.samples.len()).sum());
        self.pieces.iter().for_each(|p| p.polyline(&mut points));
        points
    }

    /// Twice its signed area: the integral of p × dp, with p from its start, over its cubics and a chord from its end
    /// to its start. A polygon along it errs by more than the area of a crescent.
    pub(crate) fn double_area(&self) -> f64 {
        let origin = self.pieces[0].start();
        let mut before = self.pieces[self.pieces.len() - 1].end();
        let mut area = 0.0;
        for piece in &self.pieces {
            let swept: f64 = piece.samples.windows(2).map(|w| UvSample::double_area(&w[0], &w[1], origin)).sum();
            area += if piece.reversed { -swept } else { swept };
            area += (before - origin).perp_dot(piece.start() - origin);
            before = piece.end();
        }
        area
    }

    /// Mean of coordinate `across` by the other one, of a loop that goes round in the direction of the latter: the
    /// integral over its cubics. Of two loops that do not cross, the lower one has the lower mean.
    pub(crate) fn mean(&self, across: usize) -> f64 {
        let (from, to) = (self.pieces[0].start(), self.pieces[self.pieces.len() - 1].end());
        let sign = if across == 0 { 1.0 } else { -1.0 };
        let run = to[1 - across] - from[1 - across];
        from[across] + 0.5 * (to[across] - from[across]) + 0.5 * sign * self.double_area() / run
    }

    pub(crate) fn reverse(&mut self) {
        self.pieces.reverse();
        self.pieces.iter_mut().for_each(|piece| piece.reversed = !piece.reversed);
        self.winding = [-self.winding[0], -self.winding[1]];
    }

    pub(crate) fn shift(&mut self, by: DVec2) {
        self.pieces.iter_mut().for_each(|p| p.shift(by));
    }
}

/// The part of the unrolled plane that a face covers.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    pub(crate) loops: Vec<UvLoop>,
    /// Directions in which it spans a whole period and has to be cut open.
    pub(crate) wraps: [bool; 2],
    /// Its box. In a direction that wraps: one period, from any start.
    pub(crate) bounds: [(f64, f64); 2],
    /// Winding number where the loops add nothing: beyond the low end of the box in a direction that does not wrap.
    /// Loops of a region that wraps both ways are counted from it.
    pub(crate) base: i32,
    /// Direction and parameter of the border of the surface that bounds the region where no loop does. Not a pole.
    pub(crate) unbounded: Option<(usize, f64)>,
}

impl Region {
    /// The B-rep edges along its loops, piece by piece.
    pub(crate) fn edges(&self) -> impl Iterator<Item = u32> {
        self.loops.iter().flat_map(|l| &l.pieces).filter_map(|piece| piece.along.edge())
    }
}

/// Exact bounding box of the loops' pcurves, including the extremes of every Hermite piece.
pub(crate) fn loops_box(loops: &[UvLoop]) -> [(f64, f64); 2] {
    let mut b = [(f64::INFINITY, f64::NEG_INFINITY); 2];
    let mut add = |p: DVec2| {
        for (range, x) in b.iter_mut().zip(p.to_array()) {
            *range = (if x < range.0 { x } else { range.0 }, if x > range.1 { x } else { range.1 });
        }
    };
    for samples in loops.iter().flat_map(|l| &l.pieces).map(|p| &p.samples) {
        samples.iter().for_each(|s| add(s.uv));
        for w in samples.windows(2) {
            for axis in 0..2 {
                UvSample::extremes(&w[0], &w[1], axis, |t| add(UvSample::interpolate(&w[0], &w[1], t)));
            }
        }
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2Swizzles as _;
    use std::f64::consts::{PI, TAU};

    /// A piece of cubics through points of a curve, at uneven parameters.
    fn piece(curve: impl Fn(f64) -> (DVec2, DVec2), count: u32, reversed: bool) -> Piece {
        let sample = |k: u32| {
            let t = (f64::from(k) / f64::from(count)).powi(2);
            let (uv, d) = curve(t);
            UvSample { t, uv, d }
        };
        Piece { along: Along::Edge(0), reversed, samples: (0..=count).map(sample).collect() }
    }

    #[test]
    fn a_crescent_has_the_sign_of_its_curves() {
        for offset in [1e-1, 1e-2, 1e-3, 1e-4] {
            let turn = (0.5_f64 * offset).acos();
            let arc = |x: f64, from: f64, to: f64| {
                move |t: f64| {
                    let q = DVec2::from_angle(from + (to - from) * t);
                    (q + DVec2::X * x, q.perp() * (to - from))
                }
            };
            let outer = piece(arc(0.0, turn, TAU - turn), 40, false);
            let inner = piece(arc(offset, PI - turn, PI + turn), 33, true);
            let mut crescent = UvLoop { pieces: vec![outer, inner], winding: [0, 0] };
            crescent.shift(DVec2::new(30.0, -20.0));
            let area = 0.5 * crescent.double_area();
            assert!((area - 2.0 * offset).abs() < 0.05 * offset, "{offset}: {area}");
            crescent.reverse();
            assert!((crescent.double_area() + 2.0 * area).abs() < 1e-12, "{offset}");
        }
    }

    #[test]
    fn a_mean_does_not_depend_on_samples() {
        // Round once, with most samples where the wave is high; and the same with u and v exchanged.
        let wave = |t: f64| (DVec2::new(TAU * t, 3.0 + (TAU * t).cos()), DVec2::new(TAU, -TAU * (TAU * t).sin()));
        let swapped = |t: f64| (wave(t).0.yx(), wave(t).1.yx());
        for reversed in [false, true] {
            let turn = if reversed { -1 } else { 1 };
            let along_u = UvLoop { pieces: vec![piece(wave, 50, reversed)], winding: [turn, 0] };
            let along_v = UvLoop { pieces: vec![piece(swapped, 50, reversed)], winding: [0, turn] };
            for mean in [along_u.mean(1), along_v.mean(0)] {
                assert!((mean - 3.0).abs() < 1e-4, "{mean}");
            }
        }
    }
}
