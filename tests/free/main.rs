//! Free trims: the rules, the regions they keep, and the triangles that come of them.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod configurations;
mod draw;
mod meshes;
mod model;
mod regions;
