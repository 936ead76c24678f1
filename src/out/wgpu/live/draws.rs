//! Tiles of a view to draws: one per tile of each instance where the device reads draws from a buffer, else one per
//! part and page of vertices. Polylines of edges to draws, the same in every view: one per part for all its instances.

use super::super::gpu::Gpu;
use super::super::pipelines::ROW_FORMAT;
use super::device_scene::DeviceScene;
use super::pages::Companion;
use super::records::Records;
use super::rows::{Rows, Texels, bind};
use super::store::{Corners, Store, StoredTile};
use ::wgpu::util::{DrawIndexedIndirectArgs, DrawIndirectArgs};
use ::wgpu::{BindGroup, BindingResource, Buffer, BufferUsages, IndexFormat, RenderPass};
use std::collections::BTreeMap;
use std::ops::Range;

/// One draw command of a scene's surfaces, for the caller's passes and render bundles. Its pipeline has the layouts
/// of [`SurfaceInput`](crate::out::wgpu::SurfaceInput), bind group 0 is
/// [`SceneInPass::bind_group`](super::SceneInPass::bind_group). Valid until the next frame ends or an instance is
/// hidden or shown.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SurfaceDraw<'a> {
    /// Vertex buffers 0 and 1, from their beginning.
    pub vertices: [&'a Buffer; 2],
    /// The index buffer, from its beginning.
    pub indices: &'a Buffer,
    /// Width of the indices.
    pub format: IndexFormat,
    /// The call.
    pub call: DrawCall<'a>,
    /// Page of `vertices[0]`.
    pub(super) page: u32,
}

/// The call of a [`SurfaceDraw`].
#[derive(Clone, Debug)]
pub enum DrawCall<'a> {
    /// `multi_draw_indexed_indirect`, a draw per tile of each instance. Render bundles take them one by one, by
    /// `draw_indexed_indirect`.
    Indirect {
        /// The draws, of 20 bytes each.
        draws: &'a Buffer,
        /// Bytes before the first of this call.
        offset: u64,
        /// Number of draws.
        count: u32,
    },
    /// `draw_indexed` without a base vertex: all tiles of a part that are in a page, for instances that show the same.
    Direct {
        /// Range of the index buffer.
        indices: Range<u32>,
        /// Range of instances, which shaders need as it is.
        instances: Range<u32>,
    },
}

impl SurfaceDraw<'_> {
    /// Sets what has changed since the draw `before`, and calls.
    pub(super) fn encode(&self, pass: &mut RenderPass<'_>, before: Option<&Self>) {
        for (slot, buffer) in self.vertices.into_iter().enumerate() {
            if before.is_none_or(|before| before.vertices[slot] != buffer) {
                pass.set_vertex_buffer(slot as u32, buffer.slice(..));
            }
        }
        if before.is_none_or(|before| before.indices != self.indices || before.format != self.format) {
            pass.set_index_buffer(self.indices.slice(..), self.format);
        }
        match &self.call {
            DrawCall::Indirect { draws, offset, count } => pass.multi_draw_indexed_indirect(draws, *offset, *count),
            DrawCall::Direct { indices, instances } => pass.draw_indexed(indices.clone(), 0, instances.clone()),
        }
    }
}

/// Encodes draws one after the other.
pub(super) fn encode_all<'a>(pass: &mut RenderPass<'_>, draws: impl Iterator<Item = SurfaceDraw<'a>>) {
    let mut before = None;
    for draw in draws {
        draw.encode(pass, before.as_ref());
        before = Some(draw);
    }
}

/// What one call draws from: page of vertices, page of indices, and whether indices have four bytes.
type PageKey = (u32, u32, bool);

/// One draw per tile of each instance.
struct TileDraws {
    groups: Vec<(PageKey, Range<u32>)>,
    draws: Vec<DrawIndexedIndirectArgs>,
    rows: Rows,
    /// The wireframe of the same tiles, made on demand.
    wires: Option<Wires>,
}

struct Wires {
    rows: Rows,
    groups: Vec<BindGroup>,
}

