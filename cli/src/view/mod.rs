//! `trimtess view`: a file in a window, or a screenshot of the window.

mod load;
mod looks;
mod paint;
mod panel;
mod screenshot;
mod viewer;
mod window;

use crate::input::{self, Input};
use crate::outputs::{Named, Outputs};
use crate::picture::PictureArgs;
use crate::tessellate::size;
use crate::{Common, Done, Failure};
use load::Loader;
use looks::Looks;
use std::path::PathBuf;

/// Show a file in a window: orbit, zoom, pick faces. Files dropped onto the window are opened.
#[derive(clap::Args)]
pub(crate) struct ViewArgs {
    /// A STEP file, builtin:NAME, or builtin:list. Without it, the window opens empty and waits for a dropped file.
    #[arg(value_name = "FILE", value_parser = input::parser())]
    pub(crate) input: Option<Input>,
    /// Width and height of the window in points.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x800")]
    size: (u32, u32),
    #[command(flatten)]
    picture: PictureArgs,
    /// Write a screenshot (PNG) instead of opening a window. Needs no display.
    #[arg(long, value_name = "OUT.png", requires = "input")]
    screenshot: Option<PathBuf>,
    /// Number of frames before the screenshot; the model turns by half a degree per frame.
    #[arg(long, value_name = "N", default_value_t = 1, requires = "screenshot",
          value_parser = clap::value_parser!(u32).range(0..=100_000))]
    frames: u32,
    /// Click here before the screenshot, in points from the upper left corner of the window.
    #[arg(long, value_name = "X,Y", value_parser = point, allow_hyphen_values = true, requires = "screenshot")]
    click: Option<(f32, f32)>,
}

impl ViewArgs {
    /// The files to write.
    pub(crate) fn outputs(&self) -> Named<'_> {
        Named::default().output("screenshot", self.screenshot.as_ref())
    }
}

/// Parses X,Y.
fn point(text: &str) -> Result<(f32, f32), String> {
    let point = text.split_once(',').and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)));
    point.ok_or_else(|| format!("{text} is not X,Y, like 400,300"))
}

/// Runs the command.
pub(crate) fn run(args: &ViewArgs, common: &Common, outputs: &mut Outputs) -> Result<Done, Failure> {
    let workers = match common.workers() {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        workers => workers,
    };
    let camera = args.picture.fit([], 1.0);
    let looks = Looks { camera, picture: args.picture.clone(), workers, turning: false, panel: true };
    let loader = Loader::new(common);
    match (&args.screenshot, &args.input) {
        (Some(output), Some(input)) => {
            let image = screenshot::draw(output, input, args, loader, looks)?;
            outputs.write(output, |file| image.encode(file))?;
        }
        _ => window::run(args.input.clone(), args.size, loader, looks)?,
    }
    Ok(Done::Clean)
}
