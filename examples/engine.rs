//! A session as an engine hosts it: the engine's pool, vertices of 16 bytes in the engine's memory, progress, a budget
//! per frame, instances that move, parts that are hidden or coloured, a file that changes. Asserts what it shows.
//!
//! Run with `cargo run --release --example engine -- tests/data/nist_ctc05.step`.

use glam::{DAffine3, DVec3};
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::path::Path;
use std::slice::Iter;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use trimtess::control::{Control, Job, Jobs, Priority};
use trimtess::frame::{Attributes, PlannerOptions};
use trimtess::import::step::{StepOptions, read_file_on};
use trimtess::mesh::{
    Batch, DrawnTiles, InstanceKey, MeshSink, Scene, SceneChanges, SceneInstance, SinkError, TileMemory, VertexLayout,
    WrittenTile,
};
use trimtess::model::{Instance, PartId, TileId, shapes};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, prepare_on};
use trimtess::view::{CameraPath, Picture, View};

/// The engine's pool. Its threads take the helpers of a frame before the next frame, as a pool with priorities does.
struct Pool(rayon::ThreadPool);

impl Jobs for Pool {
    fn width(&self) -> usize {
        self.0.current_num_threads()
    }

    fn spawn(&self, priority: Priority, job: Job) {
        match priority {
            Priority::Helper => self.0.spawn(job),
            _ => self.0.spawn_fifo(job),
        }
    }

    fn for_each(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
        self.0.scope(|scope| (0..count).for_each(|k| scope.spawn(move |_| body(k))));
    }
}

/// The engine's memory: a block of bytes per tile. A real one hands out mapped memory of the device.
#[derive(Default)]
struct Blocks(Mutex<BTreeMap<u64, Vec<u8>>>);

impl Blocks {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<u64, Vec<u8>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl TileMemory for Blocks {
    /// Called by the thread that made the tile. The lock is free while vertices are written.
    fn write(&self, tile: &WrittenTile, fill: &mut dyn FnMut(&mut [u8], &mut [u8])) -> Result<u64, SinkError> {
        let mut block = vec![0; tile.vertex_bytes() + tile.index_bytes()];
        let (vertices, indices) = block.split_at_mut(tile.vertex_bytes());
        fill(vertices, indices);
        let mut blocks = self.lock();
        let place = blocks.last_key_value().map_or(0, |(last, _)| last + 1);
        blocks.insert(place, block);
        Ok(place)
    }

    fn release(&self, tile: &WrittenTile) {
        self.lock().remove(&tile.place);
    }
}

/// The engine's list of what to draw. Frames tell what of it differs.
#[derive(Default)]
struct Drawables {
    memory: Arc<Blocks>,
    instances: BTreeMap<InstanceKey, SceneInstance>,
    /// Keys by row of the scene.
    rows: Vec<InstanceKey>,
    tiles: BTreeMap<(PartId, TileId), WrittenTile>,
    draws: BTreeSet<(InstanceKey, TileId)>,
    /// Tiles that come or go in a frame.
    difference: DrawnTiles,
}

impl Drawables {
    /// Triangles in the picture: what a draw list would hold.
    fn triangles(&self) -> u32 {
        let tiles = self.draws.iter().map(|(key, tile)| (self.instances[key].part, *tile));
        tiles.filter_map(|key| self.tiles.get(&key)).map(|tile| tile.triangles).sum()
    }

    /// The draws of `difference`.
    fn differing(&self) -> impl Iterator<Item = (InstanceKey, TileId)> + '_ {
        let draws = move |row| self.difference.tiles(0, row).map(move |tile| (self.rows[row], tile));
        self.difference.instances(0).flat_map(draws)
    }

    fn release_all(&mut self) {
        std::mem::take(&mut self.tiles).values().for_each(|tile| self.memory.release(tile));
        self.instances.clear();
        self.rows.clear();
        self.draws.clear();
    }
}

