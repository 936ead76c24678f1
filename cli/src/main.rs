//! Command line -> exit status: 0 success, 3 success with diagnostics, 1 failure, 2 wrong usage.

mod bench;
mod closedness;
mod diagram;
mod info;
mod input;
mod levels;
mod limits;
mod logging;
mod made;
mod outputs;
mod patches;
#[cfg(feature = "wgpu")]
mod render;
mod report;
mod rounded;
mod tessellate;
#[cfg(feature = "view")]
mod view;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use input::Input;
use outputs::{Named, Outputs};
use std::fmt;
use std::io::Write;
use std::path::PathBuf;
use std::process::exit;
use trimtess::model::Diagnostic;
use trimtess::prepare::{PrepareOptions, Prepared};

/// Reading and preparing make millions of small allocations; the system's allocator would take a tenth of the time.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Converts CAD files (trimmed NURBS) to watertight triangle meshes and pictures.
#[derive(Parser)]
#[command(name = "trimtess", version, max_term_width = 120)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    common: Common,
}

/// Maximum number of threads that can be asked for: starting more takes longer than any file.
const MOST_WORKERS: i64 = 1024;

/// Stack of a thread, as the main thread has on Linux.
const STACK: usize = 8 << 20;

/// Options of every subcommand.
#[derive(Args)]
struct Common {
    /// Maximum number of threads (default: one per core). `bench` accepts a comma-separated list and measures each.
    #[arg(long, global = true, value_name = "N", value_delimiter = ',',
          value_parser = clap::value_parser!(u16).range(1..=MOST_WORKERS))]
    workers: Vec<u16>,
    /// Log more to standard error; repeat for more detail. `RUST_LOG` overrides it.
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    /// Print nothing except errors, and results that are asked for: `--json`, and those of `info` and `bench`.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Write a timeline for chrome://tracing or Perfetto.
    #[arg(long, global = true, value_name = "OUT.json")]
    trace: Option<PathBuf>,
    /// Sew borders of faces without edges (untrimmed, or trimmed by free curves) that are within this fraction of the
    /// part's diagonal, and edges of faces in open shells that are also within the part's own tolerance. Borders in
    /// parts that state a tolerance use that; 0 sews neither.
    #[arg(long, global = true, value_name = "SHARE", value_parser = share,
          default_value_t = PrepareOptions::DEFAULT.border_tolerance)]
    border_tolerance: f64,
    #[command(flatten)]
    limits: limits::LimitArgs,
}

/// Parses a number from 0 to 1.
fn share(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().map_err(|e| e.to_string())?;
    (0.0..=1.0).contains(&number).then_some(number).ok_or_else(|| "the value must be from 0 to 1".into())
}

/// The name of a value on the command line.
fn name_of(value: &impl clap::ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

impl Common {
    /// Maximum number of threads; 0 for one per core.
    fn workers(&self) -> usize {
        self.workers.iter().max().map_or(0, |&most| usize::from(most))
    }

    fn prepare(&self) -> PrepareOptions {
        self.limits.prepare().with_border_tolerance(self.border_tolerance)
    }
}

#[derive(Subcommand)]
#[command(defer = true)]
enum Command {
    Info(info::InfoArgs),
    Tessellate(tessellate::TessellateArgs),
    #[cfg(feature = "wgpu")]
    Render(render::RenderArgs),
    #[cfg(feature = "view")]
    View(view::ViewArgs),
    Bench(bench::BenchArgs),
}

impl Command {
    /// The input argument, if given, and the other files that the command's arguments name.
    fn files(&self) -> (Option<&Input>, Named<'_>) {
        match self {
            Self::Info(args) => (Some(&args.input), args.outputs()),
            Self::Tessellate(args) => (Some(&args.input), args.outputs()),
            #[cfg(feature = "wgpu")]
            Self::Render(args) => (Some(&args.input), args.outputs()),
            #[cfg(feature = "view")]
            Self::View(args) => (args.input.as_ref(), args.outputs()),
            Self::Bench(args) => (args.input.as_ref(), args.files()),
        }
    }
}

/// Result of a command that succeeded.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Done {
    /// Every face was meshed as stated in the file.
    Clean,
    /// Some faces have a diagnostic, or `--check` failed.
    WithDiagnostics,
}

impl Done {
    /// `WithDiagnostics` if the model has no faces, or there is an error or a warning about a face.
    fn of(prepared: &Prepared) -> Self {
        let faceless = prepared.scene.instances.iter().all(|instance| {
            prepared.scene.parts.get(instance.part.index()).is_none_or(|part| part.face_colours.is_empty())
        });
        if faceless || prepared.diagnostics.iter().any(Diagnostic::is_fault) {
            Self::WithDiagnostics
        } else {
            Self::Clean
        }
    }
}

/// Error of a command that failed.
#[derive(Debug)]
enum Failure {
    /// The command failed. The message says what, where, and what to try.
    Cannot(String),
    /// The command line is wrong.
    Usage(String),
}

