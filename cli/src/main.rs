//! Command line -> exit status: 0 all faces meshed, 3 done but with diagnostics, 1 cannot do it, 2 wrong usage.

mod bench;
mod closedness;
mod diagram;
mod fills;
mod info;
mod input;
mod laps;
mod limits;
mod logging;
mod memory;
mod patches;
#[cfg(feature = "wgpu")]
mod picture;
mod progress;
#[cfg(feature = "wgpu")]
mod render;
mod report;
mod tessellate;
#[cfg(feature = "view")]
mod view;

use clap::{Args, Parser, Subcommand};
use std::fmt;
use std::io::Write;
use std::path::PathBuf;
use std::process::exit;
use trimtess::prepare::PrepareOptions;

/// A file's syntax tree and its faces are millions of small pieces: a tenth of the time is the system's allocator.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Turns CAD files (trimmed NURBS) into watertight triangles and pictures.
#[derive(Parser)]
#[command(name = "trimtess", version, max_term_width = 120)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    common: Common,
}

/// What every subcommand takes.
#[derive(Args)]
struct Common {
    /// Threads to use at most (default: one per core). `bench` takes several, with commas, and measures each by itself.
    #[arg(long, global = true, value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..))]
    workers: Vec<u16>,
    /// Say more on standard error; repeat for more. `RUST_LOG` overrides it.
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    /// Say nothing on standard error but why it failed.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Write a timeline for chrome://tracing or Perfetto.
    #[arg(long, global = true, value_name = "OUT.json")]
    trace: Option<PathBuf>,
    /// Borders of faces without edges (kept whole, or freely trimmed) are one within this share of their part's diagonal, if the
    /// part states no tolerance of its own; 0 leaves them apart.
    #[arg(long, global = true, value_name = "SHARE", value_parser = share, default_value_t = PrepareOptions::DEFAULT.border_tolerance)]
    border_tolerance: f64,
    #[command(flatten)]
    limits: limits::LimitArgs,
}

/// A number from 0 to 1.
fn share(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().map_err(|e| e.to_string())?;
    if (0.0..=1.0).contains(&number) { Ok(number) } else { Err("a share is from 0 to 1".to_owned()) }
}

/// How a result is told.
#[derive(Args)]
struct AsJson {
    /// Print the result as JSON on standard output.
    #[arg(long)]
    json: bool,
}

impl Common {
    /// Threads to use at most; 0 for one per core.
    fn workers(&self) -> usize {
        self.workers.iter().max().map_or(0, |&most| usize::from(most))
    }

    fn prepare(&self) -> PrepareOptions {
        self.limits.prepare().with_border_tolerance(self.border_tolerance)
    }
}

#[derive(Subcommand)]
enum Command {
    /// What is in a file: parts, instances, faces by kind, units, box, closedness, diagnostics.
    Info(info::InfoArgs),
    /// A file to triangles: GLB, STL, PLY or OBJ.
    Tessellate(tessellate::TessellateArgs),
    /// A file to a picture: PNG.
    #[cfg(feature = "wgpu")]
    Render(render::RenderArgs),
    /// A file in a window: turn it, look close, ask what a face is; files dropped onto it are shown.
    #[cfg(feature = "view")]
    View(view::ViewArgs),
    /// A camera's path over a model, timed: frames, stages, workers, bytes.
    Bench(bench::BenchArgs),
}

impl Command {
    /// The file, if there is one.
    fn input(&self) -> Option<&input::Input> {
        match self {
            Self::Info(args) => Some(&args.input),
            Self::Tessellate(args) => Some(&args.input),
            #[cfg(feature = "wgpu")]
            Self::Render(args) => Some(&args.input),
            #[cfg(feature = "view")]
            Self::View(args) => args.input.as_ref(),
            Self::Bench(args) => args.input.as_ref(),
        }
    }
}

/// How a command that did its work ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Done {
    /// Every face was meshed as stated.
    Clean,
    /// Some faces carry a diagnostic, or `--check` found the mesh at fault.
    WithDiagnostics,
}

impl Done {
    fn status(self) -> i32 {
        match self {
            Self::Clean => 0,
            Self::WithDiagnostics => 3,
        }
    }
}

/// Why a command did not do its work.
#[derive(Debug)]
enum Failure {
    /// It cannot be done: what, where, and what to try.
    Cannot(String),
    /// It was asked for wrongly.
    Usage(String),
}

impl Failure {
    fn status(&self) -> i32 {
        match self {
            Self::Cannot(_) => 1,
            Self::Usage(_) => 2,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cannot(message) | Self::Usage(message) => f.write_str(message),
        }
    }
}

fn main() {
    let laps = laps::Laps::start();
    let cli = Cli::parse();
    logging::report_panics_as_errors();
    let trace = match logging::start(&cli.common) {
        Ok(trace) => trace,
        Err(failure) => leave(Err(failure)),
    };
    let result = run(cli, laps);
    let traced = trace.map_or(Ok(()), logging::Timeline::finish);
    leave(result.and_then(|done| traced.map(|()| done)))
}

/// Runs the command; a panic in the library is a defect and ends as status 1, with a message.
fn run(cli: Cli, laps: laps::Laps) -> Result<Done, Failure> {
    let work = move || {
        let Cli { command, common } = cli;
        let workers = common.workers();
        if common.workers.len() > 1 && !matches!(command, Command::Bench(_)) {
            return Err(Failure::Usage("--workers: only `bench` takes several numbers".into()));
        }
        // Zero is rayon's word, too, for one thread per core. This thread is one of them: it would only wait for the others, and
        // what it reads would be freed and paged in again for them.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(workers).use_current_thread().build_global();
        pool.map_err(|e| Failure::Cannot(format!("cannot start {workers} threads: {e}")))?;
        if command.input().is_some_and(input::Input::is_list) {
            tell(&input::builtin_list())?;
            return Ok(Done::Clean);
        }
        match command {
            Command::Info(args) => info::run(&args, &common),
            Command::Tessellate(args) => tessellate::run(&args, &common, laps),
            #[cfg(feature = "wgpu")]
            Command::Render(args) => render::run(&args, &common, laps),
            #[cfg(feature = "view")]
            Command::View(args) => view::run(&args, &common),
            Command::Bench(args) => bench::run(&args, &common),
        }
    };
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let what = "internal error (details above); please report it with the file that shows it";
        Err(Failure::Cannot(what.into()))
    })
}

/// Prints on standard output. Nobody who listens any more is no failure.
pub(crate) fn tell(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Failure::Cannot(format!("standard output: {e}"))),
        _ => Ok(()),
    }
}

/// Ends the process without taking large structures apart first.
fn leave(result: Result<Done, Failure>) -> ! {
    match result {
        Ok(done) => exit(done.status()),
        Err(failure) => {
            eprintln!("error: {failure}");
            exit(failure.status())
        }
    }
}
