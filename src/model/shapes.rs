//! Names to small models, stated by hand: for tests, examples, and `builtin:NAME` on the command line.
//!
//! Together they hold every way of bounding a face: outer loops and holes, seams, two loops around a cylinder, an apex, a
//! surface kept whole, free-form borders, several solids, instances with colours.

use super::{
    Coedge, CurveKind, Edge, EdgeId, Face, Frame3, Instance, Loop, Model, NurbsCurve, NurbsCurve3, NurbsSurface, Part,
    PartId, Shell, ShellKind, Surface, VertexId,
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
    Some(placed(name, vec![part], vec![instance(0, DAffine3::IDENTITY)]))
}

/// A plane square of side 20 about the origin with a hole of radius 6.
#[must_use]
pub fn square() -> Part {
    let mut part = Maker::new("square", ShellKind::Open);
    let corners = [(-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)];
    let outer = part.polygon(&corners.map(|(x, y)| DVec3::new(x, y, 0.0)));
    let hole = part.circle(Frame3::WORLD, 6.0);
    let hole = vec![against(hole)];
    part.face(Surface::Plane { frame: Frame3::WORLD }, vec![outer, hole], false);
    part.done()
}

/// A box of 30 × 20 × 10 in the first octant.
#[must_use]
pub fn cuboid() -> Part {
    let mut part = Maker::new("box", ShellKind::Outer);
    let size = DVec3::new(30.0, 20.0, 10.0);
    let corner = |k: usize| size * DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    let vertices: Vec<VertexId> = (0..8).map(|k| part.vertex(corner(k))).collect();
    let mut edge_between = [[None; 8]; 8];
    for a in 0..8 {
        for b in [a | 1, a | 2, a | 4].into_iter().filter(|&b| b != a) {
            edge_between[a][b] = Some(part.line(vertices[a], vertices[b]));
        }
    }
    let use_of = |a: usize, b: usize| match (edge_between[a][b], edge_between[b][a]) {
        (Some(edge), _) => Some(along(edge)),
        (_, Some(edge)) => Some(against(edge)),
        _ => None,
    };
    // Corners of each side, counter-clockwise from outside.
    for side in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        let [a, b, c, _] = side.map(corner);
        let coedges = (0..4).filter_map(|k| use_of(side[k], side[(k + 1) % 4])).collect();
        if let Some(frame) = Frame3::from_axis(a, (b - a).cross(c - a), b - a) {
            part.face(Surface::Plane { frame }, vec![coedges], false);
        }
    }
    part.done()
}

/// A cylinder about z of radius 5 and height 8, its side closed by a seam.
#[must_use]
pub fn cylinder() -> Part {
    let mut part = Maker::new("cylinder", ShellKind::Outer);
    let top = Frame3 { origin: DVec3::Z * 8.0, ..Frame3::WORLD };
    let (low, high) = (part.circle(Frame3::WORLD, 5.0), part.circle(top, 5.0));
    let seam = part.line(part.start_of(low), part.start_of(high));
    let side = vec![along(low), along(seam), against(high), against(seam)];
    part.face(Surface::Cylinder { frame: Frame3::WORLD, radius: 5.0 }, vec![side], false);
    part.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![along(low)]], true);
    part.face(Surface::Plane { frame: top }, vec![vec![along(high)]], false);
    part.done()
}

/// A washer about z of radii 6 and 10 and height 3; its sides have two loops each and no seam.
#[must_use]
pub fn washer() -> Part {
    let mut part = Maker::new("washer", ShellKind::Outer);
    let top = Frame3 { origin: DVec3::Z * 3.0, ..Frame3::WORLD };
    let [inner, outer] = [6.0, 10.0].map(|radius| (part.circle(Frame3::WORLD, radius), part.circle(top, radius)));
    let sides = |(low, high): (EdgeId, EdgeId)| vec![vec![along(low)], vec![against(high)]];
    part.face(Surface::Cylinder { frame: Frame3::WORLD, radius: 10.0 }, sides(outer), false);
    part.face(Surface::Cylinder { frame: Frame3::WORLD, radius: 6.0 }, sides(inner), true);
    part.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![along(outer.0)], vec![against(inner.0)]], true);
    part.face(Surface::Plane { frame: top }, vec![vec![along(outer.1)], vec![against(inner.1)]], false);
    part.done()
}

/// A cone about z of base radius 5 and height 5; its side is bounded by the base circle and the apex.
#[must_use]
pub fn cone() -> Part {
    let mut part = Maker::new("cone", ShellKind::Outer);
    let base = part.circle(Frame3::WORLD, 5.0);
    let apex = part.vertex(DVec3::Z * 5.0);
    let side = Surface::Cone { frame: Frame3::WORLD, radius: 5.0, half_angle: -FRAC_PI_4 };
    part.face_of(side, vec![Loop::Edges(vec![along(base)]), Loop::Vertex(apex)], false);
    part.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![along(base)]], true);
    part.done()
}

/// A sphere of radius 5 about the origin, kept whole: no loops.
#[must_use]
pub fn sphere() -> Part {
    let mut part = Maker::new("sphere", ShellKind::Outer);
    part.face(Surface::Sphere { frame: Frame3::WORLD, radius: 5.0 }, Vec::new(), false);
    part.done()
}

/// A torus about z of radii 8 and 3, kept whole: no loops.
#[must_use]
pub fn torus() -> Part {
    let mut part = Maker::new("torus", ShellKind::Outer);
    part.face(Surface::Torus { frame: Frame3::WORLD, major: 8.0, minor: 3.0 }, Vec::new(), false);
    part.done()
}

