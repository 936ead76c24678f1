//! What callers have to say about long work: where it runs, how far it is, and when to stop it.

mod jobs;
pub use jobs::{Alone, Jobs};
pub(crate) use jobs::{chunks, map};

mod progress;
pub use progress::{Control, Progress, Stage};
