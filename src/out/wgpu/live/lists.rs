//! Tiles to draws: one per tile and instance, grouped by the pages they draw from. The draws of a group are one call
//! where the device can read them from a buffer.

use super::super::gpu::Gpu;
use super::device_scene::DeviceScene;
use super::records::Records;
use super::store::Store;
use ::wgpu::util::{DrawIndexedIndirectArgs, DrawIndirectArgs};
use ::wgpu::{BindGroup, Buffer, BufferDescriptor, BufferUsages, IndexFormat, RenderPass};
use bytemuck::Pod;
use std::collections::BTreeMap;
use std::ops::Range;

/// An array on the device that mirrors one in memory. Its capacity grows to powers of two.
pub(super) struct Rows {
    usage: BufferUsages,
    buffer: Option<Buffer>,
}

impl Rows {
    pub(super) fn new(usage: BufferUsages) -> Self {
        Self { usage, buffer: None }
    }

    /// Uploads the `changed` rows, or all rows if the buffer had to grow. Returns the number of bytes uploaded.
    pub(super) fn write<T: Pod>(&mut self, gpu: &Gpu, rows: &[T], changed: Range<usize>) -> u64 {
        let bytes: &[u8] = bytemuck::cast_slice(rows);
        let fits = self.buffer.as_ref().is_some_and(|buffer| buffer.size() >= bytes.len() as u64);
        let changed = if fits { changed } else { 0..rows.len() };
        if !fits {
            self.buffer = Some(gpu.device.create_buffer(&BufferDescriptor {
                label: Some("trimtess rows"),
                size: (bytes.len() as u64).next_power_of_two().max(256),
                usage: self.usage | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }));
        }
        let changed = changed.start * size_of::<T>()..changed.end * size_of::<T>();
        if let Some(buffer) = self.buffer.as_ref().filter(|_| !changed.is_empty()) {
            gpu.queue.write_buffer(buffer, changed.start as u64, &bytes[changed.clone()]);
        }
        changed.len() as u64
    }

    /// The buffer. `None` before the first write.
    pub(super) fn buffer(&self) -> Option<&Buffer> {
        self.buffer.as_ref()
    }

    pub(super) fn bytes(&self) -> u64 {
        self.buffer.as_ref().map_or(0, Buffer::size)
    }
}

/// What one call draws from: page of vertices, page of indices, and whether indices have four bytes.
type PageKey = (u32, u32, bool);

/// Draw list of the tiles in one view.
pub(super) struct Tiles {
    /// The scene version this list was made for; 0 before the first.
    version: u64,
    groups: Vec<(PageKey, Range<u32>)>,
    draws: Vec<DrawIndexedIndirectArgs>,
    rows: Rows,
    /// The wireframe of the same tiles, made on demand.
    wires: Option<Wires>,
    pub(super) triangles: u64,
}

struct Wires {
    draws: Vec<DrawIndirectArgs>,
    rows: Rows,
    groups: Vec<BindGroup>,
}

impl Tiles {
    pub(super) fn new() -> Self {
        Self {
            version: 0,
            groups: Vec::new(),
            draws: Vec::new(),
            rows: Rows::new(BufferUsages::INDIRECT),
            wires: None,
            triangles: 0,
        }
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
        self.wires = None;
        self.triangles = 0;
        let mut groups: BTreeMap<PageKey, Vec<DrawIndexedIndirectArgs>> = BTreeMap::new();
        for (place, at) in shown.places.iter().enumerate() {
            let tiles = &shown.parts[at.part as usize].tiles;
            let mut draw = |number: usize| {
                let Some(Some(tile)) = tiles.get(number) else { return };
                self.triangles += u64::from(tile.triangles);
                let pages = (tile.vertices.page, tile.indices.page, tile.wide);
                groups.entry(pages).or_default().push(DrawIndexedIndirectArgs {
                    index_count: 3 * tile.triangles,
                    instance_count: 1,
                    first_index: tile.first_index(),
                    base_vertex: tile.vertices.start() as i32,
                    first_instance: records.row(place as u32, number as u32),
                });
            };
            if view < shown.drawn.views() {
                shown.drawn.tiles(view, at.instance as usize).for_each(|tile| draw(tile.0 as usize));
            } else {
                (0..tiles.len()).for_each(draw);
            }
        }
        self.groups.clear();
        self.draws.clear();
        for (pages, draws) in groups {
            let start = self.draws.len() as u32;
            self.draws.extend(draws);
            self.groups.push((pages, start..self.draws.len() as u32));
        }
        if gpu.indirect { self.rows.write(gpu, &self.draws, 0..self.draws.len()) } else { 0 }
    }

