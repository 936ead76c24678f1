//! Names to small models, stated by hand: for tests, examples, and `builtin:NAME` on the command line.
//!
//! Together they hold every way of bounding a face: outer loops and holes, seams, two loops around a cylinder, an apex, a
//! surface kept whole, free-form borders, several solids, instances with colours.

use super::{
    Coedge, CurveKind, EdgeId, Face, Frame3, Instance, Loop, Model, ModelBuilder, NurbsCurve, NurbsCurve3,
    NurbsSurface, Part, PartBuilder, ShellKind, Surface, VertexId,
};
use glam::{DAffine3, DVec3};
use std::f64::consts::{FRAC_PI_4, TAU};

/// What [`by_name`] knows, in the order of what they need.
pub const NAMES: [&str; 9] = ["square", "box", "cylinder", "washer", "cone", "sphere", "torus", "wave", "pair"];

/// The shape of that name; `None` if there is none.
///
/// ```
/// use trimtess::model::shapes;
/// assert!(shapes::NAMES.iter().all(|name| shapes::by_name(name).is_some()));
/// assert!(shapes::by_name("teapot").is_none());
/// ```
#[must_use]
pub fn by_name(name: &str) -> Option<Model> {
    let part = match name {
        "square" => square(),
        "box" => cuboid(),
        "cylinder" => cylinder(),
        "washer" => washer(),
        "cone" => cone(),
        "sphere" => sphere(),
        "torus" => torus(),
        "wave" => wave(),
        "pair" => return Some(pair()),
        _ => return None,
    };
    let mut model = ModelBuilder::new(name);
    let part = model.part(part);
    model.place(part, DAffine3::IDENTITY);
    model.finish().ok()
}

/// A plane square of side 20 about the origin with a hole of radius 6.
#[must_use]
pub fn square() -> Part {
    let mut shape = Maker::new("square", ShellKind::Open);
    let corners = [(-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)];
    let outer = shape.polygon(&corners.map(|(x, y)| DVec3::new(x, y, 0.0)));
    let hole = shape.part.circle(&Frame3::WORLD, 6.0);
    let hole = vec![hole.against()];
    shape.face(Surface::Plane { frame: Frame3::WORLD }, vec![outer, hole], false);
    shape.done()
}

/// A box of 30 × 20 × 10 in the first octant.
#[must_use]
pub fn cuboid() -> Part {
    let mut shape = Maker::new("box", ShellKind::Outer);
    let size = DVec3::new(30.0, 20.0, 10.0);
    let corner = |k: usize| size * DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    let vertices: Vec<VertexId> = (0..8).map(|k| shape.part.vertex(corner(k))).collect();
    let mut edge_between = [[None; 8]; 8];
    for a in 0..8 {
        for b in [a | 1, a | 2, a | 4].into_iter().filter(|&b| b != a) {
            edge_between[a][b] = Some(shape.part.line(vertices[a], vertices[b]));
        }
    }
    let use_of = |a: usize, b: usize| match (edge_between[a][b], edge_between[b][a]) {
        (Some(edge), _) => Some(edge.along()),
        (_, Some(edge)) => Some(edge.against()),
        _ => None,
    };
    // Corners of each side, counter-clockwise from outside.
    for side in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        let [a, b, c, _] = side.map(corner);
        let coedges = (0..4).filter_map(|k| use_of(side[k], side[(k + 1) % 4])).collect();
        if let Some(frame) = Frame3::from_axis(a, (b - a).cross(c - a), b - a) {
            shape.face(Surface::Plane { frame }, vec![coedges], false);
        }
    }
    shape.done()
}

/// A cylinder about z of radius 5 and height 8, its side closed by a seam.
#[must_use]
pub fn cylinder() -> Part {
    let mut shape = Maker::new("cylinder", ShellKind::Outer);
    let top = Frame3 { origin: DVec3::Z * 8.0, ..Frame3::WORLD };
    let ends = [Frame3::WORLD, top].map(|frame| shape.part.vertex(frame.place(DVec3::X * 5.0)));
    let circle = |frame| NurbsCurve3::arc(frame, 5.0, 5.0, 0.0, TAU);
    let low = shape.part.curve(circle(&Frame3::WORLD), CurveKind::Circle, ends[0], ends[0]);
    let high = shape.part.curve(circle(&top), CurveKind::Circle, ends[1], ends[1]);
    let seam = shape.part.line(ends[0], ends[1]);
    let side = vec![low.along(), seam.along(), high.against(), seam.against()];
    shape.face(Surface::Cylinder { frame: Frame3::WORLD, radius: 5.0 }, vec![side], false);
    shape.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![low.along()]], true);
    shape.face(Surface::Plane { frame: top }, vec![vec![high.along()]], false);
    shape.done()
}

/// A washer about z of radii 6 and 10 and height 3; its sides have two loops each and no seam.
#[must_use]
pub fn washer() -> Part {
    let mut shape = Maker::new("washer", ShellKind::Outer);
    let top = Frame3 { origin: DVec3::Z * 3.0, ..Frame3::WORLD };
    let [inner, outer] =
        [6.0, 10.0].map(|radius| (shape.part.circle(&Frame3::WORLD, radius), shape.part.circle(&top, radius)));
    let sides = |(low, high): (EdgeId, EdgeId)| vec![vec![low.along()], vec![high.against()]];
    shape.face(Surface::Cylinder { frame: Frame3::WORLD, radius: 10.0 }, sides(outer), false);
    shape.face(Surface::Cylinder { frame: Frame3::WORLD, radius: 6.0 }, sides(inner), true);
    shape.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![outer.0.along()], vec![inner.0.against()]], true);
    shape.face(Surface::Plane { frame: top }, vec![vec![outer.1.along()], vec![inner.1.against()]], false);
    shape.done()
}

