//! `trimtess render`: a file to a picture within a screen-space error.

use crate::input::{self, Input};
use crate::laps::Laps;
use crate::limits::unprepared;
use crate::picture::{ANGLE, PictureArgs, require_png};
use crate::progress::Progress;
use crate::report::{Report, Seconds};
use crate::tessellate::{make, require_outputs, size};
use crate::{AsJson, Common, Done, Failure};
use std::path::PathBuf;
use std::sync::Arc;
use trimtess::frame::{self, Tolerance};
use trimtess::mesh::MemorySink;
use trimtess::out::Camera;
use trimtess::out::wgpu::Renderer;
use trimtess::prepare::{Prepared, prepare};

/// Chord tolerance of the coarse frame that the camera is fitted to, as a fraction of the diagonal.
const SCOUT_CHORD_REL: f64 = 1e-2;

/// `trimtess render`
#[derive(clap::Args)]
pub(crate) struct RenderArgs {
    /// A STEP file, builtin:NAME, or builtin:list.
    #[arg(value_name = "FILE", value_parser = input::parse)]
    pub(crate) input: Input,
    /// Output file, a PNG.
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x960")]
    size: (u32, u32),
    #[command(flatten)]
    picture: PictureArgs,
    /// Write a report as JSON.
    #[arg(long, value_name = "OUT.json")]
    report: Option<PathBuf>,
    #[command(flatten)]
    told: AsJson,
}

/// Runs the command.
pub(crate) fn run(args: &RenderArgs, common: &Common, mut laps: Laps) -> Result<Done, Failure> {
    let cannot = |e: &dyn std::error::Error| Failure::Cannot(e.to_string());
    require_png(&args.output)?;
    require_outputs(&args.output, args.report.as_deref())?;
    let progress = Progress::start(common);

    // First, because it is quick and fails early.
    progress.stage("opening the graphics adapter");
    let renderer = Renderer::new().map_err(|e| cannot(&e))?;
    let opened = laps.lap();

    progress.stage(format!("reading {}", args.input.name()));
    let model = args.input.read(&common.limits.step())?;
    let read = laps.lap();

    progress.stage("preparing");
    let prepared = Arc::new(prepare(model, &common.prepare()).map_err(unprepared)?);
    let prepare = laps.lap();

    progress.stage("tessellating");
    let camera = aim(args, common, &prepared)?;
    let view = args.picture.view(&camera, args.size);
    let plan = Arc::new(common.limits.accept(frame::plan_for_view_within(&prepared, &view, &common.limits.plan()))?);
    let mut frame = MemorySink::default();
    let made = make(&prepared, &plan, common, args.picture.edges, &mut frame)?;
    let mut report = Report::of(&frame, &prepared, &made);
    plan.shortfall.iter().for_each(|shortfall| report.add_warning(shortfall.to_string()));
    let tessellate = laps.lap();

    progress.stage("drawing");
    let options = args.picture.options(camera, args.size);
    let image = renderer.render(&frame, &options).map_err(|e| cannot(&e))?;
    image.write_png(&args.output).map_err(|e| cannot(&e))?;
    let write = opened + laps.lap();
    drop(progress);
    tracing::info!("drawn by {}", renderer.adapter());

    report.input = args.input.name();
    report.output = args.output.display().to_string();
    report.diagonal_mm = prepared.diagonal;
    report.workers = made.workers.len();
    report.seconds = Seconds { read, prepare, tessellate, check: 0.0, write, total: laps.total() };
    report.publish(common, args.told.json, args.report.as_deref())
}

/// Fits the camera to a coarse frame.
fn aim(args: &RenderArgs, common: &Common, prepared: &Arc<Prepared>) -> Result<Camera, Failure> {
    let tolerance = Tolerance { chord: SCOUT_CHORD_REL * prepared.diagonal, angle: ANGLE.to_radians(), max_edge: None };
    let plan = Arc::new(frame::plan_within(prepared, &tolerance, &common.limits.plan()));
    let mut scout = MemorySink::default();
    make(prepared, &plan, common, false, &mut scout)?;
    let points = scout.scene.instances.iter().flat_map(|instance| {
        // Batches come sorted by part.
        let from = scout.batches.partition_point(|batch| batch.part < instance.part);
        let of_part = scout.batches[from..].iter().take_while(|batch| batch.part == instance.part);
        of_part.flat_map(|batch| &batch.mesh.positions).map(|&point| instance.transform.transform_point3(point))
    });
    Ok(args.picture.fit(points, f64::from(args.size.0) / f64::from(args.size.1)))
}
