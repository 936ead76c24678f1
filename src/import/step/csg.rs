//! Primitives of constructive solid geometry -> exact boundary representations.

use super::kinds::PRIMITIVES;
use super::place::Geometry;
use super::table::{Entity, Read, Trouble, out_of_range};
use super::values::Map;
use crate::model::{
    Coedge, EdgeId, Frame3, Loop, Part, PartBuilder, ShellKind, SolidTrouble, StepTrouble, Surface, VertexId,
};
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// Makes a part of a primitive, placed as in ISO 10303-42.
pub(super) fn primitive(geometry: &Geometry<'_>, item: Entity<'_>) -> Read<Part> {
    let id = item.id;
    let unread = || Trouble::new(id, StepTrouble::Unread { what: "the primitive" });
    let name = item.first_of(PRIMITIVES).ok_or_else(unread)?;
    let own = item.fields(name, 1);
    let size = |index: usize| -> Read<f64> {
        let value = geometry.length(own.real(index)?, id)?;
        if value > 0.0 { Ok(value) } else { Err(Trouble::new(id, out_of_range(format!("a {name} size"), value, "mm"))) }
    };
    let sizes = || -> Read<[f64; 3]> { Ok([size(1)?, size(2)?, size(3)?]) };
    let frame = || geometry.frame(own.reference(0)?);
    let corners = |count: usize| -> Read<Vec<DVec3>> {
        let corners = geometry.points(own.links(0)?)?;
        let fault = SolidTrouble::Corners { keyword: name, count: corners.len() };
        if corners.len() == count { Ok(corners) } else { Err(Trouble::new(id, fault)) }
    };
    let mut part = PartBuilder::new(String::new());
    let shell = part.plain_shell(ShellKind::Outer);
    match name {
        "BLOCK" => {
            let [x, y, z] = sizes()?;
            prism(&mut part, &frame()?, &[(0.0, 0.0), (x, 0.0), (x, y), (0.0, y)], z);
        }
        "RIGHT_ANGULAR_WEDGE" => {
            let [x, y, z] = sizes()?;
            let top = geometry.length(own.real(4)?, id)?;
            if !(0.0..x).contains(&top) {
                return Err(Trouble::new(id, SolidTrouble::Wedge { foot_mm: x, top_mm: top }));
            }
            let mut base = vec![(0.0, 0.0), (x, 0.0), (top, y), (0.0, y)];
            base.dedup();
            prism(&mut part, &frame()?, &base, z);
        }
        "RECTANGULAR_PYRAMID" => {
            let ([x, y, z], at) = (sizes()?, frame()?);
            let corners = [(0.0, 0.0, 0.0), (x, 0.0, 0.0), (x, y, 0.0), (0.0, y, 0.0), (0.5 * x, 0.5 * y, z)];
            let corners = corners.map(|p| at.place(p.into())).to_vec();
            polyhedron(&mut part, corners, &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]]);
        }
        "TETRAHEDRON" => {
            polyhedron(&mut part, corners(4)?, &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]]);
        }
        "CONVEX_HEXAHEDRON" => {
            let corners = corners(8)?;
            let sides: [[usize; 4]; 6] =
                [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
            if let Some(side) = sides.into_iter().find(|side| !flat(&corners, side)) {
                return Err(Trouble::new(id, SolidTrouble::SideNotPlane { corners: side }));
            }
            polyhedron(&mut part, corners, &sides.each_ref().map(|side| &side[..]));
        }
        "SPHERE" => {
            let (radius, origin) = (size(0)?, geometry.point(own.reference(1)?)?);
            let surface = Surface::Sphere { frame: Frame3 { origin, ..Frame3::WORLD }, radius };
            part.plain_face(surface, shell, Vec::new(), false);
        }
        "TORUS" => {
            let (major, minor) = (size(1)?, size(2)?);
            if minor >= major {
                return Err(Trouble::new(id, SolidTrouble::Torus { major_mm: major, minor_mm: minor }));
            }
            part.plain_face(Surface::Torus { frame: frame()?, major, minor }, shell, Vec::new(), false);
        }
        "RIGHT_CIRCULAR_CONE" | "RIGHT_CIRCULAR_CYLINDER" => {
            let is_cone = name == "RIGHT_CIRCULAR_CONE";
            let angle = if is_cone { own.real(3)? * geometry.units.angle } else { 0.0 };
            if is_cone && !(angle > 1e-12 && angle < FRAC_PI_2 - 1e-12) {
                return Err(Trouble::new(id, out_of_range("a cone semi-angle", angle, "radians")));
            }
            let (height, radius) = (size(1)?, geometry.length(own.real(2)?, id)?);
            if radius < 0.0 || (radius == 0.0 && angle == 0.0) {
                return Err(Trouble::new(id, out_of_range(format!("a {name} radius"), radius, "mm")));
            }
            barrel(&mut part, &frame()?, height, radius, angle);
        }
        _ => return Err(unread()),
    }
    part.finish().map_err(|error| Trouble::new(id, error))
}

