//! The pcurves of a loop, end to end -> a closed curve in the unrolled plane, with its area and winding numbers.

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
        let Along::Edge(_) = self.along else {
            for s in &mut self.samples {
                s.uv += by;
                s.t += by.dot(s.d);
            }
            return;
        };
        for s in &mut self.samples {
            s.uv += by;
        }
    }

    pub(crate) fn reverse(&mut self) {
        self.reversed = !self.reversed;
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

/// A loop in the unrolled plane.
#[derive(Clone, Debug)]
pub(crate) struct UvLoop {
    pub(crate) pieces: Vec<Piece>,
    /// By how many periods the end is off the start, in u and v.
    pub(crate) winding: [i32; 2],
}

impl UvLoop {
    pub(crate) fn polyline(&self) -> Vec<DVec2> {
        let mut points = Vec::with_capacity(self.pieces.iter().map(|p| 2 * p.samples.len()).sum());
        self.pieces.iter().for_each(|p| p.polyline(&mut points));
        points
    }

    pub(crate) fn reverse(&mut self) {
        self.pieces.reverse();
        self.pieces.iter_mut().for_each(Piece::reverse);
        self.winding = [-self.winding[0], -self.winding[1]];
    }

    pub(crate) fn shift(&mut self, by: DVec2) {
        self.pieces.iter_mut().for_each(|p| p.shift(by));
    }
}

/// Winding number of a closed polygon about `q`.
pub(crate) fn winding_about(p: &[DVec2], q: DVec2) -> i32 {
    let Some(&last) = p.last() else { return 0 };
    let (mut before, mut below, mut winding) = (last, last.y <= q.y, 0);
    for &corner in p {
        let is_below = corner.y <= q.y;
        if is_below != below {
            winding += crossed([before, corner], q);
        }
        (before, below) = (corner, is_below);
    }
    winding
}

/// The contribution of a side to the winding number about `q`: 1 if it passes upwards to the right of `q`, -1 if
/// downwards.
pub(crate) fn crossed([a, b]: [DVec2; 2], q: DVec2) -> i32 {
    if (a.y <= q.y) == (b.y <= q.y) {
        return 0;
    }
    let left = (b - a).perp_dot(q - a);
    if a.y <= q.y { i32::from(left > 0.0) } else { -i32::from(left < 0.0) }
}