/// A bicubic sheet over a square of side 12, bounded by its own borders.
#[must_use]
pub fn wave() -> Part {
    const HEIGHTS: [[f64; 4]; 4] =
        [[0.0, 2.0, -1.0, 0.0], [3.0, -4.0, 5.0, 1.0], [-2.0, 6.0, -3.0, 2.0], [0.0, 1.0, 3.0, -1.0]];
    let mut part = Maker::new("wave", ShellKind::Open);
    let point = |i: usize, j: usize| DVec3::new(4.0 * i as f64 - 6.0, 4.0 * j as f64 - 6.0, HEIGHTS[i][j]);
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let [a, b, c, d] = [(0, 0), (3, 0), (3, 3), (0, 3)].map(|(i, j)| part.vertex(point(i, j)));
    let mut border = |points: [DVec3; 4], start, end| {
        let curve = NurbsCurve { degree: 3, knots: knots.clone(), points: points.to_vec(), weights: Vec::new() };
        part.edge(curve, CurveKind::Spline, start, end)
    };
    let ks = [0, 1, 2, 3];
    let south = border(ks.map(|k| point(k, 0)), a, b);
    let east = border(ks.map(|k| point(3, k)), b, c);
    let north = border(ks.map(|k| point(k, 3)), d, c);
    let west = border(ks.map(|k| point(0, k)), a, d);
    let points = ks.iter().flat_map(|&i| ks.map(|j| point(i, j))).collect();
    let net =
        NurbsSurface { degree_u: 3, degree_v: 3, knots_u: knots.clone(), knots_v: knots, points, weights: Vec::new() };
    let boundary = vec![along(south), along(east), against(north), against(west)];
    part.face(Surface::Nurbs(net), vec![boundary], false);
    part.done()
}

/// A washer placed twice and a cylinder in it, in three colours.
#[must_use]
pub fn pair() -> Model {
    let at = |part, z: f64, colour| Instance {
        colour: Some(colour),
        ..instance(part, DAffine3::from_translation(DVec3::Z * z))
    };
    let instances =
        vec![at(0, 0.0, [0.85, 0.3, 0.2, 1.0]), at(0, 5.0, [0.2, 0.45, 0.85, 1.0]), at(1, 0.0, [0.85, 0.75, 0.3, 1.0])];
    placed("pair", vec![washer(), cylinder()], instances)
}

fn instance(part: u32, transform: DAffine3) -> Instance {
    Instance { part: PartId(part), transform, colour: None, name: String::new() }
}

fn placed(name: &str, parts: Vec<Part>, instances: Vec<Instance>) -> Model {
    Model { name: name.into(), parts, instances, millimetres_per_unit: 1.0, diagnostics: Vec::new() }
}

/// The edge in its own direction.
fn along(edge: EdgeId) -> Coedge {
    Coedge { edge, reversed: false, pcurve: None }
}

/// The edge in the opposite direction.
fn against(edge: EdgeId) -> Coedge {
    Coedge { edge, reversed: true, pcurve: None }
}

/// A part in the making; all faces belong to one shell.
struct Maker(Part);

impl Maker {
    fn new(name: &str, kind: ShellKind) -> Self {
        Self(Part { name: name.into(), shells: vec![Shell { kind, entity: 0 }], ..Part::default() })
    }

    fn vertex(&mut self, point: DVec3) -> VertexId {
        self.0.vertices.push(point);
        VertexId::new(self.0.vertices.len() - 1)
    }

    /// An edge over the whole domain of its curve.
    fn edge(&mut self, curve: NurbsCurve3, kind: CurveKind, start: VertexId, end: VertexId) -> EdgeId {
        let range = curve.domain();
        self.0.edges.push(Edge { curve, range, start, end, kind, entity: 0 });
        EdgeId::new(self.0.edges.len() - 1)
    }

    fn line(&mut self, start: VertexId, end: VertexId) -> EdgeId {
        let [a, b] = [start, end].map(|vertex| self.0.vertices[vertex.index()]);
        self.edge(NurbsCurve3::line(a, b), CurveKind::Line, start, end)
    }

    /// A whole circle about the frame's z, from and to its x axis.
    fn circle(&mut self, frame: Frame3, radius: f64) -> EdgeId {
        let vertex = self.vertex(frame.origin + frame.x * radius);
        self.edge(NurbsCurve3::arc(&frame, radius, radius, 0.0, TAU), CurveKind::Circle, vertex, vertex)
    }

    fn start_of(&self, edge: EdgeId) -> VertexId {
        self.0.edges[edge.index()].start
    }

    /// A closed loop of straight edges through `corners`.
    fn polygon(&mut self, corners: &[DVec3]) -> Vec<Coedge> {
        let vertices: Vec<VertexId> = corners.iter().map(|&corner| self.vertex(corner)).collect();
        let next = |k: usize| vertices[(k + 1) % vertices.len()];
        (0..vertices.len()).map(|k| along(self.line(vertices[k], next(k)))).collect()
    }

    fn face(&mut self, surface: Surface, loops: Vec<Vec<Coedge>>, reversed: bool) {
        self.face_of(surface, loops.into_iter().map(Loop::Edges).collect(), reversed);
    }

    fn face_of(&mut self, surface: Surface, loops: Vec<Loop>, reversed: bool) {
        self.0.faces.push(Face { surface, loops, reversed, shell: 0, colour: None, name: String::new(), entity: 0 });
    }

    fn done(self) -> Part {
        self.0
    }
}