/// Adds a cylinder or a frustum about the frame's axis, wider at its far end. A foot of radius 0 is an apex.
fn barrel(part: &mut PartBuilder, frame: &Frame3, height: f64, radius: f64, half_angle: f64) {
    let far = Frame3 { origin: frame.origin + frame.z * height, ..*frame };
    let wide = part.circle(&far, radius + height * libm::tan(half_angle));
    let side = if half_angle > 0.0 {
        Surface::Cone { frame: *frame, radius, half_angle }
    } else {
        Surface::Cylinder { frame: *frame, radius }
    };
    let foot = if radius > 0.0 {
        let narrow = part.circle(frame, radius);
        part.plain_face(Surface::Plane { frame: *frame }, 0, vec![Loop::Edges(vec![narrow.along()])], true);
        Loop::Edges(vec![narrow.along()])
    } else {
        Loop::Vertex(part.vertex(frame.origin))
    };
    part.plain_face(side, 0, vec![foot, Loop::Edges(vec![wide.against()])], false);
    part.plain_face(Surface::Plane { frame: far }, 0, vec![Loop::Edges(vec![wide.along()])], false);
}

/// Adds a prism over a counterclockwise polygon in the frame's plane, along the frame's axis.
fn prism(part: &mut PartBuilder, frame: &Frame3, base: &[(f64, f64)], height: f64) {
    let n = base.len();
    let level = |z: f64| base.iter().map(move |(x, y)| frame.place(DVec3::new(*x, *y, z)));
    let corners = level(0.0).chain(level(height)).collect();
    let mut sides: Vec<Vec<usize>> = vec![(0..n).rev().collect(), (n..2 * n).collect()];
    sides.extend((0..n).map(|k| vec![k, (k + 1) % n, n + (k + 1) % n, n + k]));
    polyhedron(part, corners, &sides.iter().map(Vec::as_slice).collect::<Vec<_>>());
}

/// Whether a polygon lies in the plane of its first three corners.
fn flat(corners: &[DVec3], side: &[usize]) -> bool {
    let [a, b, c] = [0, 1, 2].map(|k| corners[side[k]]);
    let normal = (b - a).cross(c - a).normalize_or_zero();
    side[3..].iter().all(|&k| (corners[k] - a).dot(normal).abs() <= 1e-6 * corners[k].distance(a))
}

/// Adds planar faces between corners, listed counterclockwise from outside.
fn polyhedron(part: &mut PartBuilder, corners: Vec<DVec3>, sides: &[&[usize]]) {
    let vertices: Vec<VertexId> = corners.iter().map(|corner| part.vertex(*corner)).collect();
    let mut edges = Map::default();
    for side in sides {
        facet(part, &mut edges, &vertices, [0, 1, 2].map(|k| corners[side[k]]), side);
    }
}

/// Adds a planar face around an outline, in the plane of three points. A degenerate one is left out; prepare reports
/// the open shell. `edges`: by ascending vertices.
pub(super) fn facet(
    part: &mut PartBuilder,
    edges: &mut Map<[usize; 2], EdgeId>,
    vertices: &[VertexId],
    [a, b, c]: [DVec3; 3],
    outline: &[usize],
) {
    let Some(frame) = Frame3::from_axis(a, (b - a).cross(c - a), b - a) else { return };
    let coedges = outline.iter().zip(outline.iter().cycle().skip(1)).map(|(&from, &to)| {
        let ends = [from.min(to), from.max(to)];
        let edge = *edges.entry(ends).or_insert_with(|| part.line(vertices[ends[0]], vertices[ends[1]]));
        Coedge { edge, reversed: from > to }
    });
    let bound = Loop::Edges(coedges.collect());
    part.plain_face(Surface::Plane { frame }, 0, vec![bound], false);
}