impl TileDraws {
    fn new() -> Self {
        Self { groups: Vec::new(), draws: Vec::new(), rows: Rows::new(BufferUsages::INDIRECT), wires: None }
    }

    /// Rebuilds the list. Returns the number of bytes uploaded.
    fn refresh<'a>(
        &mut self,
        gpu: &Gpu,
        tiles: impl Iterator<Item = (u32, u32, &'a StoredTile)>,
        records: &Records,
    ) -> u64 {
        self.wires = None;
        let mut groups: BTreeMap<PageKey, Vec<DrawIndexedIndirectArgs>> = BTreeMap::new();
        for (place, number, tile) in tiles {
            let Some((page, wide, first_index)) = tile.indices() else { continue };
            groups.entry((tile.vertices.page, page, wide)).or_default().push(DrawIndexedIndirectArgs {
                index_count: 3 * tile.triangles,
                instance_count: 1,
                first_index,
                base_vertex: tile.vertices.start() as i32,
                first_instance: records.row(place, number),
            });
        }
        self.groups.clear();
        self.draws.clear();
        for (pages, draws) in groups {
            let start = self.draws.len() as u32;
            self.draws.extend(draws);
            self.groups.push((pages, start..self.draws.len() as u32));
        }
        self.rows.write(gpu, &self.draws, 0..self.draws.len())
    }

    fn refresh_wires(&mut self, gpu: &Gpu, store: &Store) -> u64 {
        if self.wires.is_some() {
            return 0;
        }
        let sides = |draw: &DrawIndexedIndirectArgs| DrawIndirectArgs {
            vertex_count: 6 * draw.index_count,
            instance_count: 1,
            first_vertex: 0,
            first_instance: draw.first_instance,
        };
        let draws: Vec<_> = self.draws.iter().map(sides).collect();
        let group = |((vertices, indices, _), _): &(PageKey, Range<u32>)| {
            let buffers = [store.vertices.buffer(*vertices), store.indices.buffer(*indices)];
            let layout = gpu.pipelines.triangles.as_ref()?;
            Some(bind(gpu, layout, buffers.map(::wgpu::Buffer::as_entire_binding).into()))
        };
        let groups = self.groups.iter().filter_map(group).collect();
        let mut rows = Rows::new(BufferUsages::INDIRECT);
        let bytes = rows.write(gpu, &draws, 0..draws.len());
        self.wires = Some(Wires { rows, groups });
        bytes
    }

    /// The calls. Vertex buffer 1 has the records.
    fn draws<'a>(&'a self, store: &'a Store, records: &'a Buffer) -> impl Iterator<Item = SurfaceDraw<'a>> {
        let rows = self.rows.buffer();
        self.groups.iter().filter_map(move |((vertices, indices, wide), range)| {
            Some(SurfaceDraw {
                vertices: [store.vertices.buffer(*vertices), records],
                indices: store.indices.buffer(*indices),
                format: if *wide { IndexFormat::Uint32 } else { IndexFormat::Uint16 },
                call: DrawCall::Indirect {
                    draws: rows?,
                    offset: u64::from(range.start) * size_of::<DrawIndexedIndirectArgs>() as u64,
                    count: range.end - range.start,
                },
                page: *vertices,
            })
        })
    }

    fn draw_wires(&self, pass: &mut RenderPass<'_>) {
        let Some(wires) = &self.wires else { return };
        let Some(rows) = wires.rows.buffer() else { return };
        for ((_, range), group) in self.groups.iter().zip(&wires.groups) {
            pass.set_bind_group(2, group, &[]);
            let offset = u64::from(range.start) * size_of::<DrawIndirectArgs>() as u64;
            pass.multi_draw_indirect(rows, offset, range.end - range.start);
        }
    }
}

/// The tiles in a page of vertices that adjacent places show.
struct Draw {
    page: u32,
    places: Range<u32>,
    /// Range of the merged indices.
    indices: Range<u32>,
}

