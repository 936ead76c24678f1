//! What a flight costs the thread that calls a session: the time of `begin` and of `finish` once the frame is made, and
//! allocations on that thread. By what the sink does: batches that it copies into vertices of 16 bytes, or the same
//! vertices written into its memory by the workers. By the pace, hence the number of tiles that change in a frame.
//!
//! `cargo bench --bench caller -- FILE [FRAMES [COPIES]]`. Without a file, the brake assembly. Copies of its parts
//! stand above the picture, out of sight.

use glam::{DAffine3, DVec3};
use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trimtess::control::{StartError, Threads};
use trimtess::import::step::{self, StepOptions};
use trimtess::mesh::{
    Batch, MeshSink, Scene, SceneChanges, SceneInstance, SinkError, TileMemory, VertexLayout, WrittenTile,
};
use trimtess::model::PartId;
use trimtess::parallel::{Session, SessionMemory, SessionOptions};
use trimtess::prepare::{PrepareOptions, prepare};
use trimtess::view::{CameraPath, Picture, View};

#[path = "common/nowhere.rs"]
mod nowhere;
use nowhere::Nowhere;

const PICTURE: Picture = Picture { size: (1920, 1080), deviation_px: 0.5, size_px: None, angle: 0.5 };

/// Copies each batch into one buffer of vertices, as a sink for a device does.
#[derive(Default)]
struct Copies {
    centres: Vec<DVec3>,
    vertices: Vec<[u8; 16]>,
    indices: Vec<u32>,
}

impl MeshSink for Copies {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.begin_changes(scene, &SceneChanges::default())
    }

    fn begin_changes(&mut self, scene: &Scene, changes: &SceneChanges<'_>) -> Result<(), SinkError> {
        self.centres.truncate(changes.first_part);
        self.centres.extend(scene.parts[changes.first_part..].iter().map(|part| part.centre));
        self.vertices.clear();
        self.indices.clear();
        Ok(())
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        let centre = self.centres[batch.part.index()];
        for (position, normal) in batch.mesh.positions.iter().zip(&batch.mesh.normals) {
            let mut vertex = [0; 16];
            for (k, x) in (*position - centre).as_vec3().to_array().iter().enumerate() {
                vertex[4 * k..4 * k + 4].copy_from_slice(&x.to_le_bytes());
            }
            let octahedral = normal.truncate() / normal.abs().element_sum();
            for (k, x) in octahedral.to_array().iter().enumerate() {
                vertex[12 + 2 * k..14 + 2 * k].copy_from_slice(&((x * 32_767.0) as i16).to_le_bytes());
            }
            self.vertices.push(vertex);
        }
        self.indices.extend(batch.mesh.triangles.iter().flatten());
        Ok(())
    }
}

/// A block per worker that its tiles overwrite in turn, as a ring of staging memory does.
struct Ring(Vec<std::sync::Mutex<(Vec<u8>, usize)>>);

impl Ring {
    const BYTES: usize = 1 << 24;

    fn new(workers: usize) -> Self {
        Self((0..workers).map(|_| std::sync::Mutex::new((vec![0; Self::BYTES], 0))).collect())
    }
}

impl TileMemory for Ring {
    fn write(&self, tile: &WrittenTile, fill: &mut dyn FnMut(&mut [u8], &mut [u8])) -> Result<u64, SinkError> {
        let mut block = self.0[tile.worker as usize].lock().expect("no panic");
        let (bytes, next) = &mut *block;
        let size = tile.vertex_bytes() + tile.index_bytes();
        if *next + size > Self::BYTES {
            *next = 0;
        }
        let at = *next;
        let (vertices, indices) = bytes[at..at + size].split_at_mut(tile.vertex_bytes());
        fill(vertices, indices);
        *next = at + size;
        Ok(at as u64)
    }

    fn release(&self, _: &WrittenTile) {}
}

/// Times and allocations of the frames of a flight on the caller's thread, without the first one.
#[derive(Default)]
struct Spent {
    begin: Vec<Duration>,
    finish: Vec<Duration>,
    both: Vec<Duration>,
    /// From `begin` to the end of the commit, without the caller's pauses.
    whole: Vec<Duration>,
    allocations: Vec<u64>,
    tiles: usize,
}