impl Failure {
    /// The failure of a command, in the words of an error.
    fn cannot(why: impl fmt::Display) -> Self {
        Self::Cannot(why.to_string())
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
    let cli = parsed();
    logging::report_panics_as_errors();
    let trace = match logging::start(&cli.common) {
        Ok(trace) => trace,
        Err(failure) => leave(Err(failure)),
    };
    leave(run(cli).and_then(|(done, mut outputs)| {
        trace.map_or(Ok(()), |trace| trace.finish(&mut outputs))?;
        outputs.publish().map(|()| done)
    }))
}

/// The command line. A valid one needs the arguments of its own command alone: those of all take a tenth of a
/// millisecond.
fn parsed() -> Cli {
    Cli::try_parse().unwrap_or_else(|_| {
        let matches = command().get_matches();
        Cli::from_arg_matches(&matches).unwrap_or_else(|e| e.exit())
    })
}

/// What the command line may say, for help and errors. A negative number after an option is its value, so that the
/// option's own check refuses it with a reason.
fn command() -> clap::Command {
    fn with_negatives(command: clap::Command) -> clap::Command {
        command
            .mut_args(|arg| if arg.get_action().takes_values() { arg.allow_negative_numbers(true) } else { arg })
            .mut_subcommands(with_negatives)
    }
    let mut plain = Cli::command();
    // Subcommands get their arguments and descriptions only then.
    plain.build();
    with_negatives(plain)
}

/// Runs the command. A panic in the library is a bug: it becomes status 1 and a message.
fn run(cli: Cli) -> Result<(Done, Outputs), Failure> {
    let work = move || {
        let Cli { command, common } = cli;
        let workers = common.workers();
        let mut outputs = Outputs::default();
        let (input, mut named) = command.files();
        named.inputs.extend(input.and_then(Input::path));
        named.output("timeline", common.trace.as_ref()).check()?;
        if common.workers.len() > 1 && !matches!(command, Command::Bench(_)) {
            return Err(Failure::Usage(
                "--workers is given several numbers: only `bench` measures more than one".into(),
            ));
        }
        // 0 means one thread per core to rayon, too. This thread joins the pool: it would only wait for the others, and
        // the memory it frees after reading would be paged in again for them.
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(workers).stack_size(STACK).use_current_thread().build_global();
        pool.map_err(|e| Failure::Cannot(format!("cannot start {workers} threads: {e}")))?;
        if input.is_some_and(Input::is_list) {
            outputs.tell(&input::builtin_list());
            return Ok((Done::Clean, outputs));
        }
        let done = match command {
            Command::Info(args) => info::run(&args, &common, &mut outputs),
            Command::Tessellate(args) => tessellate::run(&args, &common, &mut outputs),
            #[cfg(feature = "wgpu")]
            Command::Render(args) => render::run(&args, &common, &mut outputs),
            #[cfg(feature = "view")]
            Command::View(args) => view::run(&args, &common, &mut outputs),
            Command::Bench(args) => bench::run(&args, &common, &mut outputs),
        }?;
        Ok((done, outputs))
    };
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let what = "internal error (details above); please report it with the file that caused it";
        Err(Failure::Cannot(what.into()))
    })
}

/// Prints to standard output. A closed pipe is not an error.
pub(crate) fn tell(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Failure::Cannot(format!("standard output: {e}"))),
        _ => Ok(()),
    }
}

/// Exits without dropping large structures first.
fn leave(result: Result<Done, Failure>) -> ! {
    if let Err(failure) = &result {
        // `eprintln` panics where standard error is closed or full.
        let _ = writeln!(std::io::stderr(), "error: {failure}");
    }
    exit(match result {
        Ok(Done::Clean) => 0,
        Err(Failure::Cannot(_)) => 1,
        Err(Failure::Usage(_)) => 2,
        Ok(Done::WithDiagnostics) => 3,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::error::ErrorKind;

    #[test]
    fn every_command_says_what_it_does() {
        let all = command();
        let about = |of: &clap::Command| of.get_about().map(ToString::to_string).unwrap_or_default();
        let named = |name: &str| all.get_subcommands().find(|of| of.get_name() == name).map(about).unwrap_or_default();
        assert!(named("info").starts_with("Print what is in a file"), "{:?}", named("info"));
        assert!(named("tessellate").starts_with("Tessellate a file"), "{:?}", named("tessellate"));
        assert!(named("bench").starts_with("Measure frame times"), "{:?}", named("bench"));
    }

    #[test]
    fn every_option_sees_a_negative_number() {
        let all = command();
        let mut seen = 0;
        for command in all.get_subcommands() {
            for arg in
                command.get_arguments().filter(|arg| arg.get_action().takes_values() && !arg.is_require_equals_set())
            {
                let Some(long) = arg.get_long() else { continue };
                let line = ["trimtess", command.get_name(), "builtin:box", &format!("--{long}"), "-1"];
                let parsed = all.clone().try_get_matches_from(line);
                let refused = parsed.err().is_some_and(|e| e.kind() == ErrorKind::UnknownArgument);
                assert!(!refused, "{line:?}");
                seen += 1;
            }
        }
        assert!(seen > 50, "{seen} options");
    }
}
