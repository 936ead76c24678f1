//! STEP files with other points -> meshes as closed as before. Broken files are tested through the command line:
//! `cli/tests/mutants`.
#![cfg(feature = "step")]

mod far;
mod geometry;
#[path = "../parts/mod.rs"]
mod parts;
mod points;
#[path = "../sequence/random.rs"]
mod random;
