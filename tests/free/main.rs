//! Free trims: the rules, the regions they keep, and the resulting triangles.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "../common/mod.rs"]
mod common;
mod configurations;
mod draw;
#[path = "../implicit/mod.rs"]
mod implicit;
mod meshes;
mod model;
mod other;
mod polylines;
#[path = "../sequence/random.rs"]
mod random;
mod regions;
mod seams;
