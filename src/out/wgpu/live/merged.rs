//! Tiles to draws where each draw is a call: one per part and page of vertices, from indices that are rebuilt when what
//! is drawn changes. Needs no base vertex: OpenGL ES 3.0 has none.

use super::super::gpu::Gpu;
use super::pages::Companion;
use super::rows::Rows;
use super::store::{Corners, Store, StoredTile};
use super::surface_draw::{DrawCall, SurfaceDraw, encode_all};
use ::wgpu::{Buffer, BufferUsages, IndexFormat, RenderPass};
use std::collections::BTreeMap;
use std::ops::Range;

/// The tiles in a page of vertices that adjacent places show.
struct Draw {
    page: u32,
    places: Range<u32>,
    /// Range of the merged indices.
    indices: Range<u32>,
}

/// One draw per page, for all adjacent instances of a part that show the same tiles.
pub(super) struct MergedDraws {
    draws: Vec<Draw>,
    indices: Vec<u32>,
    rows: Rows,
    /// Sides of the triangles for the wireframe, two indices each, made on demand.
    sides: Option<Rows>,
}

/// Adjacent places, and the tiles that each of them shows.
type Alike<'a> = (Range<u32>, Vec<&'a StoredTile>);

/// Gathers adjacent places that show the same tiles, from tiles sorted by place.
fn alike<'a>(tiles: impl Iterator<Item = (u32, u32, &'a StoredTile)>) -> Vec<Alike<'a>> {
    let mut all: Vec<Alike<'a>> = Vec::new();
    let mut tiles = tiles.peekable();
    while let Some(&(place, _, _)) = tiles.peek() {
        let shown: Vec<_> =
            std::iter::from_fn(|| tiles.next_if(|tile| tile.0 == place)).map(|(_, _, tile)| tile).collect();
        // Tiles are the same if they are in the same memory: then their part is the same, too.
        let is_same = |(places, tiles): &&mut Alike<'a>| {
            places.end == place
                && tiles.len() == shown.len()
                && tiles.iter().zip(&shown).all(|(a, b)| std::ptr::eq(*a, *b))
        };
        match all.last_mut().filter(is_same) {
            Some((places, _)) => places.end += 1,
            None => all.push((place..place + 1, shown)),
        }
    }
    all
}

impl MergedDraws {
    pub(super) fn new() -> Self {
        Self { draws: Vec::new(), indices: Vec::new(), rows: Rows::new(BufferUsages::INDEX), sides: None }
    }

    /// Rebuilds the list from tiles sorted by place. Returns the number of bytes uploaded.
    pub(super) fn refresh<'a>(&mut self, gpu: &Gpu, tiles: impl Iterator<Item = (u32, u32, &'a StoredTile)>) -> u64 {
        self.sides = None;
        let mut pages: BTreeMap<u32, (Vec<u32>, Vec<Draw>)> = BTreeMap::new();
        for (places, tiles) in alike(tiles) {
            for tile in tiles {
                let Corners::InMemory(corners) = &tile.corners else { continue };
                let (page, base) = (tile.vertices.page, tile.vertices.start());
                let (indices, draws) = pages.entry(page).or_default();
                let start = indices.len() as u32;
                indices.extend(corners.iter().map(|corner| base + corner));
                let end = indices.len() as u32;
                match draws.last_mut().filter(|draw| draw.places == places) {
                    Some(draw) => draw.indices.end = end,
                    None => draws.push(Draw { page, places: places.clone(), indices: start..end }),
                }
            }
        }
        self.draws.clear();
        self.indices.clear();
        for (indices, draws) in pages.into_values() {
            let before = self.indices.len() as u32;
            self.indices.extend(indices);
            let moved = |draw: Draw| Draw { indices: draw.indices.start + before..draw.indices.end + before, ..draw };
            self.draws.extend(draws.into_iter().map(moved));
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

    /// Number of calls.
    pub(super) fn calls(&self) -> usize {
        self.draws.len()
    }

    /// The calls. Vertex buffer 1 has the number of each vertex's tile.
    pub(super) fn draws<'a>(&'a self, store: &'a Store) -> impl Iterator<Item = SurfaceDraw<'a>> {
        self.rows.buffer().into_iter().flat_map(|rows| self.draws_from(store, rows, 1))
    }

    pub(super) fn draw_wires(&self, pass: &mut RenderPass<'_>, store: &Store) {
        if let Some(sides) = self.sides.as_ref().and_then(Rows::buffer) {
            encode_all(pass, self.draws_from(store, sides, 2));
        }
    }

    /// The calls on `indices`, of which there are so many per corner.
    fn draws_from<'a>(
        &'a self,
        store: &'a Store,
        indices: &'a Buffer,
        per_corner: u32,
    ) -> impl Iterator<Item = SurfaceDraw<'a>> {
        self.draws.iter().filter_map(move |draw| {
            Some(SurfaceDraw {
                vertices: [
                    store.vertices.buffer(draw.page),
                    store.vertices.companion_of_page(Companion::Tiles, draw.page)?,
                ],
                indices,
                format: IndexFormat::Uint32,
                call: DrawCall::Direct {
                    indices: per_corner * draw.indices.start..per_corner * draw.indices.end,
                    instances: draw.places.clone(),
                },
                page: draw.page,
            })
        })
    }

    pub(super) fn bytes(&self) -> u64 {
        self.rows.bytes() + self.sides.as_ref().map_or(0, Rows::bytes)
    }
}