/// One draw per page, for all adjacent instances of a part that show the same tiles.
struct MergedDraws {
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
    fn new() -> Self {
        Self { draws: Vec::new(), indices: Vec::new(), rows: Rows::new(BufferUsages::INDEX), sides: None }
    }

    /// Rebuilds the list from tiles sorted by place. Returns the number of bytes uploaded.
    fn refresh<'a>(&mut self, gpu: &Gpu, tiles: impl Iterator<Item = (u32, u32, &'a StoredTile)>) -> u64 {
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

    fn refresh_wires(&mut self, gpu: &Gpu) -> u64 {
        if self.sides.is_some() {
            return 0;
        }
        let sides = |corners: &[u32]| [0, 1, 1, 2, 2, 0].map(|k| corners[k]);
        let sides: Vec<u32> = self.indices.chunks_exact(3).flat_map(sides).collect();
        self.sides.insert(Rows::new(BufferUsages::INDEX)).write(gpu, &sides, 0..sides.len())
    }

    /// The calls. Vertex buffer 1 has the number of each vertex's tile.
    fn draws<'a>(&'a self, store: &'a Store) -> impl Iterator<Item = SurfaceDraw<'a>> {
        self.rows.buffer().into_iter().flat_map(|rows| self.draws_from(store, rows, 1))
    }

    fn draw_wires(&self, pass: &mut RenderPass<'_>, store: &Store) {
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
}

/// Draw list of the tiles in one view.
pub(super) struct Tiles {
    /// The scene version this list was made for; 0 before the first.
    version: u64,
    draws: Draws,
    /// Triangles and tiles, summed over instances.
    pub(super) triangles: u64,
    pub(super) count: usize,
}

enum Draws {
    PerTile(TileDraws),
    Merged(MergedDraws),
}

impl Tiles {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let draws = if gpu.indirect { Draws::PerTile(TileDraws::new()) } else { Draws::Merged(MergedDraws::new()) };
        Self { version: 0, draws, triangles: 0, count: 0 }
    }

    /// Rebuilds the draw list if the scene changed. Returns the number of bytes uploaded.
    pub(super) fn refresh(
        &mut self,
        gpu: &Gpu,
        shown: &DeviceScene,
        records: &Records,
        view: usize,
        version: u64,
    ) -> u64 {
        if self.version == version {
            return 0;
        }
        self.version = version;
        let (mut triangles, mut count) = (0, 0);
        let tiles = shown.drawn_tiles(view).inspect(|(_, _, tile)| {
            triangles += u64::from(tile.triangles);
            count += 1;
        });
        let bytes = match &mut self.draws {
            Draws::PerTile(draws) => draws.refresh(gpu, tiles, records),
            Draws::Merged(draws) => draws.refresh(gpu, tiles),
        };
        (self.triangles, self.count) = (triangles, count);
        bytes
    }

    /// Makes the wireframe draws if they are missing. Returns the number of bytes uploaded.
    pub(super) fn refresh_wires(&mut self, gpu: &Gpu, store: &Store) -> u64 {
        match &mut self.draws {
            Draws::PerTile(draws) => draws.refresh_wires(gpu, store),
            Draws::Merged(draws) => draws.refresh_wires(gpu),
        }
    }

    /// Number of calls that draw the surfaces.
    pub(super) fn calls(&self) -> usize {
        match &self.draws {
            Draws::PerTile(draws) => draws.groups.len(),
            Draws::Merged(draws) => draws.draws.len(),
        }
    }

    /// The calls that draw the surfaces. `records` is the vertex buffer that they are in, where tiles are not merged.
    pub(super) fn draws<'a>(
        &'a self,
        store: &'a Store,
        records: Option<&'a Buffer>,
    ) -> Box<dyn Iterator<Item = SurfaceDraw<'a>> + 'a> {
        match (&self.draws, records) {
            (Draws::PerTile(draws), Some(records)) => Box::new(draws.draws(store, records)),
            (Draws::PerTile(_), None) => Box::new(std::iter::empty()),
            (Draws::Merged(draws), _) => Box::new(draws.draws(store)),
        }
    }

    /// The calls that draw the lattice lines, of tiles that have lattice positions, which go to vertex buffer slot 2.
    pub(super) fn lattice_draws<'a>(
        &'a self,
        store: &'a Store,
        records: Option<&'a Buffer>,
    ) -> impl Iterator<Item = (SurfaceDraw<'a>, &'a Buffer)> {
        let draws = self.draws(store, records);
        draws
            .filter_map(|draw| store.vertices.companion_of_page(Companion::Cells, draw.page).map(|cells| (draw, cells)))
    }

    /// Draws the wireframe. The pass must have the records in vertex buffer slot 0, unless tiles are merged.
    pub(super) fn draw_wires(&self, pass: &mut RenderPass<'_>, store: &Store) {
        match &self.draws {
            Draws::PerTile(draws) => draws.draw_wires(pass),
            Draws::Merged(draws) => draws.draw_wires(pass, store),
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        let (surfaces, wires) = match &self.draws {
            Draws::PerTile(draws) => (&draws.rows, draws.wires.as_ref().map(|wires| &wires.rows)),
            Draws::Merged(draws) => (&draws.rows, draws.sides.as_ref()),
        };
        surfaces.bytes() + wires.map_or(0, Rows::bytes)
    }
}