/// A cone about z of base radius 5 and height 5; its side is bounded by the base circle and the apex.
#[must_use]
pub fn cone() -> Part {
    let mut shape = Maker::new("cone", ShellKind::Outer);
    let base = shape.part.circle(&Frame3::WORLD, 5.0);
    let apex = shape.part.vertex(DVec3::Z * 5.0);
    let side = Surface::Cone { frame: Frame3::WORLD, radius: 5.0, half_angle: -FRAC_PI_4 };
    shape.face_of(side, vec![Loop::Edges(vec![base.along()]), Loop::Vertex(apex)], false);
    shape.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![base.along()]], true);
    shape.done()
}

/// A sphere of radius 5 about the origin, kept whole: no loops.
#[must_use]
pub fn sphere() -> Part {
    let mut shape = Maker::new("sphere", ShellKind::Outer);
    shape.face(Surface::Sphere { frame: Frame3::WORLD, radius: 5.0 }, Vec::new(), false);
    shape.done()
}

/// A torus about z of radii 8 and 3, kept whole: no loops.
#[must_use]
pub fn torus() -> Part {
    let mut shape = Maker::new("torus", ShellKind::Outer);
    shape.face(Surface::Torus { frame: Frame3::WORLD, major: 8.0, minor: 3.0 }, Vec::new(), false);
    shape.done()
}

/// A bicubic sheet over a square of side 12, bounded by its own borders.
#[must_use]
pub fn wave() -> Part {
    const HEIGHTS: [[f64; 4]; 4] =
        [[0.0, 2.0, -1.0, 0.0], [3.0, -4.0, 5.0, 1.0], [-2.0, 6.0, -3.0, 2.0], [0.0, 1.0, 3.0, -1.0]];
    let mut shape = Maker::new("wave", ShellKind::Open);
    let point = |i: usize, j: usize| DVec3::new(4.0 * i as f64 - 6.0, 4.0 * j as f64 - 6.0, HEIGHTS[i][j]);
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let [a, b, c, d] = [(0, 0), (3, 0), (3, 3), (0, 3)].map(|(i, j)| shape.part.vertex(point(i, j)));
    let mut border = |points: [DVec3; 4], start, end| {
        let curve = NurbsCurve { degree: 3, knots: knots.clone(), points: points.to_vec(), weights: Vec::new() };
        shape.part.curve(curve, CurveKind::Spline, start, end)
    };
    let ks = [0, 1, 2, 3];
    let south = border(ks.map(|k| point(k, 0)), a, b);
    let east = border(ks.map(|k| point(3, k)), b, c);
    let north = border(ks.map(|k| point(k, 3)), d, c);
    let west = border(ks.map(|k| point(0, k)), a, d);
    let points = ks.iter().flat_map(|&i| ks.map(|j| point(i, j))).collect();
    let net =
        NurbsSurface { degree_u: 3, degree_v: 3, knots_u: knots.clone(), knots_v: knots, points, weights: Vec::new() };
    let boundary = vec![south.along(), east.along(), north.against(), west.against()];
    shape.face(Surface::Nurbs(net), vec![boundary], false);
    shape.done()
}

/// A washer placed twice and a cylinder in it, in three colours.
#[must_use]
pub fn pair() -> Model {
    let mut model = ModelBuilder::new("pair");
    let (washer, cylinder) = (model.part(washer()), model.part(cylinder()));
    for (part, z, colour) in [
        (washer, 0.0, [0.85, 0.3, 0.2, 1.0]),
        (washer, 5.0, [0.2, 0.45, 0.85, 1.0]),
        (cylinder, 0.0, [0.85, 0.75, 0.3, 1.0]),
    ] {
        let transform = DAffine3::from_translation(DVec3::Z * z);
        model.instance(Instance { part, transform, colour: Some(colour), name: String::new() });
    }
    model.finish().expect("stated soundly above")
}

/// A part in the making whose faces belong to one shell.
struct Maker {
    part: PartBuilder,
    shell: u32,
}

impl Maker {
    fn new(name: &str, kind: ShellKind) -> Self {
        let mut part = PartBuilder::new(name);
        let shell = part.open_shell(kind);
        Self { part, shell }
    }

    /// A closed loop of straight edges through `corners`.
    fn polygon(&mut self, corners: &[DVec3]) -> Vec<Coedge> {
        let vertices: Vec<VertexId> = corners.iter().map(|&corner| self.part.vertex(corner)).collect();
        let next = |k: usize| vertices[(k + 1) % vertices.len()];
        (0..vertices.len()).map(|k| self.part.line(vertices[k], next(k)).along()).collect()
    }

    fn face(&mut self, surface: Surface, loops: Vec<Vec<Coedge>>, reversed: bool) {
        self.face_of(surface, loops.into_iter().map(Loop::Edges).collect(), reversed);
    }

    fn face_of(&mut self, surface: Surface, loops: Vec<Loop>, reversed: bool) {
        let face = Face { surface, loops, reversed, shell: self.shell, colour: None, name: String::new(), entity: 0 };
        self.part.face(face);
    }

    fn done(self) -> Part {
        self.part.finish().expect("stated soundly above")
    }
}
