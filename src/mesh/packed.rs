//! A frame to flat arrays: one per part, in its coordinates, or one for the whole scene, with every instance in the
//! world.

use super::frame_view::{BatchView, FrameView, TileView};
use super::{Batch, EdgeLine, MeshSink, Origin, Scene, SinkError, TileMesh};
use crate::model::{FaceId, PartId, TileId};
use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};

/// The mesh of one part: the tiles' lists, one after the other.
///
/// `positions`, `normals`, `uvs` and `origins` have a row per vertex, `triangles` and `face_ids` a row per triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PartMesh {
    /// Positions, millimetres, part coordinates. Tiles do not share vertices; equal points have equal bits.
    pub positions: Vec<DVec3>,
    /// Unit normals that point outwards.
    pub normals: Vec<Vec3>,
    /// Parameters of each vertex, in the natural parametrisation of its face's surface.
    pub uvs: Vec<Vec2>,
    /// Where each vertex came from.
    pub origins: Vec<Origin>,
    /// Indices into `positions`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Face of each triangle, as index within the part.
    pub face_ids: Vec<u32>,
    tiles: Vec<TileRow>,
}

/// Where a tile's lists end. They begin where those of the tile before end.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TileRow {
    face: FaceId,
    tile: TileId,
    vertices: usize,
    triangles: usize,
}

/// A sink that keeps the last frame in memory, as arrays per part. Takes whole frames only.
///
/// Needs no more memory than [`MemorySink`](super::MemorySink): tiles are released as they are copied.
#[derive(Clone, Debug, Default)]
pub struct PackedFrame {
    /// The scene of the frame.
    pub scene: Scene,
    /// The mesh of each part of the scene.
    pub parts: Vec<PartMesh>,
    /// Edge polylines, sorted by (part, edge).
    pub edge_lines: Vec<EdgeLine>,
}

impl PackedFrame {
    /// Edge polylines of a part, ascending by edge.
    #[must_use]
    pub fn edge_lines_of(&self, part: PartId) -> &[EdgeLine] {
        lines_of(&self.edge_lines, part)
    }
}

/// The lines of a part. `lines`: ascending by part.
pub(super) fn lines_of(lines: &[EdgeLine], part: PartId) -> &[EdgeLine] {
    let of_part = &lines[lines.partition_point(|line| line.part < part)..];
    &of_part[..of_part.partition_point(|line| line.part == part)]
}

impl PartMesh {
    /// Appends a tile. Fails if vertices are too many for 32-bit indices.
    fn push(&mut self, face: FaceId, tile: TileId, mesh: TileMesh) -> Result<(), std::io::Error> {
        let TileMesh { positions, normals, uvs, origins, triangles, .. } = mesh;
        let after = self.positions.len() + positions.len();
        let (Ok(first), true) = (u32::try_from(self.positions.len()), u32::try_from(after).is_ok()) else {
            return Err(std::io::Error::other(format!("{after} vertices exceed 32-bit indices")));
        };
        self.face_ids.resize(self.face_ids.len() + triangles.len(), face.0);
        self.triangles.extend(triangles.iter().map(|corners| corners.map(|corner| corner.wrapping_add(first))));
        drop(triangles);
        self.positions.extend(positions);
        self.normals.extend(normals);
        self.uvs.extend(uvs);
        self.origins.extend(origins);
        self.tiles.push(TileRow { face, tile, vertices: after, triangles: self.triangles.len() });
        Ok(())
    }

    /// The batches of this part, in the order in which they came.
    fn batches(&self, part: PartId) -> impl Iterator<Item = BatchView<'_>> {
        let mut start = (0, 0);
        self.tiles.iter().map(move |&TileRow { face, tile, vertices, triangles }| {
            let (rows, corners) = (start.0..vertices, start.1..triangles);
            start = (vertices, triangles);
            let mesh = TileView {
                // Whoever has the lists may empty them, and hand-made sinks lack what checks do not need.
                positions: self.positions.get(rows.clone()).unwrap_or_default(),
                normals: self.normals.get(rows.clone()).unwrap_or_default(),
                uvs: self.uvs.get(rows.clone()).unwrap_or_default(),
                origins: self.origins.get(rows.clone()).unwrap_or_default(),
                ..TileView::default()
            };
            #[allow(clippy::cast_possible_truncation, reason = "`push` checked it")]
            let mesh = mesh.within(self.triangles.get(corners).unwrap_or_default(), rows.start as u32);
            BatchView { part, face, tile, mesh }
        })
    }
}

impl<'a> From<&'a PackedFrame> for FrameView<'a> {
    fn from(frame: &'a PackedFrame) -> Self {
        let parts = frame.parts.iter().enumerate();
        let batches = parts.flat_map(|(part, mesh)| mesh.batches(PartId::new(part))).collect();
        Self { scene: &frame.scene, batches, edge_lines: &frame.edge_lines }
    }
}

impl MeshSink for PackedFrame {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        let parts = vec![PartMesh::default(); scene.parts.len()];
        *self = Self { scene: scene.clone(), parts, edge_lines: Vec::new() };
        Ok(())
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        let Batch { part, face, tile, .. } = *batch;
        let mesh = std::mem::take(&mut batch.mesh);
        let known = self.parts.get_mut(part.index());
        known.map_or(Ok(()), |known| known.push(face, tile, mesh)).map_err(|cause| {
            let context = format!("part {} of {:?}", part.0, self.scene.name);
            SinkError::new(context, cause)
        })
    }

    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError> {
        self.edge_lines.push(line);
        Ok(())
    }

    fn end(&mut self) -> Result<(), SinkError> {
        for PartMesh { positions, normals, uvs, origins, triangles, face_ids, tiles } in &mut self.parts {
            positions.shrink_to_fit();
            normals.shrink_to_fit();
            uvs.shrink_to_fit();
            origins.shrink_to_fit();
            triangles.shrink_to_fit();
            face_ids.shrink_to_fit();
            tiles.shrink_to_fit();
        }
        Ok(())
    }

    fn abort(&mut self) {
        *self = Self::default();
    }
}

/// Part to world, for positions, normals and windings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    transform: DAffine3,
    /// The inverse transpose up to scale (the cofactor matrix, negated if mirrored). Outward normals stay outward.
    normals: DMat3,
    mirrored: bool,
}

impl Placement {
    pub(crate) fn new(transform: &DAffine3) -> Self {
        let m = transform.matrix3;
        let mirrored = m.determinant() < 0.0;
        let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let normals = if mirrored { -cofactors } else { cofactors };
        Self { transform: *transform, normals, mirrored }
    }

    /// The position in the world. Depends only on the bits of `point`: equal points stay equal. Never -0.0.
    pub(crate) fn position(&self, point: DVec3) -> DVec3 {
        self.transform.transform_point3(point) + DVec3::ZERO
    }

    /// The unit normal in the world; +z where the part's normal is zero.
    pub(crate) fn normal(&self, normal: glam::Vec3) -> DVec3 {
        (self.normals * normal.as_dvec3()).normalize_or(DVec3::Z)
    }

    /// Orders the corners counter-clockwise seen from outside.
    pub(crate) fn winding(&self, [a, b, c]: [u32; 3]) -> [u32; 3] {
        if self.mirrored { [a, c, b] } else { [a, b, c] }
    }
}

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
