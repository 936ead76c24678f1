//! Where the corpora are.
#![allow(dead_code, reason = "the viewer's tests look at the first one only")]

use std::path::{Path, PathBuf};

/// The folder of the corpus. Prints a message if it is absent.
pub(crate) fn corpus() -> Option<PathBuf> {
    beside_the_checkout("../shared/corpus")
}

/// A folder with a reference.jsonl, relative to the checkout. Prints a message if it is absent.
pub(crate) fn beside_the_checkout(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    if path.join("reference.jsonl").exists() {
        return Some(path);
    }
    println!("skipped: no corpus at {}", path.display());
    None
}
