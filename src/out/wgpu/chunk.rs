//! Placed batches to vertex, index and line buffers of bounded size: f64 in the world, rounded to f32 about the scene's centre.

use super::palette::Srgb;
use crate::mesh::PatchMesh;
use crate::out::placed::Placement;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Most vertices, triangles and segments in a chunk: 28, 12 and 32 MiB, well below the 256 MiB that every
/// adapter grants. Smaller chunks cost more passes, larger ones more memory beside the frame itself.
const LIMIT: usize = 1 << 20;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct Vertex {
    pub(super) position: [f32; 3],
    pub(super) normal: [f32; 3],
    pub(super) colour: Srgb,
}

/// A line segment; drawn as a strip of constant width on the screen.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct Segment {
    pub(super) from: [f32; 3],
    pub(super) to: [f32; 3],
    pub(super) colour: Srgb,
    /// Pixels.
    pub(super) width: f32,
}

/// How lines look.
#[derive(Clone, Copy)]
pub(super) struct Pen {
    pub(super) colour: Srgb,
    pub(super) width: f32,
}

/// What one pass draws.
#[derive(Default)]
pub(super) struct Chunk {
    pub(super) vertices: Vec<Vertex>,
    pub(super) indices: Vec<u32>,
    pub(super) segments: Vec<Segment>,
}

impl Chunk {
    pub(super) fn clear(&mut self) {
        self.vertices.clear();
        self.indices.clear();
        self.segments.clear();
    }

    pub(super) fn is_empty(&self) -> bool {
        self.indices.is_empty() && self.segments.is_empty()
    }
}

/// Fills chunks and hands each full one to `draw`.
pub(super) struct Chunks<'a, E> {
    chunk: Chunk,
    centre: DVec3,
    draw: &'a mut dyn FnMut(&Chunk) -> Result<(), E>,
}

impl<'a, E> Chunks<'a, E> {
    pub(super) fn new(centre: DVec3, draw: &'a mut dyn FnMut(&Chunk) -> Result<(), E>) -> Self {
        Self { chunk: Chunk::default(), centre, draw }
    }

    /// Adds the triangles of a tile. Those that name a missing vertex are passed over.
    pub(super) fn surface(&mut self, mesh: &PatchMesh, placement: &Placement, colour: Srgb) -> Result<(), E> {
        let centre = self.centre;
        let vertex = |index: usize| Vertex {
            position: (placement.position(mesh.positions[index]) - centre).as_vec3().to_array(),
            normal: placement.normal(mesh.normals.get(index).copied().unwrap_or_default()).as_vec3().to_array(),
            colour,
        };
        let sound = |corners: &&[u32; 3]| corners.iter().all(|corner| (*corner as usize) < mesh.positions.len());
        if mesh.positions.len() <= LIMIT && mesh.triangles.len() <= LIMIT {
            self.make_room(mesh.positions.len(), mesh.triangles.len(), 0)?;
            let base = self.chunk.vertices.len() as u32;
            self.chunk.vertices.extend((0..mesh.positions.len()).map(vertex));
            let corners = mesh.triangles.iter().filter(sound).flat_map(|corners| placement.winding(*corners));
            self.chunk.indices.extend(corners.map(|corner| base + corner));
            return Ok(());
        }
        // A tile too large for one chunk is cut into triangles with corners of their own.
        for run in mesh.triangles.chunks(LIMIT / 3) {
            self.make_room(3 * run.len(), run.len(), 0)?;
            let base = self.chunk.vertices.len() as u32;
            let corners = run.iter().filter(sound).flat_map(|corners| placement.winding(*corners));
            self.chunk.vertices.extend(corners.map(|corner| vertex(corner as usize)));
            self.chunk.indices.extend(base..self.chunk.vertices.len() as u32);
        }
        Ok(())
    }

    /// Adds each triangle edge of a tile once.
    pub(super) fn wireframe(&mut self, mesh: &PatchMesh, placement: &Placement, pen: Pen) -> Result<(), E> {
        let edges = mesh.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let mut edges: Vec<_> = edges.map(|(a, b)| (a.min(b), a.max(b))).collect();
        edges.sort_unstable();
        edges.dedup();
        let point = |index: u32| mesh.positions.get(index as usize).copied();
        self.segments(edges.iter().filter_map(|&(a, b)| Some([point(a)?, point(b)?])), placement, pen)
    }

    /// Adds a polyline.
    pub(super) fn polyline(&mut self, points: &[DVec3], placement: &Placement, pen: Pen) -> Result<(), E> {
        self.segments(points.windows(2).map(|ends| [ends[0], ends[1]]), placement, pen)
    }

    fn segments(
        &mut self,
        segments: impl Iterator<Item = [DVec3; 2]>,
        placement: &Placement,
        Pen { colour, width }: Pen,
    ) -> Result<(), E> {
        for ends in segments {
            self.make_room(0, 0, 1)?;
            let [from, to] = ends.map(|point| (placement.position(point) - self.centre).as_vec3().to_array());
            self.chunk.segments.push(Segment { from, to, colour, width });
        }
        Ok(())
    }

    /// Draws what is left.
    pub(super) fn finish(mut self) -> Result<(), E> {
        self.flush()
    }

    fn make_room(&mut self, vertices: usize, triangles: usize, segments: usize) -> Result<(), E> {
        let full = self.chunk.vertices.len() + vertices > LIMIT
            || self.chunk.indices.len() + 3 * triangles > 3 * LIMIT
            || self.chunk.segments.len() + segments > LIMIT;
        if full { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), E> {
        if !self.chunk.is_empty() {
            (self.draw)(&self.chunk)?;
        }
        self.chunk.clear();
        Ok(())
    }
}
