//! What callers have to say about long work: where it runs, how far it is, and when to stop it.

mod jobs;
pub use jobs::{Alone, Job, Jobs, Priority, Rayon, StartError, Threads};
pub(crate) use jobs::{WithCaller, width};

mod helpers;
pub(crate) use helpers::{Helpers, WithHelpers};

mod map;
pub(crate) use map::{chunks, drop_later, map, map_with};

mod progress;
pub(crate) use progress::Counter;
#[cfg(test)]
pub(crate) use progress::looks::{assert_each_cancels, cancelled_at, so_far};
pub use progress::{Control, Progress, Stage};

mod call;
pub(crate) use call::Call;
