//! `trimtess render`: a file to a picture within a deviation in pixels.

use crate::input::{self, Input};
use crate::report::Laps;
use crate::{Common, Done, Failure};

/// `trimtess render`
#[derive(clap::Args)]
pub(crate) struct RenderArgs {
    /// A STEP file, builtin:NAME, or builtin:list.
    #[arg(value_name = "FILE", value_parser = input::parse)]
    pub(crate) input: Input,
}
/// Runs the command.
pub(crate) fn run(args: &RenderArgs, common: &Common, mut laps: Laps) -> Result<Done, Failure> {
    let _ = (&args.input, common, laps.lap());
    Ok(Done::Clean)
}
