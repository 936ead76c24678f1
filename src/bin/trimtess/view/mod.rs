//! `trimtess view`: a file in a window, or a picture of the window.

mod facts;
mod load;
mod looks;
mod paint;
mod panel;
mod screenshot;
mod viewer;
mod window;

use crate::input::{self, Input};
use crate::render::DEFAULT_DEVIATION_PX;
use crate::tessellate::{positive, size};
use crate::{Common, Done, Failure};
use load::Loader;
use looks::Looks;
use std::path::PathBuf;
use trimtess::out::ViewPoint;
use trimtess::out::wgpu::ColourBy;

/// `trimtess view`
#[derive(clap::Args)]
pub(crate) struct ViewArgs {
    /// A STEP file, builtin:NAME, or builtin:list. Without it the window waits for a file to be dropped.
    #[arg(value_name = "FILE", value_parser = input::parse)]
    pub(crate) input: Option<Input>,
    /// Width and height of the window.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x800")]
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
    /// Write a picture of the window instead of opening one: a PNG. Needs no display.
    #[arg(long, value_name = "OUT.png", requires = "input")]
    screenshot: Option<PathBuf>,
    /// Frames before the picture; the model turns by half a degree in each.
    #[arg(long, value_name = "N", default_value_t = 1, requires = "screenshot")]
    frames: u32,
    /// A click before the picture, in points from the window's upper left corner.
    #[arg(long, value_name = "X,Y", value_parser = point, requires = "screenshot")]
    click: Option<(f32, f32)>,
}

/// Reads X,Y.
fn point(text: &str) -> Result<(f32, f32), String> {
    let point = text.split_once(',').and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)));
    point.ok_or_else(|| format!("{text} is not X,Y, like 400,300"))
}

/// Runs the command.
pub(crate) fn run(args: &ViewArgs, common: &Common) -> Result<Done, Failure> {
    let workers = match common.workers() {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        workers => workers,
    };
    let looks = Looks {
        camera: args.camera.fit([], 1.0),
        colour_by: args.color_by,
        wireframe: args.wireframe,
        edges: args.edges,
        backfaces: args.backfaces,
        deviation: args.deviation_px,
        size: args.size_px,
        workers,
        turning: false,
        panel: true,
    };
    let loader = Loader::new(common);
    match (&args.screenshot, &args.input) {
        (Some(output), Some(input)) => screenshot::write(output, input, args, loader, looks)?,
        _ => window::run(args.input.clone(), args.size, loader, looks)?,
    }
    Ok(Done::Clean)
}
