//! Runs of the program.
#![allow(dead_code, reason = "not every test program uses all of it")]

use std::path::Path;
use std::process::{Command, Output};

/// Root of the repository.
pub(crate) const CHECKOUT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
pub(crate) const BINARY: &str = env!("CARGO_BIN_EXE_trimtess");
/// A file of two parts, from the root of the repository.
pub(crate) const CUBE: &str = "tests/data/red_cube_blue_cylinder.step";

/// The program with these arguments, in a folder, with its own filter of messages.
pub(crate) fn command(folder: impl AsRef<Path>, args: &[&str]) -> Command {
    let mut command = Command::new(BINARY);
    command.args(args).current_dir(folder).env_remove("RUST_LOG");
    command
}

/// Standard error of a run.
pub(crate) fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}