    /// Makes the wireframe draws if they are missing. Returns the number of bytes uploaded.
    pub(super) fn refresh_wires(&mut self, gpu: &Gpu, store: &Store) -> u64 {
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
            bind(gpu, &gpu.pipelines.triangles, &[store.vertices.buffer(*vertices), store.indices.buffer(*indices)])
        };
        let groups = self.groups.iter().map(group).collect();
        let mut rows = Rows::new(BufferUsages::INDIRECT);
        let bytes = if gpu.indirect { rows.write(gpu, &draws, 0..draws.len()) } else { 0 };
        self.wires = Some(Wires { draws, rows, groups });
        bytes
    }

    /// Draws the surfaces. The pass must have the records in vertex buffer slot 1.
    pub(super) fn draw(&self, pass: &mut RenderPass<'_>, store: &Store) {
        self.groups.iter().for_each(|group| self.draw_group(pass, store, group));
    }

    /// Draws the lattice lines of tiles that have lattice positions, which go to vertex buffer slot 2.
    pub(super) fn draw_lattice(&self, pass: &mut RenderPass<'_>, store: &Store) {
        for group in &self.groups {
            if let Some(places) = store.vertices.beside_page(group.0.0) {
                pass.set_vertex_buffer(2, places.slice(..));
                self.draw_group(pass, store, group);
            }
        }
    }

    fn draw_group(
        &self,
        pass: &mut RenderPass<'_>,
        store: &Store,
        ((vertices, indices, wide), range): &(PageKey, Range<u32>),
    ) {
        let format = if *wide { IndexFormat::Uint32 } else { IndexFormat::Uint16 };
        pass.set_vertex_buffer(0, store.vertices.buffer(*vertices).slice(..));
        pass.set_index_buffer(store.indices.buffer(*indices).slice(..), format);
        if let Some(rows) = self.rows.buffer() {
            let offset = u64::from(range.start) * size_of::<DrawIndexedIndirectArgs>() as u64;
            pass.multi_draw_indexed_indirect(rows, offset, range.end - range.start);
            return;
        }
        for draw in &self.draws[range.start as usize..range.end as usize] {
            let indices = draw.first_index..draw.first_index + draw.index_count;
            pass.draw_indexed(indices, draw.base_vertex, draw.first_instance..draw.first_instance + 1);
        }
    }

    /// Draws the wireframe. The pass must have the records in vertex buffer slot 0.
    pub(super) fn draw_wires(&self, pass: &mut RenderPass<'_>) {
        let Some(wires) = &self.wires else { return };
        for ((_, range), group) in self.groups.iter().zip(&wires.groups) {
            pass.set_bind_group(2, group, &[]);
            draw_all(pass, &wires.rows, &wires.draws, range);
        }
    }

    /// Number of draws.
    pub(super) fn count(&self) -> usize {
        self.draws.len()
    }

    pub(super) fn bytes(&self) -> u64 {
        self.rows.bytes() + self.wires.as_ref().map_or(0, |wires| wires.rows.bytes())
    }
}

/// Draw list of the edges, the same in every view: one instanced draw per edge for all instances of its part.
pub(super) struct Edges {
    version: u64,
    groups: Vec<(BindGroup, Range<u32>)>,
    draws: Vec<DrawIndirectArgs>,
    rows: Rows,
}

impl Edges {
    pub(super) fn new() -> Self {
        Self { version: 0, groups: Vec::new(), draws: Vec::new(), rows: Rows::new(BufferUsages::INDIRECT) }
    }

    /// See [`Tiles::refresh`].
    pub(super) fn refresh(&mut self, gpu: &Gpu, shown: &DeviceScene, store: &Store, version: u64) -> u64 {
        if self.version == version {
            return 0;
        }
        self.version = version;
        let mut pages: BTreeMap<u32, Vec<DrawIndirectArgs>> = BTreeMap::new();
        for part in shown.parts.iter().filter(|part| !part.places.is_empty()) {
            for line in part.lines.iter().flatten() {
                pages.entry(line.points.page).or_default().push(DrawIndirectArgs {
                    vertex_count: 6 * line.segments,
                    instance_count: part.places.len() as u32,
                    first_vertex: 6 * line.points.start(),
                    first_instance: part.places.start,
                });
            }
        }
        self.groups.clear();
        self.draws.clear();
        for (page, draws) in pages {
            let start = self.draws.len() as u32;
            self.draws.extend(draws);
            let group = bind(gpu, &gpu.pipelines.points, &[store.points.buffer(page)]);
            self.groups.push((group, start..self.draws.len() as u32));
        }
        if gpu.indirect { self.rows.write(gpu, &self.draws, 0..self.draws.len()) } else { 0 }
    }

    /// Draws the edges.
    pub(super) fn draw(&self, pass: &mut RenderPass<'_>) {
        for (group, range) in &self.groups {
            pass.set_bind_group(1, group, &[]);
            draw_all(pass, &self.rows, &self.draws, range);
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.rows.bytes()
    }
}

fn draw_all(pass: &mut RenderPass<'_>, rows: &Rows, draws: &[DrawIndirectArgs], range: &Range<u32>) {
    if let Some(rows) = rows.buffer() {
        let offset = u64::from(range.start) * size_of::<DrawIndirectArgs>() as u64;
        pass.multi_draw_indirect(rows, offset, range.end - range.start);
        return;
    }
    for draw in &draws[range.start as usize..range.end as usize] {
        let instances = draw.first_instance..draw.first_instance + draw.instance_count;
        pass.draw(draw.first_vertex..draw.first_vertex + draw.vertex_count, instances);
    }
}

/// Creates a bind group of whole buffers, bound in order.
pub(super) fn bind(gpu: &Gpu, layout: &::wgpu::BindGroupLayout, buffers: &[&Buffer]) -> BindGroup {
    let entries = buffers.iter().enumerate().map(|(binding, buffer)| ::wgpu::BindGroupEntry {
        binding: binding as u32,
        resource: buffer.as_entire_binding(),
    });
    let entries: Vec<_> = entries.collect();
    gpu.device.create_bind_group(&::wgpu::BindGroupDescriptor { label: Some("trimtess"), layout, entries: &entries })
}
