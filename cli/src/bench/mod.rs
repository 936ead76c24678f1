//! `trimtess bench`: times a camera path over a model by stage and worker.

mod costs;
mod flight;
mod glu_scene;
mod hash;
mod plot;
mod replay;
mod route;
mod scaling;
mod steps;
mod summary;
mod tile_costs;
mod uploads;

use crate::input::{self, Input};
use crate::limits::unprepared;
use crate::logging::Progress;
use crate::outputs::{Named, Outputs};
use crate::tessellate::{positive, size};
use crate::{Common, Done, Failure, MOST_WORKERS, name_of};
use costs::Costs;
use flight::{Coherence, Order, fly};
use replay::{EPOCH, Policy, replay};
use route::{PictureOverrides, Route};
use std::path::PathBuf;
use std::sync::Arc;
use summary::{Costly, Machine, Percentiles, Replay, Report, Row, Run, TileCosts};
use trimtess::prepare::{Prepared, prepare};
use trimtess::view::View;

/// Maximum number of frames: a view takes 200 bytes, and a quarter of an hour at 1000 frames per second is long enough.
const MOST_FRAMES: i64 = 1_000_000;

/// Measure frame times along a camera path: stages, workers, bytes uploaded.
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true, disable_help_subcommand = true)]
pub(crate) struct BenchArgs {
    #[command(subcommand)]
    other: Option<Other>,
    /// A STEP file, builtin:NAME, or builtin:list.
    #[arg(value_name = "FILE", value_parser = input::parser(), required = true)]
    pub(crate) input: Option<Input>,
    /// Camera path: orbit, zoom, walk, glu (the path of the comparison with libGLU), or a file written by --save-path.
    #[arg(long, value_name = "PATH", value_parser = route::parser(), default_value = "orbit")]
    path: Route,
    /// Number of frames of the path; a recorded path begins again at its end [default: 300, or all recorded views].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_FRAMES))]
    frames: Option<u32>,
    /// What frames reuse of the last one. A comma-separated list measures several.
    #[arg(long, value_name = "WHAT", value_delimiter = ',', default_values = ["off", "on"])]
    coherence: Vec<Coherence>,
    /// Number of flights along the path. Each frame's time is the minimum over all flights.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), default_value_t = 1)]
    rounds: u32,
    /// Width and height in pixels [default: 1920x1080, or as recorded].
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<(u32, u32)>,
    /// Maximum screen-space error, pixels [default: 0.5, or as recorded].
    #[arg(long, value_name = "P", value_parser = positive)]
    deviation_px: Option<f64>,
    /// Maximum angle by which the normal turns across a lattice cell, degrees [default: 30, or as recorded].
    #[arg(long, value_name = "DEG", value_parser = positive)]
    angle: Option<f64>,
    /// Time each tile alone (all tiles in 30 of the frames, changed tiles in every frame), and simulate how evenly 4,
    /// 8, 16, 32 and 64 workers (or the numbers given) would be loaded under several ways of dealing tiles.
    #[arg(long, value_name = "N,N,…", num_args = 0..=1, require_equals = true, default_missing_value = "4,8,16,32,64",
          value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=MOST_WORKERS))]
    replay: Vec<u16>,
    /// Measure reading, preparing, and cold and coherent frames on 1, 2, 4 … all cores (or the numbers of --workers),
    /// and as many copies of the model as threads. Compute frames on up to 32 threads from the steps of one.
    #[arg(long, conflicts_with_all = ["replay", "coherence", "save_path"])]
    scaling: bool,
    /// With --scaling: copies of the model, side by side, each with parts of its own.
    #[arg(long, value_name = "N", requires = "scaling", value_parser = clap::value_parser!(u32).range(1..=10_000),
          default_value_t = 1)]
    copies: u32,
    /// Fly once, on the first number of --workers, with tiles packed as renderers take them, and print the triangles of
    /// the last picture and a hash of all pictures. The example `view.c` of the C interface prints the same.
    #[arg(long, conflicts_with_all = ["replay", "coherence", "scaling", "json", "plot"])]
    hash: bool,
    /// Write the results as JSON.
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
    /// Write charts as SVG.
    #[arg(long, value_name = "OUT.svg")]
    plot: Option<PathBuf>,
    /// Write the views to a file for --path.
    #[arg(long, value_name = "OUT.json")]
    save_path: Option<PathBuf>,
}

