//! `trimtess view`: a file, loaded by a thread of its own, in a window, or a screenshot of the window.

mod paint;
mod panel;
mod viewer;
mod window;

use crate::input::{self, Input};
use crate::limits::{LimitArgs, unprepared};
use crate::outputs::{Named, Outputs};
use crate::render::PictureArgs;
use crate::tessellate::size;
use crate::{Common, Done, Failure};
use panel::Looks;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use std::time::Instant;
use trimtess::control::{StartError, Threads};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, Prepared, prepare};

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
    pub(crate) fn outputs(&self) -> Named<'_> {
        Named::default().output("screenshot", self.screenshot.as_ref())
    }
}

/// Parses X,Y.
fn point(text: &str) -> Result<(f32, f32), String> {
    let point = text.split_once(',').and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)));
    point.ok_or_else(|| format!("{text} is not X,Y, like 400,300"))
}

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
            let image = window::screenshot(output, input, args, loader, looks)?;
            outputs.write(output, |file| image.encode(file))?;
        }
        _ => window::run(args.input.clone(), args.size, loader, looks)?,
    }
    Ok(Done::Clean)
}

/// Loads files.
#[derive(Clone)]
struct Loader {
    limits: LimitArgs,
    prepare: PrepareOptions,
    /// Number of threads; 0 for one per core.
    threads: usize,
}

/// A session whose threads all work while the window's, which only asks for frames, does something else.
fn session_of(prepared: &Arc<Prepared>, options: &SessionOptions) -> Result<Session, StartError> {
    let threads = Arc::new(Threads::start(options.threads)?);
    Ok(Session::start_on(threads, Arc::clone(prepared), options))
}

struct Loaded {
    name: String,
    prepared: Arc<Prepared>,
    session: Session,
    seconds: f64,
}

struct Loading {
    name: String,
    since: Instant,
    result: Receiver<Result<Loaded, String>>,
}

impl Loader {
    fn new(common: &Common) -> Self {
        Self { limits: common.limits.clone(), prepare: common.prepare(), threads: common.workers() }
    }

    /// Loads a file on this thread and its rayon pool.
    fn load(&self, input: &Input, session: &SessionOptions) -> Result<Loaded, Failure> {
        let start = Instant::now();
        let model = input.read(&self.limits.step())?;
        let prepared = Arc::new(prepare(model, &self.prepare).map_err(unprepared)?);
        let session = session_of(&prepared, session).map_err(Failure::cannot)?;
        Ok(Loaded { name: input.name(), prepared, session, seconds: start.elapsed().as_secs_f64() })
    }

    /// Starts loading a file on another thread.
    fn start(&self, input: Input, session: &SessionOptions) -> Loading {
        let (sender, result) = channel();
        let refused = sender.clone();
        let (loader, session, name) = (self.clone(), session.clone(), input.name());
        let work = move || {
            // A separate pool: the window's thread is a worker of the global one.
            let pool = rayon::ThreadPoolBuilder::new().num_threads(loader.threads).build();
            let loaded = match pool {
                Ok(pool) => pool.install(|| loader.load(&input, &session)).map_err(|failure| failure.to_string()),
                Err(error) => Err(error.to_string()),
            };
            // Fails if the window was closed meanwhile.
            let _ = sender.send(loaded);
        };
        if let Err(error) = thread::Builder::new().name("trimtess-load".into()).spawn(work) {
            // Cannot fail: the receiver is here.
            let _ = refused.send(Err(format!("cannot start a thread: {error}")));
        }
        Loading { name, since: Instant::now(), result }
    }
}

impl Loading {
    /// The result, once loading has ended.
    fn poll(&self) -> Option<Result<Loaded, String>> {
        match self.result.try_recv() {
            Ok(loaded) => Some(loaded),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                Some(Err("internal error while reading the file; see the terminal".into()))
            }
        }
    }
}
