//! `-v`, `-q`, `RUST_LOG`, `--trace` -> the log or a spinner on standard error, and a timeline file.

use crate::outputs::Outputs;
use crate::{Common, Failure};
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use std::io::{IsTerminal, Write, stderr};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tracing_chrome::{ChromeLayerBuilder, FlushGuard};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{EnvFilter, Layer, fmt};

/// A timeline that is being recorded in memory and written atomically at the end.
pub(crate) struct Timeline {
    guard: FlushGuard,
    recorded: Recorded,
    path: PathBuf,
}

#[derive(Clone, Default)]
struct Recorded(Arc<Mutex<Vec<u8>>>);

impl Write for Recorded {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Timeline {
    /// Writes the file.
    pub(crate) fn finish(self, outputs: &mut Outputs) -> Result<(), Failure> {
        drop(self.guard);
        let recorded = self.recorded.0.lock().unwrap_or_else(PoisonError::into_inner);
        outputs.write(&self.path, |file| file.write_all(&recorded))
    }
}

/// Starts logging, and records a timeline if `--trace` is given.
pub(crate) fn start(common: &Common) -> Result<Option<Timeline>, Failure> {
    let level = match (common.quiet, common.verbose) {
        (true, _) => "error",
        (_, 0) => "warn",
        (_, 1) => "warn,trimtess=info",
        (_, 2) => "warn,trimtess=debug",
        _ => "trace",
    };
    let filter = match std::env::var(EnvFilter::DEFAULT_ENV) {
        Ok(text) => EnvFilter::try_new(&text).map_err(|e| Failure::Usage(format!("RUST_LOG={text}: {e}")))?,
        Err(_) => EnvFilter::new(level),
    };
    let log = fmt::layer()
        .with_writer(stderr)
        .with_ansi(stderr().is_terminal())
        .with_target(false)
        .with_timer(fmt::time::uptime())
        // Failures to write would be printed to standard error again, by a macro that panics.
        .log_internal_errors(false)
        .with_filter(filter);
    let Some(path) = &common.trace else {
        tracing_subscriber::registry().with(log).init();
        return Ok(None);
    };
    let recorded = Recorded::default();
    let (timeline, guard) = ChromeLayerBuilder::new().writer(recorded.clone()).include_args(true).build();
    let timeline = timeline.with_filter(EnvFilter::new("trimtess=trace"));
    tracing_subscriber::registry().with(log).with(timeline).init();
    Ok(Some(Timeline { guard, recorded, path: path.clone() }))
}

/// Logs panics as internal errors with their source location. The code that catches a panic reports its consequences.
pub(crate) fn report_panics_as_errors() {
    std::panic::set_hook(Box::new(|info| {
        let place = info.location().map(ToString::to_string).unwrap_or_default();
        let text = info.payload().downcast_ref::<&str>().copied();
        let text = text.or_else(|| info.payload().downcast_ref::<String>().map(String::as_str));
        let what = text.unwrap_or("no message");
        tracing::error!("internal error at {place}: {what}");
    }));
}

/// A spinner, or nothing.
pub(crate) struct Progress(Option<ProgressBar>);

impl Progress {
    /// Starts a spinner. Shows nothing with `-q`, with `-v` (which logs the stages) and without a terminal.
    pub(crate) fn start(common: &Common) -> Self {
        if common.quiet || common.verbose > 0 || !stderr().is_terminal() {
            return Self(None);
        }
        let bar = ProgressBar::new_spinner().with_finish(ProgressFinish::AndClear);
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(120));
        Self(Some(bar))
    }

    /// Shows and logs the start of a stage.
    pub(crate) fn stage(&self, what: impl Into<String>) {
        let what = what.into();
        tracing::info!("{what}");
        if let Some(bar) = &self.0 {
            bar.set_message(what);
        }
    }
}
