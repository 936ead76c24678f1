//! Patches without topology that lie side by side: their common borders are one edge, and what is open is counted.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod joints;
mod patches;
mod sheets;
mod trims;
