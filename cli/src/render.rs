//! `trimtess render`: a file to a picture within a screen-space error, and the options of pictures.

use crate::input::{self, Input};
use crate::limits::unprepared;
use crate::logging::Progress;
use crate::made::make;
use crate::outputs::{Named, Outputs};
use crate::report::{Seconds, lap};
use crate::tessellate::{positive, size};
use crate::{Common, Done, Failure};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::time::Instant;
use trimtess::control::{Control, Rayon};
use trimtess::glam::DVec3;
use trimtess::mesh::MeshLists;
use trimtess::out::wgpu::{ColourBy, RenderOptions, Renderer, Section};
use trimtess::prepare::{Prepared, prepare};
use trimtess::view::{Camera, View, ViewPoint};
use trimtess::{frame, parallel};

/// Refuses an output that is not called `.png`.
pub(crate) fn require_png(output: &Path) -> Result<(), Failure> {
    if output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        return Ok(());
    }
    Err(Failure::Usage(format!("{}: the output must be a .png file", output.display())))
}

/// Options of a picture.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct PictureArgs {
    /// Maximum screen-space error, pixels. Half a pixel is below what 4× multisampling shows.
    #[arg(long, value_name = "P", value_parser = positive, default_value_t = 0.5)]
    pub(crate) deviation_px: f64,
    /// Maximum length of lattice cell diagonals and edge segments on the screen, pixels.
    #[arg(long, value_name = "S", value_parser = positive)]
    pub(crate) size_px: Option<f64>,
    /// View point: iso, front, back, left, right, top, bottom, or yaw,pitch,distance (angles in degrees; at distance 1
    /// the model just fits).
    #[arg(long, value_name = "FROM", default_value = "iso", allow_hyphen_values = true)]
    pub(crate) camera: ViewPoint,
    /// Use an orthographic camera instead of a perspective one.
    #[arg(long)]
    pub(crate) orthographic: bool,
    /// Colour by: model, part, face, tile, worker, or rate (lattice cells per tile).
    #[arg(long, value_name = "WHAT", default_value = "model")]
    pub(crate) color_by: ColourBy,
    /// Draw triangle edges.
    #[arg(long)]
    pub(crate) wireframe: bool,
    /// Draw the lattice lines of tiles.
    #[arg(long)]
    pub(crate) lattice: bool,
    /// Draw the model's B-rep edges.
    #[arg(long)]
    pub(crate) edges: bool,
    /// Draw back-facing surfaces in magenta.
    #[arg(long)]
    pub(crate) backfaces: bool,
    /// Cut the model open: x, y or z for the middle of its box, with the share at which to cut (x:0.3); -x cuts away
    /// the lower side.
    #[arg(long, value_name = "AXIS[:SHARE]", allow_hyphen_values = true)]
    pub(crate) section: Option<Cut>,
}

/// Where a section cuts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cut {
    /// 0 to 2.
    pub(crate) axis: usize,
    /// Of the model's box along the axis, 0 to 1.
    pub(crate) share: f64,
    /// Whether the lower side is cut away.
    pub(crate) flipped: bool,
}

impl Cut {
    /// Through the middle.
    pub(crate) const MIDDLE: Self = Self { axis: 0, share: 0.5, flipped: false };
}

impl FromStr for Cut {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (axis, share) = text.split_once(':').unwrap_or((text, "0.5"));
        let (flipped, axis) = axis.strip_prefix('-').map_or((false, axis), |axis| (true, axis));
        let axis = ["x", "y", "z"].iter().position(|name| *name == axis);
        let share = share.parse().ok().filter(|share| (0.0..=1.0).contains(share));
        let (Some(axis), Some(share)) = (axis, share) else {
            return Err("an axis (x, y, z, -x, -y or -z), and a share from 0 to 1 after a colon".to_owned());
        };
        Ok(Self { axis, share, flipped })
    }
}

impl PictureArgs {
    /// Fits the camera to these points, seen from the selected view point.
    pub(crate) fn fit(&self, points: impl IntoIterator<Item = DVec3>, aspect: f64) -> Camera {
        self.camera.fit_as(self.orthographic, points, aspect)
    }

    /// Render options for a picture of `size` pixels of a model within `bounds`, seen by `camera`.
    pub(crate) fn options(&self, camera: Camera, size: (u32, u32), bounds: Option<[DVec3; 2]>) -> RenderOptions {
        let section = self.section.zip(bounds).map(|(cut, bounds)| {
            let section = Section::across(bounds, cut.axis, cut.share);
            if cut.flipped { section.flipped() } else { section }
        });
        RenderOptions::DEFAULT
            .with_size(size)
            .with_camera(Some(camera))
            .with_colour_by(self.color_by)
            .with_wireframe(self.wireframe)
            .with_lattice(self.lattice)
            .with_edges(self.edges)
            .with_backfaces(self.backfaces)
            .with_section(section)
    }

    /// The view that the frame is planned for.
    pub(crate) fn view(&self, camera: &Camera, size: (u32, u32)) -> View {
        View { camera: *camera, size, deviation_px: self.deviation_px, size_px: self.size_px, angle: View::ANGLE }
    }
}

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
    pub(crate) fn outputs(&self) -> Named<'_> {
        Named::default().output("output", Some(&self.output)).output("report", self.report.as_ref())
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_has_an_axis_and_a_share() {
        assert_eq!("x".parse(), Ok(Cut::MIDDLE));
        assert_eq!("-z:0.25".parse(), Ok(Cut { axis: 2, share: 0.25, flipped: true }));
        for bad in ["", "w", "x:", "x:2", "x:nan", "x:-0.1", "--x", "xy", "x:0.5:0.5"] {
            assert!(bad.parse::<Cut>().is_err(), "{bad}");
        }
    }
}