/// Measurements other than a camera path over a file.
#[derive(clap::Subcommand)]
enum Other {
    GluScene(glu_scene::GluSceneArgs),
    TileCosts(tile_costs::TileCostsArgs),
}

impl BenchArgs {
    /// The files to read and to write, other than the model.
    pub(crate) fn files(&self) -> Named<'_> {
        let recorded = match &self.path {
            Route::Recorded(file) => Some(file.as_path()),
            Route::Named(_) => None,
        };
        let inputs = match &self.other {
            Some(Other::GluScene(scene)) => scene.inputs(),
            Some(Other::TileCosts(files)) => files.inputs(),
            None => recorded.into_iter().collect(),
        };
        let named = Named { inputs, ..Named::default() };
        named
            .output("results", self.json.as_ref())
            .output("charts", self.plot.as_ref())
            .output("views", self.save_path.as_ref())
    }
}

pub(crate) fn run(args: &BenchArgs, common: &Common, outputs: &mut Outputs) -> Result<Done, Failure> {
    match (&args.other, &args.input) {
        (Some(Other::GluScene(scene)), _) => glu_scene::run(scene, common),
        (Some(Other::TileCosts(files)), _) => tile_costs::run(files, common),
        (None, Some(input)) if args.scaling => on_more_threads(input, args, common, outputs),
        (None, Some(input)) => along_a_path(input, args, common, outputs),
        (None, None) => Err(Failure::Usage("FILE is missing".into())),
    }
}

/// The camera path over a model.
fn views(args: &BenchArgs, prepared: &Prepared) -> Result<Vec<View>, Failure> {
    let asked =
        PictureOverrides { size: args.size, deviation_px: args.deviation_px, angle: args.angle.map(f64::to_radians) };
    args.path.views(prepared.bounds, args.frames.map(|n| n as usize), asked)
}

/// Measures a model on more and more threads.
fn on_more_threads(input: &Input, args: &BenchArgs, common: &Common, outputs: &mut Outputs) -> Result<Done, Failure> {
    let progress = Progress::start(common);
    let mut threads: Vec<usize> = common.workers.iter().map(|&n| usize::from(n)).collect();
    if threads.is_empty() {
        threads = scaling::up_to(Machine::this().cores);
    }
    // What one thread takes is what the others are compared with.
    threads.push(1);
    threads.sort_unstable();
    threads.dedup();
    let plan = scaling::Plan { input, copies: args.copies, rounds: args.rounds, threads };
    let scaling = scaling::measure(&plan, &|prepared| views(args, prepared), common, &progress)?;
    drop(progress);
    if let Some(file) = &args.json {
        outputs.write_json(file, &scaling)?;
    }
    if let Some(file) = &args.plot {
        scaling.plot(file, outputs)?;
    }
    outputs.tell(&scaling.text());
    if scaling.is_equal() { Ok(scaling.done) } else { Err(Failure::Cannot("the meshes differ".into())) }
}

