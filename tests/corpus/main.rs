//! Every STEP file of the corpora beside the checkout. Skipped, with a message, if a corpus is absent.
#![cfg(feature = "step")]

#[path = "../common/mod.rs"]
mod common;
#[path = "../flipped/mod.rs"]
mod flipped;
mod folder;
mod mesh;
mod orientation;
mod read;
mod reference;
