//! Tessellated solids, shells and faces of AP242 to plane triangles that share their edges.
//!
//! Every triangle becomes a plane face: a model knows surfaces and edges only, and triangles that share corners then share
//! edges, so that the mesh is as closed as the file's, at any tolerance. Corners are one where their coordinates are the same
//! numbers, since each tessellated face may list its own.

use super::place::Geometry;
use super::table::{Fields, Instance, Map, Read, Trouble};
use crate::model::{Coedge, EdgeId, Frame3, Loop, Part, PartBuilder, ShellKind, Surface, VertexId};
use glam::{DAffine3, DVec3};
use std::collections::hash_map::Entry;
use step_io::parser::Attribute;

/// What is read here, bodies and loose faces.
pub(super) const KINDS: [&str; 8] = [
    "TESSELLATED_SOLID",
    "TESSELLATED_SHELL",
    "TESSELLATED_GEOMETRIC_SET",
    "TRIANGULATED_FACE",
    "COMPLEX_TRIANGULATED_FACE",
    "TRIANGULATED_SURFACE_SET",
    "COMPLEX_TRIANGULATED_SURFACE_SET",
    "REPOSITIONED_TESSELLATED_ITEM",
];

const FACES: [&str; 4] =
    ["TRIANGULATED_FACE", "COMPLEX_TRIANGULATED_FACE", "TRIANGULATED_SURFACE_SET", "COMPLEX_TRIANGULATED_SURFACE_SET"];

/// What holds the faces of a body, and in which attribute of which type.
const HOLDERS: [&str; 3] = ["TESSELLATED_SOLID", "TESSELLATED_SHELL", "TESSELLATED_GEOMETRIC_SET"];

/// The exact solid, shell or face that a tessellated one stands for.
pub(super) fn stands_for(item: Instance<'_>) -> Option<u64> {
    if let Some(name) = ["TESSELLATED_SOLID", "TESSELLATED_SHELL"].into_iter().find(|name| item.is(name)) {
        return item.fields(name, 1).optional(1);
    }
    let face = item.is("TRIANGULATED_FACE") || item.is("COMPLEX_TRIANGULATED_FACE");
    face.then(|| item.fields("TESSELLATED_FACE", 1).optional(3)).flatten()
}

/// The triangles of a body as a part of plane faces.
pub(super) fn triangles(geometry: &Geometry<'_>, item: Instance<'_>) -> Read<Part> {
    let mut mesh = Mesh { part: PartBuilder::new(String::new()), ..Mesh::default() };
    let solid = item.is("TESSELLATED_SOLID");
    mesh.part.plain_shell(if solid { ShellKind::Outer } else { ShellKind::Open });
    let faces = match HOLDERS.into_iter().find(|name| item.is(name)) {
        Some(name) => item.fields(name, 1).links(0)?.collect(),
        None => vec![item.id],
    };
    let place = if item.is("REPOSITIONED_TESSELLATED_ITEM") {
        let location = item.fields("REPOSITIONED_TESSELLATED_ITEM", 1).reference(0)?;
        geometry.motion(location)?
    } else {
        DAffine3::IDENTITY
    };
    for id in faces {
        let face = geometry.get(id)?;
        // Curves and points may stand beside the faces.
        if FACES.into_iter().any(|kind| face.is(kind)) {
            mesh.face(geometry, face, &place)?;
        }
    }
    if mesh.part.part().faces.is_empty() {
        return Err(Trouble::new(item.id, format!("{} without triangles", item.keyword())));
    }
    mesh.part.finish().map_err(|error| Trouble::new(item.id, error.to_string()))
}

#[derive(Default)]
struct Mesh {
    part: PartBuilder,
    corners: Map<[u64; 3], VertexId>,
    edges: Map<[VertexId; 2], EdgeId>,
    /// Coordinate lists by their number: faces share them.
    lists: Map<u64, Vec<DVec3>>,
}

