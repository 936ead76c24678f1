//! Tiles to bytes: 16 per vertex (octahedral normals, Meyer et al.), 2 per index in tiles of up to 65535 vertices, else
//! 4.

use super::super::layout::{CellPlace, Vertex};
use crate::mesh::{SHORT_VERTICES, TileMesh, octahedral};
use glam::DVec3;

/// Encoded tile. The buffers are reused.
#[derive(Default)]
pub(super) struct Encoded {
    pub(super) vertices: Vec<Vertex>,
    /// Pairs of two-byte indices, the first in the lower half (the last upper half may be unused), or indices of four
    /// bytes.
    pub(super) indices: Vec<u32>,
    pub(super) triangles: u32,
    /// Whether indices have four bytes.
    pub(super) wide: bool,
}

impl Encoded {
    /// Encodes `mesh` with positions relative to `centre`. Triangles with a missing vertex are skipped. Indices are in
    /// `pairs` where they fit.
    pub(super) fn tile(&mut self, mesh: &TileMesh, centre: DVec3, pairs: bool) {
        let count = mesh.positions.len();
        self.vertices.clear();
        self.vertices.extend(mesh.positions.iter().enumerate().map(|(index, &position)| Vertex {
            position: (position - centre).as_vec3().to_array(),
            normal: octahedral(mesh.normals.get(index).copied().unwrap_or_default()),
        }));
        self.indices.clear();
        self.wide = !pairs || count > SHORT_VERTICES;
        let sound = mesh.triangles.iter().filter(|corners| corners.iter().all(|&corner| (corner as usize) < count));
        let mut corners = sound.flatten().copied();
        if self.wide {
            self.indices.extend(corners);
            self.triangles = (self.indices.len() / 3) as u32;
            return;
        }
        let mut written = 0;
        while let Some(low) = corners.next() {
            let high = corners.next();
            written += 1 + u32::from(high.is_some());
            self.indices.push(low | high.unwrap_or(0) << 16);
        }
        self.triangles = written / 3;
    }
}

/// Lattice positions of a tile's vertices; all zero if the tile has no lattice.
pub(super) fn cells(mesh: &TileMesh) -> impl Iterator<Item = CellPlace> {
    let at = |lines: &[f32], x: f32| {
        let upwards = lines.first() <= lines.last();
        let below = lines.partition_point(|&line| if upwards { line <= x } else { line >= x });
        let Some(cell) = below.clamp(1, lines.len().max(2) - 1).checked_sub(1) else { return 0.0 };
        let (Some(low), Some(high)) = (lines.get(cell), lines.get(cell + 1)) else { return 0.0 };
        cell as f32 + ((x - low) / (high - low)).clamp(0.0, 1.0)
    };
    (0..mesh.positions.len()).map(move |k| {
        let uv = mesh.uvs.get(k).copied().unwrap_or_default();
        [at(&mesh.lines[0], uv.x), at(&mesh.lines[1], uv.y)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn lattice_positions_count_cells() {
        let uvs = [[0.0, 5.0], [1.0, 4.0], [2.0, 2.0], [10.0, 1.0], [11.0, 0.0]].map(Vec2::from).to_vec();
        let lines = [vec![0.0, 2.0, 10.0], vec![5.0, 3.0, 1.0]];
        let mesh = TileMesh { positions: vec![DVec3::ZERO; 5], uvs, lines, ..TileMesh::default() };
        let places: Vec<CellPlace> = cells(&mesh).collect();
        assert_eq!(places, [[0.0, 0.0], [0.5, 0.5], [1.0, 1.5], [2.0, 2.0], [2.0, 2.0]]);
        let without = TileMesh { lines: [vec![1.0], Vec::new()], ..mesh };
        assert_eq!(cells(&without).collect::<Vec<_>>(), [[0.0; 2]; 5]);
    }

    #[test]
    fn indices_are_packed_in_pairs_and_bad_triangles_skipped() {
        let mut encoded = Encoded::default();
        let mut mesh = TileMesh { positions: vec![DVec3::ONE; 4], ..TileMesh::default() };
        mesh.triangles = vec![[0, 1, 2], [1, 2, 4], [3, 2, 1], [0, 2, 3]];
        encoded.tile(&mesh, DVec3::ONE, true);
        assert_eq!((encoded.triangles, encoded.wide, encoded.vertices.len()), (3, false, 4));
        assert_eq!(encoded.indices, [0x1_0000, 0x3_0002, 0x1_0002, 0x2_0000, 3]);
        assert_eq!(encoded.vertices[0].position, [0.0; 3]);
        mesh.positions = vec![DVec3::ONE; 65_535];
        mesh.triangles = vec![[0, 1, 65_534]];
        encoded.tile(&mesh, DVec3::ZERO, true);
        assert_eq!((&encoded.indices[..], encoded.triangles, encoded.wide), (&[0x1_0000, 65_534][..], 1, false));
        mesh.positions.push(DVec3::ONE);
        mesh.triangles = vec![[0, 1, 65_535]];
        encoded.tile(&mesh, DVec3::ZERO, true);
        assert_eq!((&encoded.indices[..], encoded.triangles, encoded.wide), (&[0, 1, 65_535][..], 1, true));
        assert_eq!(size_of::<Vertex>(), 16);
        mesh.positions.truncate(4);
        mesh.triangles = vec![[0, 1, 2]];
        encoded.tile(&mesh, DVec3::ZERO, false);
        assert_eq!((&encoded.indices[..], encoded.triangles, encoded.wide), (&[0, 1, 2][..], 1, true));
    }
}
