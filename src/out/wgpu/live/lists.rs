//! Tiles of a view to draws: one per tile of each instance where the device reads draws from a buffer, else one per
//! part and page of vertices.

use super::super::gpu::Gpu;
use super::device_scene::DeviceScene;
use super::merged::MergedDraws;
use super::pages::Companion;
use super::records::Records;
use super::store::Store;
use super::surface_draw::SurfaceDraw;
use super::tile_draws::TileDraws;
use ::wgpu::{Buffer, RenderPass};

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
            Draws::PerTile(draws) => draws.calls(),
            Draws::Merged(draws) => draws.calls(),
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
        match &self.draws {
            Draws::PerTile(draws) => draws.bytes(),
            Draws::Merged(draws) => draws.bytes(),
        }
    }
}
