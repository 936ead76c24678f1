//! Points, lines and arcs -> parts whose faces share coincident vertices and edges.

use glam::DVec3;
use std::f64::consts::{PI, TAU};
use trimtess::model::{
    Coedge, CurveKind, EdgeId, FaceId, Frame3, Loop, NurbsCurve3, Part, PartBuilder, ShellKind, Surface, VertexId,
};

/// The frame at `origin` with third axis `z` and first axis as near as possible to `x`.
pub(crate) fn frame(origin: DVec3, z: DVec3, x: DVec3) -> Frame3 {
    Frame3::from_axis(origin, z, x).expect("an axis")
}

/// The world's frame, raised to `z`.
pub(crate) fn level(z: f64) -> Frame3 {
    Frame3 { origin: DVec3::Z * z, ..Frame3::WORLD }
}

/// A part whose faces belong to one shell.
pub(crate) struct Body {
    pub(crate) part: PartBuilder,
    pub(crate) shell: u32,
    vertices: Vec<(DVec3, VertexId)>,
    lines: Vec<([VertexId; 2], EdgeId)>,
}

impl Body {
    pub(crate) fn new(kind: ShellKind) -> Self {
        let mut part = PartBuilder::new("body");
        let shell = part.plain_shell(kind);
        Self { part, shell, vertices: Vec::new(), lines: Vec::new() }
    }

    pub(crate) fn solid() -> Self {
        Self::new(ShellKind::Outer)
    }

    pub(crate) fn sheet() -> Self {
        Self::new(ShellKind::Open)
    }

    /// Makes later faces use their own vertices and edges.
    pub(crate) fn forget(&mut self) {
        self.vertices.clear();
        self.lines.clear();
    }

    /// The vertex at `p`, new if there is none within rounding.
    pub(crate) fn vertex(&mut self, p: DVec3) -> VertexId {
        let near = 1e-12 * p.abs().max_element().max(1.0);
        if let Some(&(_, v)) = self.vertices.iter().find(|(q, _)| q.distance(p) <= near) {
            return v;
        }
        let v = self.part.vertex(p);
        self.vertices.push((p, v));
        v
    }

    /// The straight edge from `a` to `b`, shared if it exists.
    pub(crate) fn line(&mut self, a: DVec3, b: DVec3) -> Coedge {
        let (a, b) = (self.vertex(a), self.vertex(b));
        if let Some((ends, edge)) = self.lines.iter().find(|(ends, _)| *ends == [a, b] || *ends == [b, a]) {
            return if ends[0] == a { edge.along() } else { edge.against() };
        }
        let edge = self.part.line(a, b);
        self.lines.push(([a, b], edge));
        edge.along()
    }

    /// Straight edges from corner to corner and back to the first.
    pub(crate) fn polygon(&mut self, corners: &[DVec3]) -> Vec<Coedge> {
        (0..corners.len()).map(|k| self.line(corners[k], corners[(k + 1) % corners.len()])).collect()
    }

    /// A whole circle about the frame's z, starting on its x axis.
    pub(crate) fn circle(&mut self, frame: &Frame3, radius: f64) -> EdgeId {
        self.arc(frame, radius, 0.0, TAU)
    }

    /// An arc about the frame's z.
    pub(crate) fn arc(&mut self, frame: &Frame3, radius: f64, from: f64, to: f64) -> EdgeId {
        let [a, b] = [from, to].map(|angle: f64| {
            let (s, c) = angle.sin_cos();
            self.vertex(frame.place(DVec3::new(radius * c, radius * s, 0.0)))
        });
        let curve = NurbsCurve3::arc(frame, radius, radius, from, to);
        self.part.curve(curve, CurveKind::Circle, a, b)
    }

    /// A free-form edge.
    pub(crate) fn spline(&mut self, curve: NurbsCurve3) -> EdgeId {
        let (t0, t1) = curve.domain();
        let (a, b) = (self.vertex(curve.point(t0)), self.vertex(curve.point(t1)));
        self.part.curve(curve, CurveKind::Spline, a, b)
    }

    pub(crate) fn face(&mut self, surface: Surface, loops: Vec<Vec<Coedge>>, reversed: bool) -> FaceId {
        self.part.plain_face(surface, self.shell, loops.into_iter().map(Loop::Edges).collect(), reversed)
    }

    /// A plane face whose normal is the frame's z.
    pub(crate) fn flat(&mut self, frame: Frame3, loops: Vec<Vec<Coedge>>) -> FaceId {
        self.face(Surface::Plane { frame }, loops, false)
    }

