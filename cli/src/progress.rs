//! Stages of long work -> a spinner on standard error if that is a terminal.

use crate::Common;
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::time::Duration;

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
