//! A flight -> a hash of all its pictures: of the drawn tiles, packed as renderers take them. `capi/examples/view.c`
//! computes the same through the C interface.

use crate::Failure;
use crate::limits::LimitArgs;
use std::collections::BTreeMap;
use std::slice::Iter;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use trimtess::mesh::{
    Batch, DrawnTiles, MeshSink, Scene, SceneChanges, SinkError, TileMemory, VertexLayout, WrittenTile,
};
use trimtess::model::{PartId, TileId};
use trimtess::parallel::Session;
use trimtess::prepare::Prepared;
use trimtess::view::View;

/// Vertices and indices of a tile.
type Block = [Vec<u8>; 2];

/// A block per tile, by the tile's place.
#[derive(Default)]
struct Blocks(Mutex<(u64, BTreeMap<u64, Block>)>);

impl Blocks {
    fn lock(&self) -> MutexGuard<'_, (u64, BTreeMap<u64, Block>)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl TileMemory for Blocks {
    fn write(&self, tile: &WrittenTile, fill: &mut dyn FnMut(&mut [u8], &mut [u8])) -> Result<u64, SinkError> {
        let [mut vertices, mut indices] = [tile.vertex_bytes(), tile.index_bytes()].map(|bytes| vec![0; bytes]);
        fill(&mut vertices, &mut indices);
        let (places, blocks) = &mut *self.lock();
        *places += 1;
        blocks.insert(*places, [vertices, indices]);
        Ok(*places)
    }

    fn release(&self, tile: &WrittenTile) {
        self.lock().1.remove(&tile.place);
    }
}

/// Keeps the tiles, and hashes those of each picture (FNV-1a).
struct Pictures {
    memory: Arc<Blocks>,
    tiles: BTreeMap<(PartId, TileId), WrittenTile>,
    /// The part, or level of detail, of each instance.
    parts: Vec<PartId>,
    drawn: DrawnTiles,
    /// Whether each picture is hashed, as it comes.
    each: bool,
    /// Of the last picture.
    triangles: u64,
    hash: u64,
}

impl Pictures {
    /// A session, and a sink of its own that its workers write into.
    fn start(prepared: &Arc<Prepared>, threads: usize, limits: &LimitArgs) -> Result<(Session, Self), Failure> {
        let options = limits.session().with_threads(threads).with_edge_lines(false);
        let mut session = Session::start(Arc::clone(prepared), &options).map_err(Failure::cannot)?;
        let memory = Arc::<Blocks>::default();
        session.write_into(VertexLayout::COMPACT, Arc::clone(&memory) as Arc<dyn TileMemory>);
        let (tiles, parts, drawn) = (BTreeMap::new(), Vec::new(), DrawnTiles::default());
        Ok((session, Self { memory, tiles, parts, drawn, each: false, triangles: 0, hash: 0xcbf2_9ce4_8422_2325 }))
    }

    fn hash(&mut self, bytes: &[u8]) {
        const PRIME: u64 = 0x100_0000_01b3;
        self.hash = bytes.iter().fold(self.hash, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME));
    }

    fn release_all(&mut self) {
        std::mem::take(&mut self.tiles).values().for_each(|tile| self.memory.release(tile));
    }

    fn draw(&mut self, instance: usize, tile: WrittenTile) {
        let words = [tile.part.0, tile.face.0, tile.tile.0, tile.vertices, tile.triangles];
        self.hash(&(instance as u32).to_le_bytes());
        words.iter().for_each(|word| self.hash(&word.to_le_bytes()));
        let memory = Arc::clone(&self.memory);
        memory.lock().1.get(&tile.place).into_iter().flatten().for_each(|bytes| self.hash(bytes));
        self.triangles += u64::from(tile.triangles);
    }

    /// Hashes the last picture.
    fn draw_all(&mut self) {
        self.triangles = 0;
        let drawn = std::mem::take(&mut self.drawn);
        for view in 0..drawn.views() {
            for instance in 0..self.parts.len() {
                for tile in drawn.tiles(view, instance) {
                    let known = self.tiles.get(&(self.parts[instance], tile)).copied();
                    known.into_iter().for_each(|tile| self.draw(instance, tile));
                }
            }
        }
        self.drawn = drawn;
    }

    /// Hashes all tiles, as frames without views draw them.
    fn draw_whole(&mut self) {
        for instance in 0..self.parts.len() {
            let part = self.parts[instance];
            let tiles = self.tiles.range((part, TileId(0))..=(part, TileId(u32::MAX)));
            let tiles: Vec<_> = tiles.map(|(_, tile)| *tile).collect();
            tiles.into_iter().for_each(|tile| self.draw(instance, tile));
        }
    }
}

impl MeshSink for Pictures {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.release_all();
        self.parts.clear();
        self.begin_changes(scene, &SceneChanges::default())
    }

    fn begin_changes(&mut self, scene: &Scene, changes: &SceneChanges<'_>) -> Result<(), SinkError> {
        changes.apply(scene, &mut self.parts, |instance| instance.part);
        Ok(())
    }

    fn batch(&mut self, _: &mut Batch) -> Result<(), SinkError> {
        // Tiles are written into memory.
        Ok(())
    }

    fn written(&mut self, tiles: &mut Iter<'_, WrittenTile>) -> Result<(), SinkError> {
        for tile in tiles {
            let key = (tile.part, tile.tile);
            let old = if tile.triangles > 0 { self.tiles.insert(key, *tile) } else { self.tiles.remove(&key) };
            old.iter().for_each(|old| self.memory.release(old));
        }
        Ok(())
    }

    fn drawn(&mut self, drawn: &DrawnTiles, _: &DrawnTiles) -> Result<(), SinkError> {
        self.drawn.clone_from(drawn);
        if self.each {
            self.draw_all();
        }
        Ok(())
    }

    fn abort(&mut self) {
        self.release_all();
    }
}

/// Flies along `views`. Returns the triangles of the last picture, and the hash of all.
pub(super) fn of(
    prepared: &Arc<Prepared>,
    views: &[View],
    threads: usize,
    limits: &LimitArgs,
) -> Result<(u64, u64), Failure> {
    let (mut session, mut pictures) = Pictures::start(prepared, threads, limits)?;
    pictures.each = true;
    for view in views {
        session.view(&[*view], &mut pictures).map_err(Failure::cannot)?;
        limits.check(session.shortfall())?;
    }
    Ok((pictures.triangles, pictures.hash))
}

/// The hashes of the last frame of a cold flight and of a coherent one.
pub(super) fn of_last(
    prepared: &Arc<Prepared>,
    views: &[View],
    threads: usize,
    limits: &LimitArgs,
) -> Result<[u64; 2], Failure> {
    let (mut session, mut cold) = Pictures::start(prepared, threads, limits)?;
    if let Some(view) = views.last() {
        let plan = session.plan_for_view(view, &limits.plan());
        session.frame(plan, &mut cold).map_err(Failure::cannot)?;
        cold.draw_whole();
    }
    let (mut session, mut coherent) = Pictures::start(prepared, threads, limits)?;
    for view in views {
        session.view(&[*view], &mut coherent).map_err(Failure::cannot)?;
    }
    coherent.draw_all();
    Ok([cold.hash, coherent.hash])
}
