//! `trimtess render`: a file to a picture within a screen-space error.

use crate::input::{self, Input};
use crate::limits::unprepared;
use crate::made::make;
use crate::outputs::{Named, Outputs};
use crate::picture::{PictureArgs, require_png};
use crate::progress::Progress;
use crate::report::{Seconds, lap};
use crate::tessellate::size;
use crate::{Common, Done, Failure};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;
use trimtess::control::{Control, Rayon};
use trimtess::frame;
use trimtess::mesh::MeshLists;
use trimtess::out::wgpu::Renderer;
use trimtess::parallel;
use trimtess::prepare::{Prepared, prepare};
use trimtess::view::Camera;

/// Render a file to a PNG picture.
#[derive(clap::Args)]
pub(crate) struct RenderArgs {
    /// A STEP file, builtin:NAME, or builtin:list.
    #[arg(value_name = "FILE", value_parser = input::parser())]
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
    /// Print the result to standard output as JSON.
    #[arg(long)]
    json: bool,
}

impl RenderArgs {
    /// The files to write.
    pub(crate) fn outputs(&self) -> Named<'_> {
        Named::default().output("output", Some(&self.output)).output("report", self.report.as_ref())
    }
}

/// Runs the command.
pub(crate) fn run(args: &RenderArgs, common: &Common, outputs: &mut Outputs) -> Result<Done, Failure> {
    require_png(&args.output)?;
    let progress = Progress::start(common);
    let mut begun = Instant::now();

    // First, because it is quick and fails early.
    progress.stage("opening the graphics adapter");
    let renderer = Renderer::new().map_err(Failure::cannot)?;
    let opened = lap(&mut begun);

    progress.stage(format!("reading {}", args.input.name()));
    let model = args.input.read(&common.limits.step())?;
    let read = lap(&mut begun);

    progress.stage("preparing");
    let prepared = Arc::new(prepare(model, &common.prepare()).map_err(unprepared)?);
    let prepare = lap(&mut begun);

    progress.stage("tessellating");
    let camera = aim(args, common, &prepared)?;
    let view = args.picture.view(&camera, args.size);
    let plan = Arc::new(frame::plan_for_view_within(&prepared, &view, &common.limits.plan()));
    let (frame, mut report) = make(&prepared, &plan, (args.picture.edges, MeshLists::ALL), &common.limits)?;
    let tessellate = lap(&mut begun);

    progress.stage("drawing");
    let options = args.picture.options(camera, args.size, prepared.bounds);
    let image = renderer.render(&frame, &options).map_err(Failure::cannot)?;
    outputs.write(&args.output, |file| image.encode(file))?;
    let write = opened + lap(&mut begun);
    drop(progress);
    tracing::info!("drawn by {}", renderer.adapter());

    report.input = args.input.name();
    report.output = args.output.display().to_string();
    report.diagonal_mm = prepared.diagonal;
    report.workers = rayon::current_num_threads();
    report.seconds = Seconds::new([read, prepare, tessellate, write], None);
    report.publish(common, args.json, args.report.as_deref(), outputs)
}

/// Fits the camera to a coarse frame.
fn aim(args: &RenderArgs, common: &Common, prepared: &Arc<Prepared>) -> Result<Camera, Failure> {
    let points = parallel::coarse_points(&Rayon, prepared, &common.limits.plan(), &Control::default());
    let points = points.map_err(Failure::cannot)?;
    Ok(args.picture.fit(points, f64::from(args.size.0) / f64::from(args.size.1)))
}