impl Mesh {
    fn face(&mut self, geometry: &Geometry<'_>, face: Instance<'_>, place: &DAffine3) -> Read<()> {
        let set = face.is("TRIANGULATED_SURFACE_SET") || face.is("COMPLEX_TRIANGULATED_SURFACE_SET");
        let (base, inherited) = if set { ("TESSELLATED_SURFACE_SET", 4) } else { ("TESSELLATED_FACE", 5) };
        let list = face.fields(base, 1).reference(0)?;
        if let Entry::Vacant(fresh) = self.lists.entry(list) {
            fresh.insert(coordinates(geometry, list, place)?);
        }
        let name = FACES.into_iter().find(|kind| face.is(kind)).unwrap_or_default();
        let own = face.fields(name, inherited);
        // Numbers into the list of points that the face uses, or into the coordinates where it lists none.
        let used = own.counts(0)?;
        let points = self.lists.get(&list).map(Vec::as_slice).unwrap_or_default();
        let corner = |index: usize| -> Read<DVec3> {
            let index =
                if used.is_empty() { Some(index) } else { index.checked_sub(1).and_then(|i| used.get(i).copied()) };
            let point = index.and_then(|i| i.checked_sub(1)).and_then(|i| points.get(i).copied());
            point.ok_or_else(|| Trouble::new(face.id, "a triangle whose corner is not among the coordinates"))
        };
        let corners = if name.starts_with("COMPLEX") {
            let mut corners = Vec::new();
            for strip in lists_of(own, 1, face.id)? {
                for (k, w) in strip.windows(3).enumerate() {
                    corners.push(if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] });
                }
            }
            for fan in lists_of(own, 2, face.id)? {
                corners.extend(fan.windows(2).skip(1).map(|w| [fan[0], w[0], w[1]]));
            }
            corners
        } else {
            let rows = lists_of(own, 1, face.id)?;
            let triples = rows.iter().map(|row| <[usize; 3]>::try_from(row.as_slice()).ok());
            triples.collect::<Option<_>>().ok_or_else(|| Trouble::new(face.id, "a triangle without three corners"))?
        };
        let mut triangles = Vec::with_capacity(corners.len());
        for [a, b, c] in corners {
            triangles.push([corner(a)?, corner(b)?, corner(c)?]);
        }
        triangles.into_iter().for_each(|triangle| self.triangle(triangle));
        Ok(())
    }

    /// Adds a triangle as a face; one with two corners in one place closes nothing and is passed over.
    fn triangle(&mut self, corners: [DVec3; 3]) {
        let vertices = corners.map(|corner| self.corner(corner));
        let [a, b, c] = corners;
        if vertices[0] == vertices[1] || vertices[1] == vertices[2] || vertices[2] == vertices[0] {
            return;
        }
        // One whose corners are in a line has any plane through it.
        let normal = (b - a).cross(c - a).try_normalize().unwrap_or_else(|| (c - a).any_orthonormal_vector());
        let Some(frame) = Frame3::from_axis(a, normal, b - a) else { return };
        let coedges = [0, 1, 2].map(|k| self.side(vertices[k], vertices[(k + 1) % 3]));
        self.part.plain_face(Surface::Plane { frame }, 0, vec![Loop::Edges(coedges.to_vec())], false);
    }

    fn corner(&mut self, corner: DVec3) -> VertexId {
        // Adding zero makes one number of both zeros.
        let key = (corner + DVec3::ZERO).to_array().map(f64::to_bits);
        *self.corners.entry(key).or_insert_with(|| self.part.vertex(corner))
    }

    fn side(&mut self, from: VertexId, to: VertexId) -> Coedge {
        let reversed = from > to;
        let ends = if reversed { [to, from] } else { [from, to] };
        let edge = *self.edges.entry(ends).or_insert_with(|| self.part.line(ends[0], ends[1]));
        Coedge { edge, reversed, pcurve: None }
    }
}

/// The points of a `COORDINATES_LIST`, in millimetres and in place.
fn coordinates(geometry: &Geometry<'_>, id: u64, place: &DAffine3) -> Read<Vec<DVec3>> {
    let rows = geometry.get(id)?.fields("COORDINATES_LIST", 2).list(0)?;
    let point = |row: &Attribute| -> Read<DVec3> {
        let Attribute::List(row) = row else { return Err(Trouble::new(id, "coordinates that are no lists")) };
        Ok(place.transform_point3(geometry.triple(row, id)? * geometry.units.length))
    };
    rows.iter().map(point).collect()
}

/// A list of lists of numbers.
fn lists_of(own: Fields<'_>, index: usize, id: u64) -> Read<Vec<Vec<usize>>> {
    let numbers = |row: &Attribute| -> Option<Vec<usize>> {
        let Attribute::List(row) = row else { return None };
        row.iter()
            .map(|item| if let Attribute::Integer(value) = item { usize::try_from(*value).ok() } else { None })
            .collect()
    };
    let rows: Option<Vec<_>> = own.list(index)?.iter().map(numbers).collect();
    rows.ok_or_else(|| Trouble::new(id, "triangles that are no lists of whole numbers"))
}