impl MeshSink for Drawables {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.release_all();
        self.begin_changes(scene, &SceneChanges::default())
    }

    fn begin_changes(&mut self, scene: &Scene, changes: &SceneChanges<'_>) -> Result<(), SinkError> {
        for key in changes.removed {
            self.instances.remove(key);
            self.draws.retain(|(of, _)| of != key);
        }
        let new = scene.instances.iter().skip(changes.first_instance);
        for instance in changes.changed.iter().map(|row| &scene.instances[*row]).chain(new) {
            self.instances.extend(instance.key.map(|key| (key, instance.clone())));
        }
        // Sessions give a key to each.
        changes.apply(scene, &mut self.rows, |instance| instance.key.expect("a key"));
        Ok(())
    }

    /// Another model: tiles of parts that go on get the part's new number, the others go.
    fn begin_update(
        &mut self,
        scene: &Scene,
        changes: &SceneChanges<'_>,
        from: &[Option<PartId>],
    ) -> Result<(), SinkError> {
        let goes_on = |(old, new): (&Option<PartId>, u32)| Some(((*old)?, PartId(new)));
        let new: BTreeMap<PartId, PartId> = from.iter().zip(0..).filter_map(goes_on).collect();
        for tile in std::mem::take(&mut self.tiles).into_values() {
            match new.get(&tile.part) {
                Some(&part) => _ = self.tiles.insert((part, tile.tile), WrittenTile { part, ..tile }),
                None => self.memory.release(&tile),
            }
        }
        self.begin_changes(scene, changes)
    }

    fn batch(&mut self, _: &mut Batch) -> Result<(), SinkError> {
        unreachable!("tiles are written into memory")
    }

    /// One row per tile that has changed: the vertices are there already.
    fn written(&mut self, tiles: &mut Iter<'_, WrittenTile>) -> Result<(), SinkError> {
        for tile in tiles {
            let key = (tile.part, tile.tile);
            let old = if tile.triangles > 0 { self.tiles.insert(key, *tile) } else { self.tiles.remove(&key) };
            old.iter().for_each(|old| self.memory.release(old));
        }
        Ok(())
    }

    fn drawn(&mut self, drawn: &DrawnTiles, before: &DrawnTiles) -> Result<(), SinkError> {
        self.difference.set_difference(before, drawn);
        let gone: Vec<_> = self.differing().collect();
        gone.iter().for_each(|draw| _ = self.draws.remove(draw));
        self.difference.set_difference(drawn, before);
        let new: Vec<_> = self.differing().collect();
        self.draws.extend(new);
        Ok(())
    }

    /// The next frame is a whole one.
    fn abort(&mut self) {
        self.release_all();
    }
}

