//! `trimtess render`: a file to a picture within a deviation in pixels.

use crate::input::{self, Input};
use crate::laps::Laps;
use crate::limits::unprepared;
use crate::progress::Progress;
use crate::report::{Report, Seconds};
use crate::tessellate::{make, positive, require_outputs, size};
use crate::{AsJson, Common, Done, Failure};
use std::path::PathBuf;
use std::sync::Arc;
use trimtess::frame::{self, Projection, Tolerance, View};
use trimtess::mesh::MemorySink;
use trimtess::out::wgpu::{ColourBy, RenderOptions, Renderer};
use trimtess::out::{Camera, ViewPoint};
use trimtess::prepare::{Prepared, prepare};

/// Largest deviation in pixels when none is asked for: half a pixel is below what 4× multisampling shows.
pub(crate) const DEFAULT_DEVIATION_PX: f64 = 0.5;

/// Angle tolerance in pictures, degrees. Normals are exact at vertices; this keeps what is interpolated between them close.
const ANGLE: f64 = 30.0;

/// Chord of the frame that only tells the camera what to hold, as a fraction of the diagonal.
const SCOUT_CHORD_REL: f64 = 1e-2;

/// `trimtess render`
#[derive(clap::Args)]
pub(crate) struct RenderArgs {
    /// A STEP file, builtin:NAME, or builtin:list.
    #[arg(value_name = "FILE", value_parser = input::parse)]
    pub(crate) input: Input,
    /// Where the picture goes: a PNG.
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x960")]
    size: (u32, u32),
    /// Largest distance between picture and exact surface, pixels.
    #[arg(long, value_name = "P", value_parser = positive, default_value_t = DEFAULT_DEVIATION_PX)]
    deviation_px: f64,
    /// Largest length of a triangle's edge, pixels.
    #[arg(long, value_name = "S", value_parser = positive)]
    size_px: Option<f64>,
    /// From where: iso, front, back, left, right, top, bottom, or yaw,pitch,distance (degrees; 1 = all fits).
    #[arg(long, value_name = "FROM", default_value = "iso", allow_hyphen_values = true)]
    camera: ViewPoint,
    /// What colours tell: model, part, face, tile, worker, rate.
    #[arg(long, value_name = "WHAT", default_value = "model")]
    color_by: ColourBy,
    /// Draw the edges of triangles.
    #[arg(long)]
    wireframe: bool,
    /// Draw the edges of the model.
    #[arg(long)]
    edges: bool,
    /// Draw surfaces seen from behind in magenta.
    #[arg(long)]
    backfaces: bool,
    /// Write a report as JSON.
    #[arg(long, value_name = "OUT.json")]
    report: Option<PathBuf>,
    #[command(flatten)]
    told: AsJson,
}

/// Runs the command.
pub(crate) fn run(args: &RenderArgs, common: &Common, mut laps: Laps) -> Result<Done, Failure> {
    let cannot = |e: &dyn std::error::Error| Failure::Cannot(e.to_string());
    if !args.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        return Err(Failure::Usage(format!("{}: pictures are written as .png", args.output.display())));
    }
    require_outputs(&args.output, args.report.as_deref())?;
    let progress = Progress::start(common);

    // First, because it is quick and nothing can be drawn without one.
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
    let view = view_of(&camera, args.size, args.deviation_px, args.size_px);
    let plan = Arc::new(common.limits.accept(frame::plan_for_view_within(&prepared, &view, &common.limits.plan()))?);
    let mut frame = MemorySink::default();
    let made = make(&prepared, &plan, common, args.edges, &mut frame)?;
    let mut report = Report::of(&frame, &prepared, &made);
    plan.shortfall.iter().for_each(|shortfall| report.add_warning(shortfall.to_string()));
    let tessellate = laps.lap();

    progress.stage("drawing");
    let options = RenderOptions {
        size: args.size,
        camera: Some(camera),
        colour_by: args.color_by,
        wireframe: args.wireframe,
        edges: args.edges,
        backfaces: args.backfaces,
        ..RenderOptions::DEFAULT
    };
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

/// What a camera's picture asks for, with deviation and size in pixels.
pub(crate) fn view_of(camera: &Camera, size: (u32, u32), deviation_px: f64, size_px: Option<f64>) -> View {
    View {
        eye: camera.eye,
        forward: camera.target - camera.eye,
        up: camera.up,
        projection: Projection::Perspective { fov_y: camera.fov_y, near: 0.0 },
        size,
        deviation_px,
        size_px,
        angle: ANGLE.to_radians(),
    }
}

/// The camera that holds what a coarse frame shows.
fn aim(args: &RenderArgs, common: &Common, prepared: &Arc<Prepared>) -> Result<Camera, Failure> {
    let tolerance = Tolerance { chord: SCOUT_CHORD_REL * prepared.diagonal, angle: ANGLE.to_radians(), max_edge: None };
    let plan = Arc::new(frame::plan_within(prepared, &tolerance, &common.limits.plan()));
    let mut scout = MemorySink::default();
    make(prepared, &plan, common, false, &mut scout)?;
    let points = scout.scene.instances.iter().flat_map(|instance| {
        // Batches come sorted by part.
        let from = scout.batches.partition_point(|batch| batch.part.0 < instance.part);
        let of_part = scout.batches[from..].iter().take_while(|batch| batch.part.0 == instance.part);
        of_part.flat_map(|batch| &batch.mesh.positions).map(|&point| instance.transform.transform_point3(point))
    });
    Ok(args.camera.fit(points, f64::from(args.size.0) / f64::from(args.size.1)))
}