impl Spent {
    fn flight(session: &mut Session, sink: &mut dyn MeshSink, views: &[View]) -> Result<Self, Box<dyn Error>> {
        let mut spent = Self::default();
        for (k, view) in views.iter().enumerate() {
            let start = Instant::now();
            let mut begun = Ok(());
            let in_begin = allocation_counter::measure(|| begun = session.begin(&[*view]));
            let begin = start.elapsed();
            begun?;
            while !session.is_made() {
                std::thread::yield_now();
            }
            let made = start.elapsed();
            let start = Instant::now();
            let mut report = Ok(trimtess::parallel::FrameReport::default());
            let in_finish = allocation_counter::measure(|| report = session.finish(sink));
            let finish = start.elapsed();
            let report = report?;
            if k > 0 {
                spent.begin.push(begin);
                spent.finish.push(finish);
                spent.both.push(begin + finish);
                spent.whole.push(made + finish);
                spent.allocations.push(in_begin.count_total + in_finish.count_total);
                spent.tiles += report.tiles;
            }
        }
        for times in [&mut spent.begin, &mut spent.finish, &mut spent.both, &mut spent.whole] {
            times.sort_unstable();
        }
        spent.allocations.sort_unstable();
        Ok(spent)
    }

    fn print(&self, name: &str) {
        let of = |times: &[Duration]| {
            let ms = |time: Option<&Duration>| time.map_or(0.0, |time| 1e3 * time.as_secs_f64());
            format!("{:.3} {:.3}", ms(times.get(times.len() / 2)), ms(times.last()))
        };
        let middle = self.allocations.get(self.allocations.len() / 2).copied().unwrap_or(0);
        println!(
            "{name}: ms on the caller's thread, median and worst: begin {}, finish {}, both {}; allocations {middle} and \
             {}; whole frame {}; {} tiles in {} frames",
            of(&self.begin),
            of(&self.finish),
            of(&self.both),
            self.allocations.last().copied().unwrap_or(0),
            of(&self.whole),
            self.tiles,
            self.both.len()
        );
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let model = match arguments.first() {
        Some(file) => step::read_file(file.as_ref(), &StepOptions::DEFAULT)?,
        None => trimtess_models::by_name("brake-assembly").ok_or("no such model")?,
    };
    let frames = arguments.get(1).map_or(Ok(200), |count| count.parse())?;
    let copies: usize = arguments.get(2).map_or(Ok(0), |count| count.parse())?;
    let mut prepared = prepare(model, &PrepareOptions::DEFAULT)?;
    let views = CameraPath::Orbit.views(prepared.bounds.ok_or("an empty model")?, frames, &PICTURE);
    let (parts, instances) = (prepared.parts.len(), prepared.scene.instances.clone());
    for k in 1..=copies {
        let up = DAffine3::from_translation(DVec3::Z * (10.0 * k as f64 * prepared.diagonal));
        Arc::make_mut(&mut prepared.parts).extend_from_within(..parts);
        prepared.scene.parts.extend_from_within(..parts);
        prepared.scene.instances.extend(instances.iter().map(|instance| SceneInstance {
            part: PartId::new(k * parts + instance.part.index()),
            transform: up * instance.transform,
            ..instance.clone()
        }));
    }
    let prepared = Arc::new(prepared);
    let pace = |times: usize| views.iter().step_by(times).copied().collect();
    let flights: [(_, Vec<View>); 4] = [
        ("flight", pace(1)),
        ("4 times as fast", pace(4)),
        ("16 times as fast", pace(16)),
        ("still", vec![views[0]; frames]),
    ];
    let tiles = prepared.tiles().count();
    println!("{}: {tiles} tiles, {} instances", prepared.scene.name, prepared.scene.instances.len());
    // The caller asks for frames, and makes none.
    let start = || {
        let options = SessionOptions::DEFAULT.with_edge_lines(false);
        Ok::<_, StartError>(Session::start_on(Arc::new(Threads::start(0)?), Arc::clone(&prepared), &options))
    };
    for (name, views) in &flights {
        let mut session = start()?;
        Spent::flight(&mut session, &mut Copies::default(), views)?.print(&format!("{name}, batches copied"));
        let mut session = start()?;
        session.write_into(VertexLayout::COMPACT, Arc::new(Ring::new(session.workers())));
        Spent::flight(&mut session, &mut Nowhere, views)?.print(&format!("{name}, tiles written"));
        let SessionMemory { plans, scene, .. } = session.memory()?;
        println!(
            "{name}: {:.1} bytes of plans and {:.1} of the scene per tile",
            plans as f64 / tiles as f64,
            scene as f64 / tiles as f64
        );
    }
    Ok(())
}
