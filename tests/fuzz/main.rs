//! Bytes -> files, models -> meshes, with the oracle as the judge. A plain `cargo test` tries random inputs for a second a
//! target; `BOLERO_RANDOM_TEST_TIME_MS` sets the time, and `cargo bolero test` steers by coverage (docs/decisions/010).
//!
//! What fails is shrunk and printed as a test, ready to be committed to `found.rs`.

mod draw;
mod found;
mod judge;
mod model;
mod sheet;
mod solid;
#[cfg(feature = "step")]
mod step;
mod watch;