/// Flies a path over a model.
fn along_a_path(input: &Input, args: &BenchArgs, common: &Common, outputs: &mut Outputs) -> Result<Done, Failure> {
    let progress = Progress::start(common);
    progress.stage(format!("reading {}", input.name()));
    let model = input.read(&common.limits.step())?;
    progress.stage("preparing");
    let prepared = Arc::new(prepare(model, &common.prepare()).map_err(unprepared)?);
    let views = views(args, &prepared)?;
    if let Some(file) = &args.save_path {
        route::save(&views, file, outputs)?;
    }
    let workers: Vec<usize> = common.workers.iter().map(|&n| usize::from(n)).collect();
    if args.hash {
        progress.stage(format!("flying {}", args.path.name()));
        let threads = workers.first().copied().unwrap_or(0);
        let (triangles, hash) = hash::of(&prepared, &views, threads, &common.limits)?;
        drop(progress);
        outputs.tell(&format!("triangles {triangles} hash {hash:016x}\n"));
        return Ok(Done::of(&prepared));
    }

    let cores = vec![std::thread::available_parallelism().map_or(1, usize::from)];
    let mut flights = Vec::new();
    for &coherence in &args.coherence {
        for &workers in if workers.is_empty() { &cores } else { &workers } {
            let (path, coherent) = (args.path.name(), name_of(&coherence));
            progress.stage(format!("flying {path}, coherence {coherent}, workers {workers}"));
            let (rounds, written) = (args.rounds as usize, false);
            let (prepared, views, threads) = (&prepared, &views[..], workers);
            flights.push(fly(&Order { prepared, views, threads, workers, coherence, written, rounds }, common)?);
        }
    }
    let numbers: Vec<usize> = args.replay.iter().map(|&n| usize::from(n)).collect();
    let mut replays = Vec::new();
    if !numbers.is_empty() {
        progress.stage("timing tiles");
        let costs = costs::record(&prepared, &views, common)?;
        let costly = costly(&prepared, &costs);
        replays.push(replayed(&costs, &numbers, Coherence::Off, costly));
        if views.len() > 1 && args.coherence.contains(&Coherence::On) {
            let costs = costs::record_changes(&prepared, &views, common)?;
            replays.push(replayed(&costs, &numbers, Coherence::On, Vec::new()));
        }
    }
    drop(progress);

    let report = Report {
        model: input.name(),
        machine: Machine::this(),
        tiles: prepared.tiles().count(),
        size: views[0].size,
        deviation_px: views[0].deviation_px,
        angle_deg: views[0].angle.to_degrees(),
        runs: flights.iter().map(|flight| Run::of(flight, args.path.name())).collect(),
        replays,
    };
    if let Some(file) = &args.json {
        outputs.write_json(file, &report)?;
    }
    if let Some(file) = &args.plot {
        plot::save(&report, &flights, file, outputs)?;
    }
    outputs.tell(&report.text());
    Ok(Done::of(&prepared))
}

/// Simulates each number of workers.
fn replayed(costs: &Costs, numbers: &[usize], coherence: Coherence, costly: Vec<Costly>) -> Replay {
    let Costs { tiles, stride, frames } = costs;
    let epoch = (EPOCH / stride).max(1);
    let row = |&workers: &usize| {
        let efficiency = |policy| replay(policy, tiles, frames, workers, epoch).efficiency();
        Row { workers, efficiency: Policy::ALL.map(|(name, policy)| (name, efficiency(policy))).into_iter().collect() }
    };
    // Tiles that were not made have cost 0.
    let all: Vec<f64> = frames.iter().flatten().filter(|&&ms| ms > 0.0).map(|ms| 1e3 * ms).collect();
    let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
    let most = all.iter().copied().fold(0.0, f64::max);
    Replay {
        coherence: name_of(&coherence),
        frames: frames.len(),
        tile_us: TileCosts { mean, spread: Percentiles::of(all), most },
        costly,
        rows: numbers.iter().map(row).collect(),
    }
}

/// The most expensive tiles of any frame, worst first.
fn costly(prepared: &Prepared, costs: &Costs) -> Vec<Costly> {
    const TOLD: usize = 5;
    let work: Vec<f64> = costs.frames.iter().map(|frame| frame.iter().sum()).collect();
    let worst = |(number, (part, tile, row)): (usize, (_, _, &trimtess::prepare::internals::Tile))| {
        let (frame, ms) = costs.frames.iter().map(|f| f[number]).enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let (part, tile): (trimtess::model::PartId, trimtess::model::TileId) = (part, tile);
        let rows = &prepared.parts[part.index()];
        let entity = rows.face_of(row).entity;
        Some(Costly { part: part.0, face: row.face.0, tile: tile.0, entity, us: 1e3 * ms, share: ms / work[frame] })
    };
    let mut all: Vec<Costly> = prepared.tiles().enumerate().filter_map(worst).collect();
    all.sort_by(|a, b| b.us.total_cmp(&a.us));
    all.truncate(TOLD);
    all
}
