//! A frame with arrays per part -> one set of arrays in world coordinates.

use super::packed::PackedFrame;
use super::placement::Placement;
use crate::model::FaceId;
use glam::{DVec3, Vec2, Vec3};

/// All instances of a frame as one mesh in world coordinates.
///
/// `positions`, `normals` and `uvs` have a row per vertex, `triangles` and `face_ids` a row per triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlatMesh {
    /// Positions, millimetres, world coordinates. Those of a PLY file.
    pub positions: Vec<DVec3>,
    /// Unit normals that point outwards, also of mirrored instances.
    pub normals: Vec<Vec3>,
    /// Parameters of each vertex, in the natural parametrisation of its face's surface.
    pub uvs: Vec<Vec2>,
    /// Indices into `positions`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Face of each triangle, numbered across all instances
    /// ([`SceneInstance::face_number`](super::SceneInstance::face_number)).
    pub face_ids: Vec<u32>,
    /// Points of all edge polylines, one after the other.
    pub edge_points: Vec<DVec3>,
    /// Where each polyline starts in `edge_points`, then the end: one row more than there are polylines.
    pub edge_starts: Vec<u64>,
}

/// The instances have too many vertices for 32-bit indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{vertices} vertices exceed 32-bit indices")]
pub struct TooManyVertices {
    /// Vertices of all instances.
    pub vertices: u64,
}

impl FlatMesh {
    /// Places all instances of `frame`, in the order of the scene. O(placed triangles); allocates the result once.
    ///
    /// # Errors
    /// If the placed vertices are too many for 32-bit indices.
    pub fn of(frame: &PackedFrame) -> Result<Self, TooManyVertices> {
        let placed = || frame.scene.instances.iter().filter_map(|i| Some((i, frame.parts.get(i.part.index())?)));
        let vertices: usize = placed().map(|(_, part)| part.positions.len()).sum();
        let triangles: usize = placed().map(|(_, part)| part.triangles.len()).sum();
        if u32::try_from(vertices).is_err() {
            return Err(TooManyVertices { vertices: vertices as u64 });
        }
        let mut flat = Self {
            positions: Vec::with_capacity(vertices),
            normals: Vec::with_capacity(vertices),
            uvs: Vec::with_capacity(vertices),
            triangles: Vec::with_capacity(triangles),
            face_ids: Vec::with_capacity(triangles),
            edge_points: Vec::new(),
            edge_starts: vec![0],
        };
        for (instance, part) in placed() {
            let placement = Placement::new(&instance.transform);
            #[allow(clippy::cast_possible_truncation, reason = "checked above")]
            let first = flat.positions.len() as u32;
            flat.positions.extend(part.positions.iter().map(|&point| placement.position(point)));
            flat.normals.extend(part.normals.iter().map(|&normal| placement.normal(normal).as_vec3()));
            flat.uvs.extend_from_slice(&part.uvs);
            let corners = part.triangles.iter().map(|&corners| placement.winding(corners));
            flat.triangles.extend(corners.map(|corners| corners.map(|corner| corner.wrapping_add(first))));
            flat.face_ids.extend(part.face_ids.iter().map(|&face| instance.face_number(FaceId(face))));
            for line in frame.edge_lines_of(instance.part) {
                flat.edge_points.extend(line.points.iter().map(|&point| placement.position(point)));
                flat.edge_starts.push(flat.edge_points.len() as u64);
            }
        }
        Ok(flat)
    }
}
