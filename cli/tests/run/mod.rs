//! What a run told.

use std::process::Output;

/// Standard error of a run.
pub(crate) fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}
