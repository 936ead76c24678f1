//! A module built for wasm32-unknown-unknown -> the module with its JavaScript and its types.
//!
//!     trimtess-web-bind MODULE.wasm FOLDER

use anyhow::Context as _;
use std::env::args_os;
use wasm_bindgen_cli_support::Bindgen;

fn main() -> anyhow::Result<()> {
    let mut args = args_os().skip(1);
    let (module, folder) = args.next().zip(args.next()).context("trimtess-web-bind MODULE.wasm FOLDER")?;
    let mut bindgen = Bindgen::new();
    bindgen.input_path(module).web(true)?.typescript(true).out_name("trimtess_web");
    // The module is next to its JavaScript, unless the caller of `init` says otherwise.
    bindgen.omit_default_module_path(false).generate(folder)
}