/// A point in its part's coordinates. The fourth number is 1 where a segment goes on to the next point, else 0.
type Point = [f32; 4];

/// Points of all edges of placed parts, and the draws.
pub(super) struct Edges {
    version: u64,
    points: Vec<Point>,
    texels: Texels,
    group: Option<BindGroup>,
    /// Points and places.
    draws: Vec<(Range<u32>, Range<u32>)>,
}

impl Edges {
    pub(super) fn new() -> Self {
        Self { version: 0, points: Vec::new(), texels: Texels::new(ROW_FORMAT), group: None, draws: Vec::new() }
    }

    /// Gathers the points again if edges or instances changed. Returns the number of bytes uploaded.
    pub(super) fn refresh(&mut self, gpu: &Gpu, shown: &DeviceScene, version: u64) -> u64 {
        if self.version == version {
            return 0;
        }
        self.version = version;
        self.draws.clear();
        let before = std::mem::take(&mut self.points);
        for part in &shown.parts {
            let ranges = shown.visible(part.places.clone());
            if ranges.is_empty() {
                continue;
            }
            let start = self.points.len() as u32;
            for line in part.lines.iter().flatten() {
                self.points.extend(line.iter().map(|&[x, y, z]| [x, y, z, 1.0]));
                self.points.last_mut().into_iter().for_each(|last| last[3] = 0.0);
            }
            // The last point of a polyline begins no segment.
            let end = self.points.len() as u32;
            if end > start {
                self.draws.extend(ranges.into_iter().map(|places| (start..end - 1, places)));
            }
        }
        let bytes = self.texels.write(gpu, &self.points, changed(&before, &self.points));
        let layout = &gpu.pipelines.points;
        let points = self.texels.view().map(|view| vec![BindingResource::TextureView(view)]);
        self.group = points.map(|points| bind(gpu, layout, points));
        bytes
    }

    /// Number of calls that draw the edges.
    pub(super) fn calls(&self) -> usize {
        self.draws.len()
    }

    pub(super) fn draw(&self, pass: &mut RenderPass<'_>) {
        let Some(group) = &self.group else { return };
        pass.set_bind_group(1, group, &[]);
        for (points, places) in &self.draws {
            pass.draw(6 * points.start..6 * points.end, places.clone());
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.texels.bytes()
    }
}

/// The range of `new` outside of which both are the same.
fn changed(old: &[Point], new: &[Point]) -> Range<usize> {
    let start = old.iter().zip(new).take_while(|(a, b)| a == b).count();
    if old.len() != new.len() {
        return start..new.len();
    }
    let same = old[start..].iter().rev().zip(new[start..].iter().rev()).take_while(|(a, b)| a == b).count();
    start..new.len() - same
}
