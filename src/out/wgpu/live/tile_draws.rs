//! Tiles to draws in a buffer on the device: one per tile and instance. The draws from a page are one call.

use super::super::gpu::Gpu;
use super::records::Records;
use super::rows::{Rows, bind};
use super::store::{Store, StoredTile};
use super::surface_draw::{DrawCall, SurfaceDraw};
use ::wgpu::util::{DrawIndexedIndirectArgs, DrawIndirectArgs};
use ::wgpu::{BindGroup, Buffer, BufferUsages, IndexFormat, RenderPass};
use std::collections::BTreeMap;
use std::ops::Range;

/// What one call draws from: page of vertices, page of indices, and whether indices have four bytes.
type PageKey = (u32, u32, bool);

/// One draw per tile of each instance.
pub(super) struct TileDraws {
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
    pub(super) fn new() -> Self {
        Self { groups: Vec::new(), draws: Vec::new(), rows: Rows::new(BufferUsages::INDIRECT), wires: None }
    }

    /// Rebuilds the list. Returns the number of bytes uploaded.
    pub(super) fn refresh<'a>(
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

    /// Number of calls.
    pub(super) fn calls(&self) -> usize {
        self.groups.len()
    }

    /// The calls. Vertex buffer 1 has the records.
    pub(super) fn draws<'a>(&'a self, store: &'a Store, records: &'a Buffer) -> impl Iterator<Item = SurfaceDraw<'a>> {
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

    pub(super) fn draw_wires(&self, pass: &mut RenderPass<'_>) {
        let Some(wires) = &self.wires else { return };
        let Some(rows) = wires.rows.buffer() else { return };
        for ((_, range), group) in self.groups.iter().zip(&wires.groups) {
            pass.set_bind_group(2, group, &[]);
            let offset = u64::from(range.start) * size_of::<DrawIndirectArgs>() as u64;
            pass.multi_draw_indirect(rows, offset, range.end - range.start);
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.rows.bytes() + self.wires.as_ref().map_or(0, |wires| wires.rows.bytes())
    }
}
