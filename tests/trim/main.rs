//! Trim triangulation of one tile: degenerate cases by name, random tiles against the reference, and prepared models
//! under random plans.

mod cases;
mod checker;
#[path = "../common/mod.rs"]
mod common;
mod fuzz;
mod generator;
mod rates;
#[path = "../sequence/mod.rs"]
mod sequence;
