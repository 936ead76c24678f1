//! Bytes -> files and models -> meshes, judged by the oracle. A plain `cargo test` tries the first inputs of one fixed
//! sequence, `FUZZ_MS` runs for a time, and `cargo bolero test` steers by coverage (docs/decisions/010 and 017).
//!
//! A failing input is shrunk and printed as a test, ready to be committed to `found.rs`.

#[path = "../chains/mod.rs"]
mod chains;
mod draw;
mod found;
mod judge;
mod model;
#[path = "../parts/mod.rs"]
mod parts;
#[path = "../process/mod.rs"]
mod process;
#[path = "../sequence/mod.rs"]
mod sequence;
mod sheet;
mod solid;
#[cfg(feature = "step")]
mod step;
mod watch;