    /// A plane face with straight edges, counter-clockwise seen from outside, with holes.
    pub(crate) fn side(&mut self, corners: &[DVec3], holes: Vec<Vec<Coedge>>) -> FaceId {
        let [a, b, c] = [corners[0], corners[1], corners[2]];
        let mut loops = vec![self.polygon(corners)];
        loops.extend(holes);
        self.flat(frame(a, (b - a).cross(c - b), b - a), loops)
    }

    /// A window between parameter lines of a cylinder about z, as a hole.
    pub(crate) fn window(&mut self, radius: f64, (u0, u1): (f64, f64), (v0, v1): (f64, f64)) -> Vec<Coedge> {
        let [south, north] = [v0, v1].map(|z| self.arc(&level(z), radius, u0, u1));
        let [west, east] = [u0, u1].map(|u: f64| {
            let foot = DVec3::new(radius * u.cos(), radius * u.sin(), 0.0);
            self.line(foot + DVec3::Z * v0, foot + DVec3::Z * v1)
        });
        vec![west, north.along(), Coedge { reversed: !east.reversed, ..east }, south.against()]
    }

    /// The six sides of a box; `top` and `bottom` are holes in its upper and lower side.
    pub(crate) fn cuboid(&mut self, low: DVec3, high: DVec3, top: Vec<Vec<Coedge>>, bottom: Vec<Vec<Coedge>>) {
        let p = |i: usize, j: usize, k: usize| {
            let pick = |up: usize, axis: usize| if up == 1 { high[axis] } else { low[axis] };
            DVec3::new(pick(i, 0), pick(j, 1), pick(k, 2))
        };
        self.side(&[p(0, 0, 1), p(1, 0, 1), p(1, 1, 1), p(0, 1, 1)], top);
        self.side(&[p(0, 0, 0), p(0, 1, 0), p(1, 1, 0), p(1, 0, 0)], bottom);
        self.side(&[p(0, 0, 0), p(1, 0, 0), p(1, 0, 1), p(0, 0, 1)], Vec::new());
        self.side(&[p(1, 0, 0), p(1, 1, 0), p(1, 1, 1), p(1, 0, 1)], Vec::new());
        self.side(&[p(1, 1, 0), p(0, 1, 0), p(0, 1, 1), p(1, 1, 1)], Vec::new());
        self.side(&[p(0, 1, 0), p(0, 0, 0), p(0, 0, 1), p(0, 1, 1)], Vec::new());
    }

    pub(crate) fn finish(self) -> Part {
        self.part.finish().expect("a valid part")
    }
}

/// The cubic spline with continuous tangents through `count` + 1 points of a curve over `range`, in the curve's own
/// parameter. Its error is of fourth order in the spacing. The spline of a closed curve starts and ends at one point,
/// bit for bit.
pub(crate) fn through(curve: impl Fn(f64) -> DVec3, range: (f64, f64), count: u32) -> NurbsCurve3 {
    let step = (range.1 - range.0) / f64::from(count);
    let tangent = |t: f64| {
        let h = 1e-2 * step;
        (8.0 * (curve(t + h) - curve(t - h)) - (curve(t + 2.0 * h) - curve(t - 2.0 * h))) / (12.0 * h)
    };
    let at = |k: u32| if k == count { range.1 } else { range.0 + step * f64::from(k) };
    let mut knots = vec![range.0; 4];
    let mut points = vec![curve(range.0)];
    for k in 0..count {
        let (a, b) = (at(k), at(k + 1));
        points.extend([curve(a) + tangent(a) * (step / 3.0), curve(b) - tangent(b) * (step / 3.0)]);
        knots.extend([b; 2]);
    }
    knots.extend([range.1; 2]);
    let (first, last) = (points[0], curve(range.1));
    points.push(if first.distance(last) < 1e-9 * (1.0 + first.length()) { first } else { last });
    NurbsCurve3 { degree: 3, knots, points, weights: Vec::new() }
}

/// The integral of a smooth function, by Simpson's rule.
pub(crate) fn integral(f: impl Fn(f64) -> f64, range: (f64, f64)) -> f64 {
    let steps = 2000_u32;
    let h = (range.1 - range.0) / f64::from(steps);
    let weight = |k: u32| if k == 0 || k == steps { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
    (0..=steps).map(|k| weight(k) * f(range.0 + h * f64::from(k))).sum::<f64>() * h / 3.0
}

/// Volume of a ball.
pub(crate) fn ball(radius: f64) -> f64 {
    4.0 / 3.0 * PI * radius.powi(3)
}

/// Volume of a spherical cap of the given height.
pub(crate) fn cap(radius: f64, height: f64) -> f64 {
    PI * height * height * (radius - height / 3.0)
}

/// Volume and side area of a frustum of a cone.
pub(crate) fn frustum(low: f64, high: f64, height: f64) -> (f64, f64) {
    (PI * height / 3.0 * (low * low + low * high + high * high), PI * (low + high) * (low - high).hypot(height))
}
