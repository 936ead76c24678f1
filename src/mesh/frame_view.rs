//! A finished frame, borrowed: what checks, audits and writers read, whether it is stored tile by tile or part by part.

use super::{EdgeLine, MemorySink, Origin, Scene, TileMesh};
use crate::model::{FaceId, PartId, TileId};
use glam::{DVec3, Vec2, Vec3};

/// The triangles of one tile, as vertex indices within the tile.
#[derive(Clone, Copy, Debug, Default)]
pub struct Triangles<'a> {
    corners: &'a [[u32; 3]],
    /// Index of the tile's first vertex, which `corners` count from 0.
    first: u32,
}

impl<'a> Triangles<'a> {
    /// Number of triangles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Whether there are no triangles.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// The corners of each triangle, counter-clockwise seen from outside.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = [u32; 3]> + Clone + use<'a> {
        let first = self.first;
        self.corners.iter().map(move |corners| corners.map(|corner| corner.wrapping_sub(first)))
    }
}

/// The mesh of one tile, borrowed. Fields are those of [`TileMesh`].
#[derive(Clone, Copy, Debug, Default)]
pub struct TileView<'a> {
    /// Positions, millimetres, part coordinates.
    pub positions: &'a [DVec3],
    /// Unit normals that point outwards.
    pub normals: &'a [Vec3],
    /// Parameters of each vertex, in the surface's natural parametrisation.
    pub uvs: &'a [Vec2],
    /// Where each vertex came from.
    pub origins: &'a [Origin],
    /// Triangles.
    pub triangles: Triangles<'a>,
}

impl<'a> TileView<'a> {
    /// A tile within lists of a part. `corners` count vertices from `first` vertices before this tile's own.
    pub(super) fn within(self, corners: &'a [[u32; 3]], first: u32) -> Self {
        Self { triangles: Triangles { corners, first }, ..self }
    }

    /// Whether all vertices have parameters and origins, and all triangles vertices.
    fn is_measurable(&self) -> bool {
        let count = self.positions.len();
        let has_lists = self.uvs.len() == count && self.origins.len() == count;
        has_lists && self.triangles.iter().flatten().all(|corner| (corner as usize) < count)
    }
}

impl<'a> From<&'a TileMesh> for TileView<'a> {
    fn from(mesh: &'a TileMesh) -> Self {
        let TileMesh { positions, normals, uvs, origins, triangles, .. } = mesh;
        Self { positions, normals, uvs, origins, triangles: Triangles { corners: triangles, first: 0 } }
    }
}

/// One tile's triangles and where they belong, borrowed.
#[derive(Clone, Copy, Debug)]
pub struct BatchView<'a> {
    /// The part.
    pub part: PartId,
    /// The face within the part.
    pub face: FaceId,
    /// The tile within the part.
    pub tile: TileId,
    /// The triangles.
    pub mesh: TileView<'a>,
}

impl<'a> From<&'a super::Batch> for BatchView<'a> {
    fn from(batch: &'a super::Batch) -> Self {
        Self { part: batch.part, face: batch.face, tile: batch.tile, mesh: (&batch.mesh).into() }
    }
}

/// A finished frame, borrowed from a [`MemorySink`] or a [`PackedFrame`](super::PackedFrame).
#[derive(Clone, Debug)]
pub struct FrameView<'a> {
    /// Parts and instances.
    pub scene: &'a Scene,
    /// Batches with triangles, sorted by (part, tile).
    pub batches: Vec<BatchView<'a>>,
    /// Edge polylines, sorted by (part, edge).
    pub edge_lines: &'a [EdgeLine],
}

impl<'a> FrameView<'a> {
    /// For each part, whether each of its faces has triangles. O(batches + faces).
    #[must_use]
    pub fn meshed(&self) -> Vec<Vec<bool>> {
        let mut meshed: Vec<Vec<bool>> =
            self.scene.parts.iter().map(|part| vec![false; part.face_colours.len()]).collect();
        for batch in self.batches.iter().filter(|batch| !batch.mesh.triangles.is_empty()) {
            let face = meshed.get_mut(batch.part.index()).and_then(|faces| faces.get_mut(batch.face.index()));
            face.into_iter().for_each(|face| *face = true);
        }
        meshed
    }

    /// Leaves out the tiles of which nothing can be measured, for lack of parameters, origins or vertices.
    pub(crate) fn measurable(mut self) -> Self {
        self.batches.retain(|batch| batch.mesh.is_measurable());
        self
    }

    /// Groups batches by part, keeping their order.
    pub(crate) fn batches_by_part(&self) -> Vec<Vec<&BatchView<'a>>> {
        self.by_part(&self.batches, |batch| batch.part)
    }

    /// Groups items by part, keeping their order. Items of unknown parts are dropped.
    pub(crate) fn by_part<'b, T>(&self, items: &'b [T], part: impl Fn(&T) -> PartId) -> Vec<Vec<&'b T>> {
        let mut parts: Vec<Vec<&T>> = self.scene.parts.iter().map(|_| Vec::new()).collect();
        for item in items {
            if let Some(of_part) = parts.get_mut(part(item).index()) {
                of_part.push(item);
            }
        }
        parts
    }
}

impl<'a> From<&'a MemorySink> for FrameView<'a> {
    fn from(frame: &'a MemorySink) -> Self {
        let batches = frame.batches.iter().map(Into::into).collect();
        Self { scene: &frame.scene, batches, edge_lines: &frame.edge_lines }
    }
}

/// Lets a view be used where one can be made. Copies a row per batch, no triangles.
impl<'a> From<&FrameView<'a>> for FrameView<'a> {
    fn from(frame: &FrameView<'a>) -> Self {
        frame.clone()
    }
}
