//! The trim triangulation of one tile: the degenerate cases by name, and random tiles against the reference.

mod cases;
mod checker;
mod fuzz;
mod generator;
