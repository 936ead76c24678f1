//! Tiles to draws where each draw is a call: one per instance and page of vertices, from indices that are merged anew
//! when what is drawn changes. Needs no base vertex, which OpenGL ES 3.0 has not.

use super::super::gpu::Gpu;
use super::pages::Beside;
use super::rows::Rows;
use super::store::{Corners, Store, StoredTile};
use ::wgpu::{BufferUsages, IndexFormat, RenderPass};
use std::collections::BTreeMap;
use std::ops::Range;

/// The tiles of an instance in a page of vertices.
struct Draw {
    page: u32,
    place: u32,
    /// Range of the merged indices.
    indices: Range<u32>,
}

/// One draw per instance and page.
pub(super) struct MergedDraws {
    draws: Vec<Draw>,
    indices: Vec<u32>,
    rows: Rows,
    /// Sides of the triangles for the wireframe, two indices each, made on demand.
    sides: Option<Rows>,
}

impl MergedDraws {
    pub(super) fn new() -> Self {
        Self { draws: Vec::new(), indices: Vec::new(), rows: Rows::new(BufferUsages::INDEX), sides: None }
    }

    /// Rebuilds the list from tiles sorted by place. Returns the number of bytes uploaded.
    pub(super) fn refresh<'a>(&mut self, gpu: &Gpu, tiles: impl Iterator<Item = (u32, u32, &'a StoredTile)>) -> u64 {
        self.sides = None;
        let mut pages: BTreeMap<u32, (Vec<u32>, Vec<Draw>)> = BTreeMap::new();
        for (place, _, tile) in tiles {
            let Corners::InMemory(corners) = &tile.corners else { continue };
            let (page, base) = (tile.vertices.page, tile.vertices.start());
            let (indices, draws) = pages.entry(page).or_default();
            let start = indices.len() as u32;
            indices.extend(corners.iter().map(|corner| base + corner));
            let end = indices.len() as u32;
            match draws.last_mut().filter(|draw| draw.place == place) {
                Some(draw) => draw.indices.end = end,
                None => draws.push(Draw { page, place, indices: start..end }),
            }
        }
        self.draws.clear();
        self.indices.clear();
        for (indices, draws) in pages.into_values() {
            let before = self.indices.len() as u32;
            self.indices.extend(indices);
            self.draws.extend(
                draws
                    .into_iter()
                    .map(|draw| Draw { indices: draw.indices.start + before..draw.indices.end + before, ..draw }),
            );
        }
        self.rows.write(gpu, &self.indices, 0..self.indices.len())
    }

    pub(super) fn refresh_wires(&mut self, gpu: &Gpu) -> u64 {
        if self.sides.is_some() {
            return 0;
        }
        let sides = |corners: &[u32]| [0, 1, 1, 2, 2, 0].map(|k| corners[k]);
        let sides: Vec<u32> = self.indices.chunks_exact(3).flat_map(sides).collect();
        self.sides.insert(Rows::new(BufferUsages::INDEX)).write(gpu, &sides, 0..sides.len())
    }

    pub(super) fn draw(&self, pass: &mut RenderPass<'_>, store: &Store) {
        self.draw_from(pass, store, &self.rows, 1);
    }

    pub(super) fn draw_lattice(&self, pass: &mut RenderPass<'_>, store: &Store) {
        let has_cells = |draw: &Draw| store.vertices.beside_page(Beside::Cells, draw.page).is_some();
        if self.draws.iter().all(has_cells) {
            self.draw_from(pass, store, &self.rows, 1);
        }
    }

    pub(super) fn draw_wires(&self, pass: &mut RenderPass<'_>, store: &Store) {
        self.sides.iter().for_each(|sides| self.draw_from(pass, store, sides, 2));
    }

    /// Draws from `rows`, which have so many indices per corner.
    fn draw_from(&self, pass: &mut RenderPass<'_>, store: &Store, rows: &Rows, per_corner: u32) {
        let Some(rows) = rows.buffer().filter(|_| !self.draws.is_empty()) else { return };
        pass.set_index_buffer(rows.slice(..), IndexFormat::Uint32);
        let mut bound = None;
        for draw in &self.draws {
            if bound.replace(draw.page) != Some(draw.page) {
                pass.set_vertex_buffer(0, store.vertices.buffer(draw.page).slice(..));
                for (slot, what) in [(1, Beside::Tiles), (2, Beside::Cells)] {
                    if let Some(buffer) = store.vertices.beside_page(what, draw.page) {
                        pass.set_vertex_buffer(slot, buffer.slice(..));
                    }
                }
            }
            let range = per_corner * draw.indices.start..per_corner * draw.indices.end;
            pass.draw_indexed(range, 0, draw.place..draw.place + 1);
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.rows.bytes() + self.sides.as_ref().map_or(0, Rows::bytes)
    }
}
