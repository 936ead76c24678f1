//! Small built-in models for tests, examples, and `builtin:NAME` on the command line. The crate `trimtess-models` of
//! this workspace adds larger ones.
//!
//! They cover the ways to bound a face: outer loops and holes, seams, two loops around a cylinder, an apex, no loops,
//! free-form borders, free trims. `pair` has two parts and coloured instances.

use super::{
    Coedge, CurveKind, EdgeId, Frame3, FreeTrims, Instance, Loop, Model, ModelBuilder, NurbsCurve, NurbsCurve2,
    NurbsSurface, Part, PartBuilder, ShellKind, Surface, TrimCurve, TrimRule, VertexId,
};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_4, TAU};

/// All names that [`by_name`] knows, roughly by increasing complexity.
pub const NAMES: &[&str] =
    &["square", "box", "cylinder", "washer", "cone", "sphere", "torus", "wave", "pair", "flower"];

/// Makes the shape of that name; `None` if the name is unknown.
///
/// ```
/// use trimtess::model::shapes;
/// assert!(shapes::NAMES.iter().all(|name| shapes::by_name(name).is_some()));
/// assert!(shapes::by_name("kettle").is_none());
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
        "flower" => flower(),
        "pair" => return Some(pair()),
        _ => return None,
    };
    Some(part.into())
}

/// A model of all shapes: the first part of each, placed once.
#[cfg(test)]
pub(crate) fn all() -> Model {
    let mut model = ModelBuilder::new("shapes");
    for name in NAMES {
        let part = model.part(by_name(name).expect("a name of a shape").parts.swap_remove(0));
        model.place(part, DAffine3::IDENTITY);
    }
    model.finish().expect(SOUND)
}

/// A plane square of side 20 about the origin with a hole of radius 6.
#[must_use]
pub fn square() -> Part {
    let mut part = solid("square", ShellKind::Open);
    let corners = [(-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)];
    let outer = part.polygon(&corners.map(|(x, y)| DVec3::new(x, y, 0.0)));
    let hole = part.circle(&Frame3::WORLD, 6.0);
    let hole = vec![hole.against()];
    face(&mut part, Surface::Plane { frame: Frame3::WORLD }, vec![outer, hole], false);
    part.finish().expect(SOUND)
}

/// A box of 30 × 20 × 10 in the first octant.
#[must_use]
pub fn cuboid() -> Part {
    let mut part = solid("box", ShellKind::Outer);
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
        (Some(edge), _) => Some(edge.along()),
        (_, Some(edge)) => Some(edge.against()),
        _ => None,
    };
    // Corners of each side, counter-clockwise from outside.
    for side in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        let [a, b, c, _] = side.map(corner);
        let coedges = (0..4).filter_map(|k| use_of(side[k], side[(k + 1) % 4])).collect();
        if let Some(frame) = Frame3::from_axis(a, (b - a).cross(c - a), b - a) {
            face(&mut part, Surface::Plane { frame }, vec![coedges], false);
        }
    }
    part.finish().expect(SOUND)
}

/// A cylinder about z of radius 5 and height 8, its side closed by a seam.
#[must_use]
pub fn cylinder() -> Part {
    let mut part = solid("cylinder", ShellKind::Outer);
    let top = Frame3 { origin: DVec3::Z * 8.0, ..Frame3::WORLD };
    let (low, high) = (part.circle(&Frame3::WORLD, 5.0), part.circle(&top, 5.0));
    let start = |edge: EdgeId| part.part().edges[edge.index()].start;
    let (foot, head) = (start(low), start(high));
    let seam = part.line(foot, head);
    let side = vec![low.along(), seam.along(), high.against(), seam.against()];
    face(&mut part, Surface::Cylinder { frame: Frame3::WORLD, radius: 5.0 }, vec![side], false);
    face(&mut part, Surface::Plane { frame: Frame3::WORLD }, vec![vec![low.along()]], true);
    face(&mut part, Surface::Plane { frame: top }, vec![vec![high.along()]], false);
    part.finish().expect(SOUND)
}

/// A washer about z of radii 6 and 10 and height 3; its sides have two loops each and no seam.
#[must_use]
pub fn washer() -> Part {
    let mut part = solid("washer", ShellKind::Outer);
    let top = Frame3 { origin: DVec3::Z * 3.0, ..Frame3::WORLD };
    let [inner, outer] = [6.0, 10.0].map(|radius| (part.circle(&Frame3::WORLD, radius), part.circle(&top, radius)));
    let sides = |(low, high): (EdgeId, EdgeId)| vec![vec![low.along()], vec![high.against()]];
    face(&mut part, Surface::Cylinder { frame: Frame3::WORLD, radius: 10.0 }, sides(outer), false);
    face(&mut part, Surface::Cylinder { frame: Frame3::WORLD, radius: 6.0 }, sides(inner), true);
    face(
        &mut part,
        Surface::Plane { frame: Frame3::WORLD },
        vec![vec![outer.0.along()], vec![inner.0.against()]],
        true,
    );
    face(&mut part, Surface::Plane { frame: top }, vec![vec![outer.1.along()], vec![inner.1.against()]], false);
    part.finish().expect(SOUND)
}