/// Frames of a still camera until the budget makes no tile wait. Returns how many waited.
fn until_nothing_waits(session: &mut Session, view: View, sink: &mut Drawables) -> Result<usize, Box<dyn Error>> {
    let mut frames = 0;
    while session.view(&[view], sink)?.deferred > 0 {
        frames += 1;
        assert!(frames < 1000, "a session that never arrives");
    }
    Ok(frames)
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "tests/data/nist_ctc05.step".into());
    let pool = Arc::new(Pool(rayon::ThreadPoolBuilder::new().num_threads(2).build()?));

    // Reading and preparing run on the pool. The observer hears of growing numbers, one call at a time.
    let heard = Arc::new(Mutex::new((0, 0)));
    let hears = Arc::clone(&heard);
    let control = Control::observed_by(move |progress| {
        let mut heard = hears.lock().unwrap_or_else(PoisonError::into_inner);
        assert!(progress.done > heard.0 || progress.done == 0, "{progress:?} after {heard:?}");
        *heard = (progress.done, progress.total);
    });
    let model = read_file_on(&*pool, Path::new(&path), &StepOptions::default(), &control)?;
    let (done, total) = *heard.lock().unwrap_or_else(PoisonError::into_inner);
    assert_eq!(done, total);
    let prepared = Arc::new(prepare_on(&*pool, &model, &PrepareOptions::DEFAULT, &Control::default())?);
    println!("{path}: {} parts, {} tiles", prepared.parts.len(), prepared.tiles().count());

    // A session starts no thread of its own. 4 ms of one worker for the tiles of a frame; the rest waits.
    let planner = PlannerOptions::DEFAULT.with_budget(Some(Duration::from_millis(4)));
    let options = SessionOptions::DEFAULT.with_edge_lines(false).with_planner(planner);
    let mut session = Session::start_on(Arc::<Pool>::clone(&pool), Arc::clone(&prepared), &options);
    let mut sink = Drawables::default();
    session.write_into(VertexLayout::COMPACT, Arc::<Blocks>::clone(&sink.memory));

    let picture = Picture { size: (1920, 1080), deviation_px: 0.25, size_px: None, angle: 0.5 };
    let bounds = prepared.bounds.ok_or("an empty model")?;
    let views = CameraPath::Orbit.views(bounds, 60, &picture);
    let (mut caller, mut worst) = (Duration::ZERO, Duration::ZERO);
    for view in &views {
        let start = Instant::now();
        session.begin(&[*view])?;
        let begun = start.elapsed();
        // The engine does something else, and looks once a frame whether there is something new. The sink keeps the
        // last frame until then.
        while !session.is_made() {
            std::thread::yield_now();
        }
        let start = Instant::now();
        let report = session.finish_within(Duration::ZERO, &mut sink)?.ok_or("a frame that is made")?;
        let spent = begun + start.elapsed();
        (caller, worst) = (caller + spent, worst.max(spent));
        assert!(sink.triangles() > 0 && report.degraded.is_empty());
    }
    println!("{} frames: {caller:.2?} on this thread, at worst {worst:.2?}", views.len());

    // A still camera goes on until nothing waits.
    let frames = until_nothing_waits(&mut session, views[59], &mut sink)?;
    // Each tile that the sink has is in its memory, and nothing else is.
    let blocks = sink.memory.lock().len();
    assert_eq!(blocks, sink.tiles.len());
    let vertices: u32 = sink.tiles.values().map(|tile| tile.vertices).sum();
    assert!(sink.tiles.values().all(|tile| tile.vertex_bytes() == 16 * tile.vertices as usize));
    println!("{frames} more frames; {} triangles drawn, {blocks} tiles, {vertices} vertices", sink.triangles());

    // Instances move without new triangles, unless they come closer.
    let key = session.instance_key(0).ok_or("an instance")?;
    let aside = DAffine3::from_translation(DVec3::new(0.0, 0.0, -1e-3)) * session.scene().instances[0].transform;
    session.move_instance(key, aside)?;
    session.view(&views[59..], &mut sink)?;
    assert_eq!(sink.instances[&key].transform, aside);

    // Attributes: a colour costs no tile, what is hidden is not drawn, and half the tolerance is more triangles.
    let part = session.part_of(0).ok_or("an instance")?;
    session.set_part(part, &Attributes::DEFAULT.with_colour(Some([0.1, 0.5, 0.9, 1.0])))?;
    assert_eq!(session.view(&views[59..], &mut sink)?.tiles, 0);
    assert_eq!(sink.instances[&key].colour, Some([0.1, 0.5, 0.9, 1.0]));
    let before = sink.triangles();
    session.set_instance(key, &Attributes::DEFAULT.with_visible(false))?;
    session.view(&views[59..], &mut sink)?;
    assert!(sink.draws.iter().all(|(of, _)| *of != key) && sink.triangles() < before);
    session.set_instance(key, &Attributes::DEFAULT.with_tolerance_scale(0.5).with_priority(4.0))?;
    until_nothing_waits(&mut session, views[59], &mut sink)?;
    assert!(sink.triangles() > before, "{} {before}", sink.triangles());
    session.set_instance(key, &Attributes::DEFAULT)?;
    until_nothing_waits(&mut session, views[59], &mut sink)?;

    // The file has changed: a new part before the others, and other colours. One part is prepared, and its tiles are
    // made; the others go on under their new numbers.
    let mut edited = model;
    edited.parts[0].colour = Some([0.9, 0.4, 0.1, 1.0]);
    edited.parts.insert(0, shapes::cuboid());
    edited.instances.iter_mut().for_each(|instance| instance.part.0 += 1);
    edited.instances.push(Instance { part: PartId(0), ..edited.instances[0].clone() });
    let next = Arc::new(prepared.update_on(&*pool, &edited, &PrepareOptions::DEFAULT, &Control::default())?);
    assert!(next.parts[1..].iter().zip(&*prepared.parts).all(|(new, old)| Arc::ptr_eq(new, old)));
    session.update(Arc::clone(&next))?;
    let report = session.view(&views[59..], &mut sink)?;
    assert!(!report.whole && report.tiles <= next.parts[0].tiles.len());
    assert_eq!(sink.memory.lock().len(), sink.tiles.len());
    println!("updated: {} tiles made of {}; {:?}", report.tiles, next.tiles().count(), session.memory()?);

    // A frame that is cancelled leaves the sink as it was; its rooms come back.
    session.begin(&views[..1])?;
    session.cancel();
    session.finish(&mut sink)?;
    assert_eq!(sink.memory.lock().len(), sink.tiles.len());
    Ok(())
}
