//! Adjacent patches without topology: their common borders become one edge, and open edges are counted.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "../common/mod.rs"]
mod common;
mod joints;
mod patches;
mod sheets;
mod trims;