/// A cone about z of base radius 5 and height 5; its side is bounded by the base circle and the apex.
#[must_use]
pub fn cone() -> Part {
    let mut part = solid("cone", ShellKind::Outer);
    let base = part.circle(&Frame3::WORLD, 5.0);
    let apex = part.vertex(DVec3::Z * 5.0);
    let side = Surface::Cone { frame: Frame3::WORLD, radius: 5.0, half_angle: -FRAC_PI_4 };
    part.plain_face(side, 0, vec![Loop::Edges(vec![base.along()]), Loop::Vertex(apex)], false);
    face(&mut part, Surface::Plane { frame: Frame3::WORLD }, vec![vec![base.along()]], true);
    part.finish().expect(SOUND)
}

/// A sphere of radius 5 about the origin, without loops.
#[must_use]
pub fn sphere() -> Part {
    let mut part = solid("sphere", ShellKind::Outer);
    face(&mut part, Surface::Sphere { frame: Frame3::WORLD, radius: 5.0 }, Vec::new(), false);
    part.finish().expect(SOUND)
}

/// A torus about z of radii 8 and 3, without loops.
#[must_use]
pub fn torus() -> Part {
    let mut part = solid("torus", ShellKind::Outer);
    face(&mut part, Surface::Torus { frame: Frame3::WORLD, major: 8.0, minor: 3.0 }, Vec::new(), false);
    part.finish().expect(SOUND)
}

/// Control points of the bicubic sheet of [`wave`] and [`flower`].
fn sheet_point(i: usize, j: usize) -> DVec3 {
    const HEIGHTS: [[f64; 4]; 4] =
        [[0.0, 2.0, -1.0, 0.0], [3.0, -4.0, 5.0, 1.0], [-2.0, 6.0, -3.0, 2.0], [0.0, 1.0, 3.0, -1.0]];
    DVec3::new(4.0 * i as f64 - 6.0, 4.0 * j as f64 - 6.0, HEIGHTS[i][j])
}

fn sheet() -> NurbsSurface {
    let points = (0..4).flat_map(|i| (0..4).map(move |j| sheet_point(i, j))).collect();
    NurbsSurface::bezier((3, 3), points, Vec::new())
}

/// A bicubic sheet over a square of side 12, bounded by edges along its borders.
#[must_use]
pub fn wave() -> Part {
    let mut part = solid("wave", ShellKind::Open);
    let point = sheet_point;
    let [a, b, c, d] = [(0, 0), (3, 0), (3, 3), (0, 3)].map(|(i, j)| part.vertex(point(i, j)));
    let mut border = |points: [DVec3; 4], start, end| {
        part.curve(NurbsCurve::bezier(points.to_vec(), Vec::new()), CurveKind::Spline, start, end)
    };
    let ks = [0, 1, 2, 3];
    let south = border(ks.map(|k| point(k, 0)), a, b);
    let east = border(ks.map(|k| point(3, k)), b, c);
    let north = border(ks.map(|k| point(k, 3)), d, c);
    let west = border(ks.map(|k| point(0, k)), a, d);
    let boundary = vec![south.along(), east.along(), north.against(), west.against()];
    face(&mut part, Surface::Nurbs(sheet()), vec![boundary], false);
    part.finish().expect(SOUND)
}

/// The sheet of [`wave`] with free trims, which cut out a flower, a disk that crosses a petal, and a corner (by an open
/// curve).
#[must_use]
pub fn flower() -> Part {
    const PETALS: usize = 6;
    let mut part = solid("flower", ShellKind::Open);
    // A closed B-spline whose control points lie on two circles, two on each in turn.
    let control = |k: usize| {
        let radius = if k % 4 < 2 { 0.36 } else { 0.14 };
        DVec2::splat(0.47) + DVec2::from_angle(TAU * (k % (4 * PETALS)) as f64 / (4 * PETALS) as f64) * radius
    };
    let petals = TrimCurve::nurbs(NurbsCurve2 {
        degree: 3,
        knots: (0..4 * PETALS + 7).map(|k| k as f64).collect(),
        points: (0..4 * PETALS + 3).map(control).collect(),
        weights: Vec::new(),
    });
    let disk = TrimCurve::circle(DVec2::new(0.58, 0.76), 0.09);
    let corner = [(0.7, 0.0), (0.8, 0.25), (1.0, 0.15)].map(DVec2::from).to_vec();
    let curves = vec![petals.reversed(), disk.reversed(), TrimCurve::bezier(corner, Vec::new())];
    part.trimmed_face(Surface::Nurbs(sheet()), 0, FreeTrims { rule: TrimRule::Handedness, curves }, false);
    part.finish().expect(SOUND)
}

/// Two instances of a washer with a cylinder in them, in three colours.
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
        model.instance(Instance { colour: Some(colour), ..Instance::new(part, transform) });
    }
    model.finish().expect(SOUND)
}

const SOUND: &str = "built-in shapes are valid";

/// Starts a part with one shell, number 0.
fn solid(name: &str, kind: ShellKind) -> PartBuilder {
    let mut part = PartBuilder::new(name);
    part.plain_shell(kind);
    part
}

fn face(part: &mut PartBuilder, surface: Surface, loops: Vec<Vec<Coedge>>, reversed: bool) {
    part.plain_face(surface, 0, loops.into_iter().map(Loop::Edges).collect(), reversed);
}
